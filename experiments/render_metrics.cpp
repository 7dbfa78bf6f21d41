#include "experiments/render_metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>

namespace cvr::experiments {

namespace {

using L = const LineContext&;
using Pointer = Row::json_pointer;

/// The value at a place of the row of the render stage through `write`; the row's status where it is not ok.
std::string from_render(L line, const char* pointer, const std::function<std::string(const Row&)>& write) {
  const auto found = line.rows.find(Stage::kRender);
  if (found == line.rows.end() || found->second == nullptr) return "";
  const Row& row = *found->second;
  if (row.value("status", "") != kOk) return row.value("status", "");
  const Pointer at(pointer);
  return row.contains(at) ? write(row.at(at)) : "";
}

std::string number(L line, const char* pointer, int digits, double factor = 1) {
  return from_render(line, pointer, [&](const Row& value) {
    return value.is_number() ? fmt::format("{:.{}f}", value.get<double>() * factor, digits) : "";
  });
}

/// Four significant digits: frames take from microseconds to seconds.
std::string milliseconds(const Row& value) { return fmt::format("{:.4g}", value.get<double>()); }

std::string whole_milliseconds(L line) {
  return from_render(line, "", [](const Row& row) {
    return fmt::format("{:.4g}", row.at(Pointer("/frames/mean_ms")).get<double>() * whole_over_part(row));
  });
}

std::string milliseconds(L line, const char* pointer) {
  return from_render(line, pointer, [](const Row& value) { return milliseconds(value); });
}

/// "path; held", or the path's alone.
std::string path_and_held(L line) {
  return from_render(line, "", [](const Row& row) {
    const Pointer held("/held/median_ms");
    std::string text = milliseconds(row.at(Pointer("/frames/mean_ms")));
    if (row.contains(held)) text += "; " + milliseconds(row.at(held));
    return text;
  });
}

/// A PSNR has no number where the pictures are equal.
std::string psnr(const Row& value) {
  return value.is_number() ? fmt::format("{:.1f}", value.get<double>()) : "exact";
}

std::string start_seconds(L line) {
  return from_render(line, "/start", [](const Row& start) {
    double sum = 0;
    for (const auto& [name, seconds] : start.items()) sum += seconds.get<double>();
    return fmt::format("{:.3f}", sum);
  });
}

std::string of_each_jump_frame(L line, const std::function<std::string(const Row&)>& write) {
  return from_render(line, "/jump/frames", [&](const Row& frames) {
    std::string text;
    for (const Row& frame : frames) text += (text.empty() ? "" : " / ") + write(frame);
    return text;
  });
}

}  // namespace

std::span<const Metric> render_metrics() {
  static const Metric kMetrics[] = {
      {"frame_ms", "frame ms",
       "mean device time of a frame over the camera path, which begins with an empty cache",
       [](L l) { return milliseconds(l, "/frames/mean_ms"); }},
      {"frame_whole_ms", "frame ms, whole",
       "frame_ms times voxels of the original / voxels drawn: what the whole volume would take, slice by slice",
       whole_milliseconds},
      {"frame_median_ms", "median ms", "median device time of a frame of the path",
       [](L l) { return milliseconds(l, "/frames/median_ms"); }},
      {"frame_p95_ms", "p95 ms", "95 % of the path's frames take at most this long",
       [](L l) { return milliseconds(l, "/frames/p95_ms"); }},
      {"frame_p99_ms", "p99 ms", "99 % of the path's frames take at most this long",
       [](L l) { return milliseconds(l, "/frames/p99_ms"); }},
      {"first_frame_ms", "first frame ms",
       "device time of the path's first frame, with an empty cache, median of the rounds",
       [](L l) { return milliseconds(l, "/frames/first_frame_ms"); }},
      {"host_ms", "host ms",
       "median wall time of a frame as the program sees it: recording, submission, device, waiting",
       [](L l) { return milliseconds(l, "/frames/host_median_ms"); }},
      {"held_ms", "held ms",
       "median device time of a frame of the scene's held view, drawn anew each time, with the cache filled",
       [](L l) { return milliseconds(l, "/held/median_ms"); }},
      {"held_mean_ms", "held mean ms", "mean device time of such a frame",
       [](L l) { return milliseconds(l, "/held/mean_ms"); }},
      {"held_p95_ms", "held p95 ms", "95 % of these frames take at most this long",
       [](L l) { return milliseconds(l, "/held/p95_ms"); }},
      {"held_frames", "held frames", "frames of the held view a round",
       [](L l) { return number(l, "/held/count", 0); }},
      {"held_incomplete", "held incomplete px", "most pixels of one of these frames that met a placeholder",
       [](L l) { return number(l, "/held/incomplete/largest", 0); }},
      {"held_cells_decoded", "held decoded",
       "labels decoded for one of these frames, in the marcher and for the cache",
       [](L l) { return number(l, "/held/cells_decoded", 0); }},
      {"held_cache", "held cache",
       "all: the cache holds all that the held view needs; part: such a frame still decodes",
       [](L l) {
         return from_render(l, "/held/cache_complete", [](const Row& complete) {
           return complete.is_null() ? "" : complete.get<bool>() ? "all" : "part";
         });
       }},
      {"frame_held_ms", "path; held ms",
       "mean device time of a frame over the camera path, which begins with an empty cache; median of a "
       "frame of the held view "
       "with the cache filled",
       path_and_held},
      {"published_frame_ms", "published ms",
       "the mean ms a frame that the publication states, on its GPU and its volume",
       [](L l) {
         return l.published != nullptr && l.published->frame_ms
                    ? fmt::format("{:.1f}", *l.published->frame_ms)
                    : std::string();
       }},
      {"incomplete", "incomplete px", "most pixels of one frame that met a placeholder",
       [](L l) { return number(l, "/frames/incomplete/largest", 0); }},
      {"exact_after_frames", "exact after",
       "most frames of a view, from an empty cache, until its picture is exact",
       [](L l) { return number(l, "/exact_after_frames", 0); }},
      {"label_mismatches", "wrong px",
       "pixels of three views whose label is not that of the reference and no near-tie; one fails the cell",
       [](L l) { return number(l, "/verification/label_mismatches", 0); }},
      {"near_ties", "near-ties",
       "pixels whose label is that of the reference with the ray moved by 10^-4 voxels",
       [](L l) { return number(l, "/verification/near_ties", 0); }},
      {"psnr_db", "PSNR dB",
       "of exact pictures against the reference in double precision, the worst of three views",
       [](L l) { return from_render(l, "/verification/psnr_db", psnr); }},
      {"picture_psnr_db", "picture PSNR dB",
       "of the picture with its levels and samples against level bias 0 and 256 samples",
       [](L l) { return from_render(l, "/picture_error/psnr_db", psnr); }},
      {"picture_ssim", "picture SSIM", "structural similarity of the same two pictures",
       [](L l) { return number(l, "/picture_error/ssim", 4); }},
      {"picture_label_errors", "other labels px",
       "pixels of the picture whose label is not that of level bias 0",
       [](L l) { return number(l, "/picture_error/label_mismatches", 0); }},
      {"jump_psnr_db", "PSNR dB after a jump",
       "of each frame after the camera has jumped to a view that the cache has not seen",
       [](L l) { return of_each_jump_frame(l, [](const Row& f) { return psnr(f["psnr_db"]); }); }},
      {"jump_label_errors", "wrong px after a jump", "pixels with a wrong label in each of these frames",
       [](L l) { return of_each_jump_frame(l, [](const Row& f) { return f["label_mismatches"].dump(); }); }},
      {"jump_ms", "ms after a jump", "device time of each of these frames",
       [](L l) {
         return of_each_jump_frame(l,
                                   [](const Row& f) { return fmt::format("{:.3g}", f["ms"].get<double>()); });
       }},
      {"gpu_mib", "GPU MiB", "device memory of encoding, cache, tables and images",
       [](L l) { return number(l, "/memory/gpu_bytes", 1, 1.0 / (1 << 20)); }},
      {"cells_read", "cells read", "labels asked for by the rays of the whole path",
       [](L l) { return number(l, "/counters/cells_read", 0); }},
      {"cells_decoded", "cells decoded",
       "labels decoded for the whole path, in the marcher and for the cache",
       [](L l) { return number(l, "/counters/cells_decoded", 0); }},
      {"bytes_touched", "MiB touched", "MiB of the encoding read for the whole path",
       [](L l) { return number(l, "/counters/words_touched", 2, 4.0 / (1 << 20)); }},
      {"needed_ratio", "decoded/needed",
       "cells decoded for exact pictures of three views, each from an empty cache / different cells that "
       "these views need",
       [](L l) { return number(l, "/needed/decoded_over_needed", 2); }},
      {"start_s", "start s", "upload, compiling the kernels, and the scene's first pass", start_seconds},
  };
  return kMetrics;
}

const Metric* published_beside(const Metric& metric) {
  static constexpr std::array kTimesOfFrames{"frame_ms", "held_ms", "frame_held_ms"};
  return std::ranges::find(kTimesOfFrames, metric.name) == kTimesOfFrames.end()
             ? nullptr
             : find_metric("published_frame_ms");
}

}  // namespace cvr::experiments
