#include "experiments/config/former_names.hpp"

#include <algorithm>

namespace cvr::experiments {

namespace {

struct Renamed {
  std::string_view former, name;
};

constexpr Renamed kRenamed[] = {
    // keys
    {"caches", "access_modes"},
    {"held_frames", "warm_frames"},
    {"held", "fixed_view"},
    {"picture_error", "image_error"},
    {"keep_pictures", "keep_images"},
    // labels of lines, and a key of published figures
    {"cache", "access_mode"},
    // metrics
    {"held_ms", "warm_ms"},
    {"held_mean_ms", "warm_mean_ms"},
    {"held_p95_ms", "warm_p95_ms"},
    {"held_incomplete", "warm_incomplete"},
    {"held_cells_decoded", "warm_cells_decoded"},
    {"held_cache", "warm_cache"},
    {"frame_held_ms", "frame_warm_ms"},
    {"exact_after_frames", "converged_after"},
    {"picture_psnr_db", "image_psnr_db"},
    {"picture_ssim", "image_ssim"},
    {"picture_label_errors", "image_label_errors"},
};

}  // namespace

std::string_view current_name(std::string_view name) {
  const auto found = std::ranges::find(kRenamed, name, &Renamed::former);
  return found == std::end(kRenamed) ? name : found->name;
}

std::string_view former_name(std::string_view name) {
  const auto found = std::ranges::find(kRenamed, name, &Renamed::name);
  return found == std::end(kRenamed) ? std::string_view() : found->former;
}

}  // namespace cvr::experiments
