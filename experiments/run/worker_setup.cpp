#include "experiments/run/worker_setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <thread>

namespace cvr::experiments {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kLeastFile =
    std::uint64_t{16} << 20;  ///< bytes that a worker may write where the disk is nearly full

/// OUT/pictures/DATASET-CODEC-SCENE-ID, whatever characters the names have.
std::string place_of_pictures(const PlannedCell& planned, const std::string& out) {
  std::string name = fmt::format("{}-{}-{}-{}", planned.cell.dataset->name, planned.cell.codec,
                                 fs::path(planned.cell.render->scene).stem().string(), planned.id);
  std::ranges::replace_if(
      name,
      [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '_' && c != '.'; },
      '_');
  const fs::path folder = fs::path(out) / "pictures";
  fs::create_directories(folder);
  return fs::absolute(folder / name).string();
}

}  // namespace

WorkerSpec make_spec(const Config& config, const PlannedCell& planned, const RawCopy& copy,
                     const RunFolder& folder) {
  WorkerSpec spec;
  spec.location = *planned.location;
  spec.raw_path = copy.path;
  spec.codec = planned.cell.codec;
  spec.parameters = planned.cell.parameters.canonical();
  spec.stage = planned.cell.stage->id;
  spec.threads = planned.cell.threads.count;
  spec.bytes_per_voxel = planned.cell.dataset->bytes_per_voxel;
  spec.memory_limit = static_cast<std::uint64_t>(config.memory_limit_gib * (1 << 30));
  spec.scratch = folder.scratch();
  spec.seed = config.seed;
  spec.lods = config.lods;
  spec.render = planned.cell.render;
  if (spec.render && spec.render->keep_images)
    spec.pictures = place_of_pictures(planned, folder.path());
  return spec;
}

WorkerLimits limits_of(const Config& config, const WorkerSpec& spec) {
  // The check, all rounds but the last, and the last, each by the time-out.
  const double seconds =
      3 * config.timeout_s * std::max(std::thread::hardware_concurrency(), spec.threads) + 10;
  std::error_code error;
  const fs::space_info disk = fs::space(spec.scratch, error);
  return {static_cast<std::uint64_t>(std::min(seconds, 1e9)),
          error ? 0 : std::max<std::uint64_t>(kLeastFile, disk.available / 2)};
}

std::string revision_of(const std::string& program) {
  const std::string line = first_line_of(fs::canonical(program).string(), "--version");
  const std::size_t from = line.find('('), to = line.find(')');
  return from == std::string::npos || to == std::string::npos
             ? line
             : line.substr(from + 1, to - from - 1);
}

}  // namespace cvr::experiments
