#include "experiments/analysis/render_metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>

#include "experiments/results/statistics.hpp"

namespace cvr::experiments {

namespace {

using L = const LineContext&;
using Pointer = Row::json_pointer;

/// The value at a place of the row of the render stage through `read`; the row's status where it is
/// not ok.
Reading from_render(L line, const char* pointer, const std::function<Reading(const Row&)>& read) {
  const Row* found = line.rows.find(kRender);
  if (found == nullptr) return "";
  const Row& row = *found;
  if (row.value("status", "") != kOk) return row.value("status", "");
  const Pointer at(pointer);
  return row.contains(at) ? read(row.at(at)) : "";
}

Reading number(L line, const char* pointer, int digits, double factor = 1) {
  return from_render(line, pointer, [&](const Row& value) -> Reading {
    if (!value.is_number()) return "";
    const double scaled = value.get<double>() * factor;
    return {fmt::format("{:.{}f}", scaled, digits), scaled};
  });
}

/// Four significant digits: frames take from microseconds to seconds.
std::string milliseconds(const Row& value) { return fmt::format("{:.4g}", value.get<double>()); }

/// Milliseconds of the frames of each round after the first; of a single round where there is but
/// one.
std::vector<std::vector<double>> counted_rounds(const Row& frames) {
  auto rounds = frames.value("ms", std::vector<std::vector<double>>{});
  if (rounds.size() > 1) rounds.erase(rounds.begin());
  return rounds;
}

/// A statistic of "frames" or "held". `of_round`: the same of the frames of one round; each counted
/// round is a repetition.
Reading frame_time(L line, const char* series, const char* statistic,
                   double (*of_round)(std::vector<double>)) {
  return from_render(line, series, [&](const Row& frames) -> Reading {
    if (!frames.contains(statistic)) return "";
    std::vector<double> repetitions;
    for (const auto& ms : counted_rounds(frames)) repetitions.push_back(of_round(ms));
    const Row& value = frames[statistic];
    return timed({milliseconds(value), value.get<double>()}, repetitions);
  });
}

double mean_of_round(std::vector<double> ms) {
  double sum = 0;
  for (const double one : ms) sum += one;
  return sum / static_cast<double>(ms.size());
}

template <int kPercent>
double quantile_of_round(std::vector<double> ms) {
  std::ranges::sort(ms);
  return quantile(ms, kPercent / 100.0);
}

double first_of_round(std::vector<double> ms) { return ms.front(); }

/// All frames of the held view show the same: each is a repetition.
Reading held_median(L line) {
  return from_render(line, "/held", [](const Row& held) -> Reading {
    if (!held.contains("median_ms")) return "";
    std::vector<double> repetitions;
    for (const auto& ms : counted_rounds(held))
      repetitions.insert(repetitions.end(), ms.begin(), ms.end());
    return timed({milliseconds(held["median_ms"]), held["median_ms"].get<double>()}, repetitions);
  });
}

/// "path; held", or the path's alone.
Reading path_and_held(L line) {
  return from_render(line, "", [](const Row& row) {
    const Pointer held("/held/median_ms");
    std::string text = milliseconds(row.at(Pointer("/frames/mean_ms")));
    if (row.contains(held)) text += "; " + milliseconds(row.at(held));
    return text;
  });
}

/// A PSNR has no number where the pictures are equal.
Reading psnr(const Row& value) {
  if (!value.is_number()) return {"exact", std::numeric_limits<double>::infinity()};
  return {fmt::format("{:.1f}", value.get<double>()), value.get<double>()};
}

Reading start_seconds(L line) {
  return from_render(line, "/start", [](const Row& start) {
    double sum = 0;
    for (const auto& [name, seconds] : start.items()) sum += seconds.get<double>();
    return timed({fmt::format("{:.3f}", sum), sum}, {});
  });
}

Reading of_each_jump_frame(L line, const std::function<std::string(const Row&)>& write) {
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
       [](L l) { return frame_time(l, "/frames", "mean_ms", mean_of_round); }},
      {"frame_whole_ms", "frame ms, whole",
       "frame_ms times voxels of the original / voxels drawn: what the whole volume would take, "
       "slice by slice",
       [](L l) {
         const Reading part = frame_time(l, "/frames", "mean_ms", mean_of_round);
         return part.number ? of_whole(part, *l.rows.find(kRender)) : part;
       }},
      {"frame_median_ms", "median ms", "median device time of a frame of the path",
       [](L l) { return frame_time(l, "/frames", "median_ms", quantile_of_round<50>); }},
      {"frame_min_ms", "min ms", "the least device time of a frame of the path",
       [](L l) { return frame_time(l, "/frames", "min_ms", quantile_of_round<0>); }},
      {"frame_max_ms", "max ms", "the largest device time of a frame of the path",
       [](L l) { return frame_time(l, "/frames", "max_ms", quantile_of_round<100>); }},
      {"frame_wall_ms", "wall ms",
       "mean wall time of a frame over the camera path, from the end of one wait for the device to "
       "the end of the next",
       [](L l) { return timed(number(l, "/frames/wall/mean_ms", 3), {}); }},
      {"frame_p95_ms", "p95 ms", "95 % of the path's frames take at most this long",
       [](L l) { return frame_time(l, "/frames", "p95_ms", quantile_of_round<95>); }},
      {"frame_p99_ms", "p99 ms", "99 % of the path's frames take at most this long",
       [](L l) { return frame_time(l, "/frames", "p99_ms", quantile_of_round<99>); }},
      {"first_frame_ms", "first frame ms",
       "device time of the path's first frame, with an empty cache, median of the rounds",
       [](L l) { return frame_time(l, "/frames", "first_frame_ms", first_of_round); }},
      {"host_ms", "host ms",
       "median wall time of a frame as the program sees it: recording, submission, device, waiting",
       [](L l) { return timed(number(l, "/frames/host_median_ms", 2), {}); }},
      {"held_ms", "held ms",
       "median device time of a frame of the scene's held view, drawn anew each time, with the "
       "cache filled",
       held_median},
      {"held_mean_ms", "held mean ms", "mean device time of such a frame",
       [](L l) { return frame_time(l, "/held", "mean_ms", mean_of_round); }},
      {"held_p95_ms", "held p95 ms", "95 % of these frames take at most this long",
       [](L l) { return frame_time(l, "/held", "p95_ms", quantile_of_round<95>); }},
      {"held_frames", "held frames", "frames of the held view a round",
       [](L l) { return number(l, "/held/count", 0); }},
      {"held_incomplete", "held incomplete px",
       "most pixels of one of these frames that met a placeholder",
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
       },
       false},
      {"frame_held_ms", "path; held ms",
       "mean device time of a frame over the camera path, which begins with an empty cache; median "
       "of a "
       "frame of the held view "
       "with the cache filled",
       path_and_held, false},
      {"published_frame_ms", "published ms",
       "the mean ms a frame that the publication states, on its GPU and its volume",
       [](L l) -> Reading {
         if (l.published == nullptr || !l.published->frame_ms) return "";
         return {fmt::format("{:.1f}", *l.published->frame_ms), *l.published->frame_ms};
       }},
      {"incomplete", "incomplete px", "most pixels of one frame that met a placeholder",
       [](L l) { return number(l, "/frames/incomplete/largest", 0); }},
      {"exact_after_frames", "exact after",
       "most frames of a view, from an empty cache, until its picture is exact",
       [](L l) { return number(l, "/exact_after_frames", 0); }},
      {"label_mismatches", "wrong px",
       "pixels of three views whose label is not that of the reference and no near-tie; one fails "
       "the cell",
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
       [](L l) {
         return of_each_jump_frame(l, [](const Row& f) { return psnr(f["psnr_db"]).text; });
       },
       false},
      {"first_jump_psnr_db", "PSNR dB of the first frame", "of the first frame after such a jump",
       [](L l) { return from_render(l, "/jump/frames/0/psnr_db", psnr); }},
      {"first_jump_label_errors", "wrong px of the first frame",
       "pixels with a wrong label in the first frame after such a jump",
       [](L l) { return number(l, "/jump/frames/0/label_mismatches", 0); }},
      {"jump_label_errors", "wrong px after a jump",
       "pixels with a wrong label in each of these frames",
       [](L l) {
         return of_each_jump_frame(l, [](const Row& f) { return f["label_mismatches"].dump(); });
       },
       false},
      {"jump_ms", "ms after a jump", "device time of each of these frames",
       [](L l) {
         return of_each_jump_frame(
             l, [](const Row& f) { return fmt::format("{:.3g}", f["ms"].get<double>()); });
       },
       false},
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
       "cells decoded for exact pictures of three views, each from an empty cache / different "
       "cells that "
       "these views need",
       [](L l) { return number(l, "/needed/decoded_over_needed", 2); }},
      {"start_s", "start s", "upload, compiling the kernels, and the scene's first pass",
       start_seconds},
  };
  return kMetrics;
}

const Metric* published_beside(const Metric& metric) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kBeside{
      {{"frame_ms", "published_frame_ms"},
       {"frame_wall_ms", "published_frame_ms"},
       {"held_ms", "published_frame_ms"},
       {"frame_held_ms", "published_frame_ms"},
       {"published_rate", "published"},
       {"encode_seconds", "published_seconds"},
       {"encode_gb_per_s", "published_gb_per_s"}}};
  const auto found =
      std::ranges::find(kBeside, metric.name, [](const auto& pair) { return pair.first; });
  return found == kBeside.end() ? nullptr : find_metric(found->second);
}

}  // namespace cvr::experiments
