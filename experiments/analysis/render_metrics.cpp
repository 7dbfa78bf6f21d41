#include "experiments/analysis/render_metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>

#include "experiments/analysis/figures.hpp"
#include "experiments/results/statistics.hpp"

namespace cvr::experiments {

namespace {

using L = const LineContext&;
using Frames = Parts::Frames;
using Held = Parts::Held;

template <auto... Members>
constexpr ReadFigure of_frames = figure<&Result::frames, Members...>;
template <auto... Members>
constexpr ReadFigure of_held = figure<&Result::held, Members...>;
template <auto Member>
constexpr ReadFigure of_verification = figure<&Result::verification, Member>;
template <auto Member>
constexpr ReadFigure of_picture_error = figure<&Result::picture_error, Member>;

/// The row of the render stage through `read`; its status where it is not ok.
Reading from_render(L line, const std::function<Reading(const Result&)>& read) {
  const Result* row = line.rows.find(kRender);
  if (row == nullptr) return "";
  return row->is_ok() ? read(*row) : row->status;
}

Reading number(L line, const std::function<Figure(const Result&)>& figure, int digits,
               double factor = 1) {
  return from_render(line, [&](const Result& row) -> Reading {
    const Figure value = figure(row);
    if (!value) return "";
    return {fmt::format("{:.{}f}", *value * factor, digits), *value * factor};
  });
}

/// Of the counter of this name.
Reading counter(L line, const char* name, int digits, double factor = 1) {
  const auto read = [&](const Result& row) {
    const std::uint64_t* count = row.counters ? row.counters->find(name) : nullptr;
    return count == nullptr ? Figure() : Figure(static_cast<double>(*count));
  };
  return number(line, read, digits, factor);
}

/// Four significant digits: frames take from microseconds to seconds.
std::string milliseconds(double value) { return fmt::format("{:.4g}", value); }

/// Milliseconds of the frames of each round after the first; of a single round where there is but
/// one.
std::span<const std::vector<double>> counted_rounds(const Parts::FrameTimes& frames) {
  const std::span<const std::vector<double>> rounds = frames.ms;
  return rounds.subspan(rounds.size() > 1 ? 1 : 0);
}

/// A statistic of "frames" or "held". `of_round`: the same of the frames of one round; each counted
/// round is a repetition.
template <class F>
Reading frame_time(L line, std::optional<F> Parts::*series,
                   std::type_identity_t<Figure F::*> statistic,
                   double (*of_round)(std::vector<double>)) {
  return from_render(line, [&](const Result& row) -> Reading {
    const std::optional<F>& frames = row.*series;
    if (!frames || !((*frames).*statistic)) return "";
    std::vector<double> repetitions;
    for (const auto& ms : counted_rounds(*frames)) repetitions.push_back(of_round(ms));
    const double value = *((*frames).*statistic);
    return timed({milliseconds(value), value}, repetitions);
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

/// All frames of the fixed view show the same: each is a repetition.
Reading held_median(L line) {
  return from_render(line, [](const Result& row) -> Reading {
    if (!row.held || !row.held->median_ms) return "";
    std::vector<double> repetitions;
    for (const auto& ms : counted_rounds(*row.held))
      repetitions.insert(repetitions.end(), ms.begin(), ms.end());
    return timed({milliseconds(*row.held->median_ms), *row.held->median_ms}, repetitions);
  });
}

/// "path; held", or the path's alone.
Reading path_and_held(L line) {
  return from_render(line, [](const Result& row) -> Reading {
    const Figure path = of_frames<&Frames::mean_ms>(row);
    const Figure held = of_held<&Held::median_ms>(row);
    if (!path) return "";
    return milliseconds(*path) + (held ? "; " + milliseconds(*held) : "");
  });
}

/// What the caches of a cell are put under, by its choice and the extent of its volume.
Reading of_regime(L line, double (*figure)(const RenderChoice&, const volumes::Extent&),
                  int digits) {
  return from_render(line, [&](const Result& row) -> Reading {
    if (!row.render || !row.dataset.extent) return "";
    const auto& [x, y, z] = *row.dataset.extent;
    const double value = figure(render_choice_from_row(*row.render), {x, y, z});
    if (value == 0) return "";
    return {fmt::format("{:.{}f}", value, digits), value};
  });
}

double bricks_of(const RenderChoice& choice, const volumes::Extent& extent) {
  return static_cast<double>(volumes::ceil_div(extent, choice.brick).voxels());
}

double cache_bytes_per_voxel(const RenderChoice& choice, const volumes::Extent& extent) {
  return static_cast<double>(choice.cache_mib << 20) / static_cast<double>(extent.voxels());
}

double voxels_per_pixel(const RenderChoice& choice, const volumes::Extent& extent) {
  return static_cast<double>(extent.voxels()) / (1.0 * choice.width * choice.height);
}

double frames_per_brick(const RenderChoice& choice, const volumes::Extent& extent) {
  return choice.frames / bricks_of(choice, extent);
}

/// A PSNR has no number where the images are equal.
Reading psnr(const Figure& value) {
  if (!value) return {"exact", std::numeric_limits<double>::infinity()};
  return {fmt::format("{:.1f}", *value), *value};
}

Reading start_seconds(L line) {
  return from_render(line, [](const Result& row) -> Reading {
    if (!row.start) return "";
    double sum = 0;
    for (const auto& [name, seconds] : *row.start) sum += seconds;
    return timed({fmt::format("{:.3f}", sum), sum});
  });
}

Reading of_each_jump_frame(L line,
                           const std::function<std::string(const Parts::JumpFrame&)>& write) {
  return from_render(line, [&](const Result& row) -> Reading {
    if (!row.jump) return "";
    std::string text;
    for (const Parts::JumpFrame& frame : row.jump->frames)
      text += (text.empty() ? "" : " / ") + write(frame);
    return text;
  });
}

/// Of the first frame after a jump.
Reading first_after_jump(L line, const std::function<Reading(const Parts::JumpFrame&)>& read) {
  return from_render(line, [&](const Result& row) -> Reading {
    return row.jump && !row.jump->frames.empty() ? read(row.jump->frames.front()) : "";
  });
}

}  // namespace

std::span<const Metric> render_metrics() {
  static const Metric kMetrics[] = {
      {"frame_ms", "frame ms",
       "mean device time of a frame over the camera path, which begins with an empty cache",
       [](L l) { return frame_time(l, &Result::frames, &Frames::mean_ms, mean_of_round); }},
      {"frame_whole_ms", "frame ms, whole",
       "frame_ms times voxels of the original / voxels drawn: what the whole volume would take, "
       "slice by slice",
       [](L l) {
         const Reading part = frame_time(l, &Result::frames, &Frames::mean_ms, mean_of_round);
         return part.number ? of_whole(part, *l.rows.find(kRender)) : part;
       }},
      {"frame_median_ms", "median ms", "median device time of a frame of the path",
       [](L l) {
         return frame_time(l, &Result::frames, &Frames::median_ms, quantile_of_round<50>);
       }},
      {"frame_min_ms", "min ms", "the least device time of a frame of the path",
       [](L l) { return frame_time(l, &Result::frames, &Frames::min_ms, quantile_of_round<0>); }},
      {"frame_max_ms", "max ms", "the largest device time of a frame of the path",
       [](L l) { return frame_time(l, &Result::frames, &Frames::max_ms, quantile_of_round<100>); }},
      {"frame_wall_ms", "wall ms",
       "mean wall time of a frame over the camera path, from the end of one wait for the device to "
       "the end of the next",
       [](L l) { return timed(number(l, of_frames<&Frames::wall, &Parts::Spread::mean_ms>, 3)); }},
      {"frame_p95_ms", "p95 ms", "95 % of the path's frames take at most this long",
       [](L l) { return frame_time(l, &Result::frames, &Frames::p95_ms, quantile_of_round<95>); }},
      {"frame_p99_ms", "p99 ms", "99 % of the path's frames take at most this long",
       [](L l) { return frame_time(l, &Result::frames, &Frames::p99_ms, quantile_of_round<99>); }},
      {"first_frame_ms", "first frame ms",
       "device time of the path's first frame, with an empty cache, median of the rounds",
       [](L l) { return frame_time(l, &Result::frames, &Frames::first_frame_ms, first_of_round); }},
      {"host_ms", "host ms",
       "median wall time of a frame as the program sees it: recording, submission, device, waiting",
       [](L l) { return timed(number(l, of_frames<&Frames::host_median_ms>, 2)); }},
      {"warm_ms", "warm ms",
       "median device time of a frame of the scene's fixed view, drawn anew each time, with the "
       "cache filled",
       held_median},
      {"warm_mean_ms", "warm mean ms", "mean device time of such a frame",
       [](L l) { return frame_time(l, &Result::held, &Held::mean_ms, mean_of_round); }},
      {"warm_p95_ms", "warm p95 ms", "95 % of these frames take at most this long",
       [](L l) { return frame_time(l, &Result::held, &Held::p95_ms, quantile_of_round<95>); }},
      {"warm_frames", "warm frames", "frames of the fixed view per round",
       [](L l) { return number(l, of_held<&Held::count>, 0); }},
      {"warm_incomplete", "warm incomplete px",
       "most pixels of one of these frames that met a placeholder",
       [](L l) { return number(l, of_held<&Held::incomplete, &Parts::Incomplete::largest>, 0); }},
      {"warm_cells_decoded", "warm decoded",
       "labels decoded for one of these frames, in the marcher and for the cache",
       [](L l) { return number(l, of_held<&Held::cells_decoded>, 0); }},
      {"warm_cache", "warm cache",
       "all: the cache holds all that the fixed view needs; part: such a frame still decodes",
       [](L l) {
         return from_render(l, [](const Result& row) -> Reading {
           if (!row.held || !row.held->cache_complete || !*row.held->cache_complete) return "";
           return **row.held->cache_complete ? "all" : "part";
         });
       },
       false},
      {"frame_warm_ms", "path; warm ms",
       "mean device time of a frame over the camera path, which begins with an empty cache; median "
       "of a frame of the fixed view with the cache filled",
       path_and_held, false},
      {"published_frame_ms", "published ms",
       "the mean ms per frame that the publication states, on its GPU and its volume",
       [](L l) { return published_reading(l, &PublishedFigure::frame_ms, 1); }, true, true},
      {"logged_frame_min_ms", "logged min ms",
       "the fastest frame in a log of the publication's authors, of another run than it states",
       [](L l) { return published_reading(l, &PublishedFigure::logged_frame_min_ms, 3); }, true,
       true},
      {"logged_frame_ms", "logged ms", "the mean ms per frame of that log",
       [](L l) { return published_reading(l, &PublishedFigure::logged_frame_ms, 3); }, true, true},
      {"logged_frame_max_ms", "logged max ms", "the slowest frame of that log",
       [](L l) { return published_reading(l, &PublishedFigure::logged_frame_max_ms, 3); }, true,
       true},
      {"bricks", "bricks", "bricks of the volume", [](L l) { return of_regime(l, bricks_of, 0); }},
      {"published_bricks", "published bricks", "the same of the publication's volume",
       [](L l) { return published_reading(l, &PublishedFigure::bricks, 0); }, true, true},
      {"cache_bytes_per_voxel", "cache B/voxel",
       "bytes of the cache / voxels of the volume: 4 and more hold every label",
       [](L l) { return of_regime(l, cache_bytes_per_voxel, 4); }},
      {"published_cache_bytes_per_voxel", "published B/voxel", "the same in the publication",
       [](L l) { return published_reading(l, &PublishedFigure::cache_bytes_per_voxel, 4); }, true,
       true},
      {"voxels_per_pixel", "voxels/px", "voxels of the volume / pixels of a frame",
       [](L l) { return of_regime(l, voxels_per_pixel, 0); }},
      {"published_voxels_per_pixel", "published voxels/px", "the same in the publication",
       [](L l) { return published_reading(l, &PublishedFigure::voxels_per_pixel, 0); }, true, true},
      {"frames_per_brick", "frames/brick", "frames of the path / bricks of the volume",
       [](L l) { return of_regime(l, frames_per_brick, 4); }},
      {"published_frames_per_brick", "published frames/brick", "the same in the publication",
       [](L l) { return published_reading(l, &PublishedFigure::frames_per_brick, 4); }, true, true},
      {"incomplete", "incomplete px", "most pixels of one frame that met a placeholder",
       [](L l) {
         return number(l, of_frames<&Frames::incomplete, &Parts::Incomplete::largest>, 0);
       }},
      {"converged_after", "converged after",
       "most frames of a view, from an empty cache, until its image is converged",
       [](L l) { return number(l, figure<&Result::exact_after_frames>, 0); }},
      {"label_mismatches", "wrong px",
       "pixels of three views whose label is not that of the reference and no near-tie; one fails "
       "the cell",
       [](L l) { return number(l, of_verification<&Parts::Verification::label_mismatches>, 0); }},
      {"near_ties", "near-ties",
       "pixels whose label is that of the reference with the ray moved by 10^-4 voxels",
       [](L l) { return number(l, of_verification<&Parts::Verification::near_ties>, 0); }},
      {"psnr_db", "PSNR dB",
       "of converged images against the reference in double precision, the worst of three views",
       [](L l) {
         return from_render(l, [](const Result& row) -> Reading {
           const auto found = row.verification ? row.verification->psnr_db : std::nullopt;
           return found ? psnr(*found) : "";
         });
       }},
      {"image_psnr_db", "image PSNR dB",
       "of the image with its levels and samples against level bias 0 and 256 samples",
       [](L l) {
         return from_render(l, [](const Result& row) -> Reading {
           return row.picture_error ? psnr(row.picture_error->psnr_db) : "";
         });
       }},
      {"image_ssim", "image SSIM", "structural similarity of the same two images",
       [](L l) { return number(l, of_picture_error<&Parts::PictureError::ssim>, 4); }},
      {"image_label_errors", "other labels px",
       "pixels of the image whose label is not that of level bias 0",
       [](L l) { return number(l, of_picture_error<&Parts::PictureError::label_mismatches>, 0); }},
      {"jump_psnr_db", "PSNR dB after a jump",
       "of each frame after the camera has jumped to a view that the cache has not seen",
       [](L l) {
         return of_each_jump_frame(l, [](const auto& f) { return psnr(f.psnr_db).text; });
       },
       false},
      {"first_jump_psnr_db", "PSNR dB of the first frame", "of the first frame after such a jump",
       [](L l) { return first_after_jump(l, [](const auto& f) { return psnr(f.psnr_db); }); }},
      {"first_jump_label_errors", "wrong px of the first frame",
       "pixels with a wrong label in the first frame after such a jump",
       [](L l) {
         return first_after_jump(l, [](const auto& f) -> Reading {
           return {std::to_string(f.label_mismatches), static_cast<double>(f.label_mismatches)};
         });
       }},
      {"jump_label_errors", "wrong px after a jump",
       "pixels with a wrong label in each of these frames",
       [](L l) {
         return of_each_jump_frame(
             l, [](const auto& f) { return std::to_string(f.label_mismatches); });
       },
       false},
      {"jump_ms", "ms after a jump", "device time of each of these frames",
       [](L l) {
         return of_each_jump_frame(l, [](const auto& f) { return fmt::format("{:.3g}", f.ms); });
       },
       false},
      {"gpu_mib", "GPU MiB", "device memory of encoding, cache, tables and images",
       [](L l) {
         return number(l, figure<&Result::memory, &Parts::Memory::gpu_bytes>, 1, 1.0 / (1 << 20));
       }},
      {"cells_read", "cells read", "labels asked for by the rays of the whole path",
       [](L l) { return counter(l, "cells_read", 0); }},
      {"cells_decoded", "cells decoded",
       "labels decoded for the whole path, in the marcher and for the cache",
       [](L l) { return counter(l, "cells_decoded", 0); }},
      {"bytes_touched", "MiB touched", "MiB of the encoding read for the whole path",
       [](L l) { return counter(l, "words_touched", 2, 4.0 / (1 << 20)); }},
      {"needed_ratio", "decoded/needed",
       "cells decoded for converged images of three views, each from an empty cache / different "
       "cells that "
       "these views need",
       [](L l) {
         return number(l, figure<&Result::needed, &Parts::Needed::decoded_over_needed>, 2);
       }},
      {"start_s", "start s", "upload, compiling the kernels, and the scene's first pass",
       start_seconds},
  };
  return kMetrics;
}

const Metric* published_beside(const Metric& metric) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kBeside{
      {{"frame_ms", "published_frame_ms"},
       {"frame_wall_ms", "published_frame_ms"},
       {"warm_ms", "published_frame_ms"},
       {"frame_warm_ms", "published_frame_ms"},
       {"published_rate", "published"},
       {"encode_seconds", "published_seconds"},
       {"encode_gb_per_s", "published_gb_per_s"}}};
  const auto found =
      std::ranges::find(kBeside, metric.name, [](const auto& pair) { return pair.first; });
  return found == kBeside.end() ? nullptr : find_metric(found->second);
}

}  // namespace cvr::experiments
