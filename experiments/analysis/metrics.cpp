#include "experiments/analysis/metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>

#include "experiments/analysis/figures.hpp"
#include "experiments/analysis/render_metrics.hpp"

namespace cvr::experiments {

namespace {

using Size = Parts::Size;
using Time = Parts::Time;
using Error = Parts::Error;
using Labels = Parts::LabelStatistics;
using DatasetFacts = Result::Dataset;
template <auto Member>
constexpr ReadFigure of_size = figure<&Result::size, Member>;
template <auto Member>
constexpr ReadFigure of_error = figure<&Result::error, Member>;
template <auto Member>
constexpr ReadFigure of_time = figure<&Result::time, Member>;
template <auto Member>
constexpr ReadFigure of_labels = figure<&Result::label_statistics, Member>;
template <auto Member>
constexpr ReadFigure of_dataset = figure<&Result::dataset, Member>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Reading reading_of(double number, int digits) {
  return {fmt::format("{:.{}f}", number, digits), number};
}

/// The row of a stage through `read`, or its status.
Reading from_stage(const LineContext& line, std::string_view stage,
                   const std::function<Reading(const Result&)>& read) {
  const Result* row = line.rows.find(stage);
  if (row == nullptr) return "";
  return row->is_ok() ? read(*row) : row->status;
}

/// A number of the row of one stage, or that row's status.
Reading from_stage(const LineContext& line, std::string_view stage, ReadFigure figure, int digits,
                   double factor = 1) {
  return from_stage(line, stage, [&](const Result& row) -> Reading {
    const Figure value = figure(row);
    return value ? reading_of(*value * factor, digits) : "";
  });
}

/// The first row that is ok and knows the sizes; else the first status.
Reading from_any(const LineContext& line, ReadFigure figure, int digits) {
  if (line.pseudo) return "";
  std::string status;
  for (const auto& [stage, row] : line.rows) {
    if (row == nullptr) continue;
    if (row->is_ok()) {
      if (const Figure value = figure(*row)) return reading_of(*value, digits);
    } else if (status.empty() && row->status != kUnsupported) {
      status = row->status;
    }
  }
  if (!status.empty()) return status;
  const bool any =
      std::ranges::any_of(line.rows, [](const auto& entry) { return entry.second != nullptr; });
  return any ? std::string(kUnsupported) : "";
}

/// Of codecs with an entropy coder of their own; the others say nothing.
Reading entropy_gap(const LineContext& line) {
  return from_stage(line, kEncode, [](const Result& row) -> Reading {
    const Figure entropy = of_size<&Size::entropy_bytes>(row);
    if (!entropy || *entropy == 0) return "";
    double stored = 0;
    for (const auto& [name, bytes] : row.size->breakdown.value_or(Named<std::uint64_t>()))
      if (name == "operations" || name == "stop_bits") stored += static_cast<double>(bytes);
    return reading_of(100.0 * (stored / *entropy - 1.0), 2);
  });
}

/// What CSGV-R stores beside its bit vectors to count in them; other formats say nothing.
Reading rank_overhead(const LineContext& line) {
  return from_stage(line, kEncode, [](const Result& row) -> Reading {
    double vectors = 0, rank = 0;
    for (const auto& [name, bytes] : row.size->breakdown.value_or(Named<std::uint64_t>())) {
      if (name == "operations" || name == "stop_bits") vectors += static_cast<double>(bytes);
      if (name == "rank") rank += static_cast<double>(bytes);
    }
    if (rank == 0 || vectors == 0) return "";
    return reading_of(100.0 * rank / vectors, 2);
  });
}

/// Median seconds of `series`.
Reading seconds(const LineContext& line, std::string_view stage,
                std::optional<Repeated> Time::*series, const char* format) {
  return from_stage(line, stage, [&](const Result& row) -> Reading {
    if (!row.time || !((*row.time).*series)) return "";
    const Repeated& found = *((*row.time).*series);
    return timed({fmt::format(fmt::runtime(format), found.median), found.median}, found);
  });
}

/// What the row states as work a second: its interval is that of the seconds, inverted.
Reading speed(const LineContext& line, std::string_view stage, ReadFigure figure, int digits) {
  Reading reading = from_stage(line, stage, figure, digits);
  if (!reading.number) return reading;
  const Reading time = seconds(line, stage, &Time::seconds, "{}");
  reading.timed = true;
  if (time.interval && time.interval->low > 0) {
    const double work = *reading.number * *time.number;
    reading.interval = {work / time.interval->high, work / time.interval->low};
  }
  return reading;
}

Reading access_time(const LineContext& line, std::string_view points, std::uint64_t lod = 0) {
  return from_stage(line, kRandomAccess, [&](const Result& row) -> Reading {
    if (!row.access) return "";
    for (const Parts::Access& series : *row.access) {
      if (series.points == points && series.lod == lod && series.ns_per_voxel)
        return timed(reading_of(series.ns_per_voxel->median, 1), *series.ns_per_voxel);
    }
    return "";
  });
}

Reading exact_text(const LineContext& line) {
  if (line.pseudo) return "";
  std::uint64_t compared = 0, mismatches = 0;
  for (const auto& [stage, row] : line.rows) {
    if (row == nullptr || !row->verification) continue;
    compared = std::max(compared, row->verification->voxels_compared.value_or(0));
    mismatches = std::max(mismatches, row->verification->mismatches.value_or(0));
  }
  if (compared == 0) return "";
  return {fmt::format("{} of {} differ", mismatches, compared), static_cast<double>(mismatches)};
}

Reading bound_text(const LineContext& line) {
  if (line.pseudo) return "";
  std::string text;
  for (const auto& [stage, row] : line.rows) {
    if (row != nullptr && row->size && row->size->bound_kept && text != "no")
      text = *row->size->bound_kept ? "yes" : "no";
  }
  return text;
}

/// The row of a stage that is ok and verified voxels; nullptr if there is none.
const Result* verified_row(const LineContext& line) {
  for (const auto& [stage, row] : line.rows) {
    if (row != nullptr && row->is_ok() && row->verification) return row;
  }
  return nullptr;
}

bool is_exact(const Result& row) { return row.verification->mismatches == Count(0); }

/// A number of the error of a volume; "exact" where it has none because nothing differs, with the
/// number that it then is; else the first status.
Reading error_of(const LineContext& line, ReadFigure figure, const char* format,
                 double of_exact = 0) {
  if (line.pseudo) return "";
  const Result* row = verified_row(line);
  if (row == nullptr) return from_any(line, figure, 3);
  if (const Figure value = figure(*row)) return {fmt::format(fmt::runtime(format), *value), *value};
  return is_exact(*row) ? Reading("exact", of_exact) : "";
}

Figure relative_error_p99(const Result& row) {
  if (!row.error || !row.error->relative_error) return std::nullopt;
  const Nullable<double>* found = row.error->relative_error->find("p99");
  return found == nullptr ? std::nullopt : Figure(*found);
}

Reading of_each_step(const LineContext& line, int digits, double factor,
                     Figure (*figure)(const Parts::Step&)) {
  const Result* row = line.rows.find(kDecode);
  if (row == nullptr || !row->is_ok() || !row->steps) return "";
  std::string text;
  for (const Parts::Step& step : *row->steps) {
    const Figure value = figure(step);
    text += fmt::format("{}{}", text.empty() ? "" : " / ",
                        value ? fmt::format("{:.{}f}", *value * factor, digits) : "exact");
  }
  return text;
}

Reading status_text(const LineContext& line) {
  std::string text;
  bool any = false;
  for (const auto& [stage, row] : line.rows) {
    any = any || row != nullptr;
    if (row == nullptr || row->is_ok()) continue;
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", stage, row->status);
  }
  return !any ? "not measured" : text.empty() ? "ok" : text;
}

Reading samples_text(const LineContext& line) {
  std::string text;
  for (const auto& [stage, row] : line.rows) {
    if (row == nullptr || !row->is_ok()) continue;
    text += fmt::format("{}{}", text.empty() ? "" : "/", of_time<&Time::rounds>(*row).value_or(0));
  }
  return text;
}

Reading peak_text(const LineContext& line) {
  double peak = 0;
  for (const auto& [stage, row] : line.rows) {
    if (row != nullptr && row->is_ok())
      peak = std::max(peak, figure<&Result::memory, &Parts::Memory::peak_bytes>(*row).value_or(0));
  }
  if (peak == 0) return "";
  return reading_of(peak / (1 << 20), 0);
}

/// Empty where the codec has no encoding for a GPU.
Reading gpu_bits(const LineContext& line) {
  const Result* row = verified_row(line);
  const Figure value = row == nullptr ? std::nullopt : of_size<&Size::gpu_bits_per_voxel>(*row);
  return value ? reading_of(*value, 4) : "";
}

Reading ratio_to_published(const LineContext& line) {
  if (line.published == nullptr || !line.published->rate || *line.published->rate == 0) return "";
  for (const auto& [stage, row] : line.rows) {
    if (row == nullptr || !row->is_ok()) continue;
    if (const Figure rate = of_size<&Size::published_rate>(*row))
      return reading_of(*rate / *line.published->rate, 3);
  }
  return "";
}

std::span<const Metric> voxel_metrics() {
  using L = const LineContext&;
  using Step = Parts::Step;
  static const Metric kMetrics[] = {
      {"rate", "file rate %",
       "bytes of the whole file / bytes of the original in its stored type, in percent",
       [](L l) { return from_any(l, of_size<&Size::rate>, 3); }},
      {"entropy_gap", "above entropy %",
       "what operations and stop bits take above the empirical entropy of the codec's own contexts "
       "and alphabets, percent",
       [](L l) { return entropy_gap(l); }},
      {"rank_overhead", "rank %",
       "bytes of the rank structure / bytes of the bit vectors that it counts in, in percent",
       [](L l) { return rank_overhead(l); }},
      {"bits_per_voxel", "bits/voxel", "bits of the whole file per voxel",
       [](L l) { return from_any(l, of_size<&Size::bits_per_voxel>, 4); }},
      {"gpu_bits_per_voxel", "GPU bits/voxel",
       "bits per voxel of all buffers that a GPU decodes a lossy codec's volume from", gpu_bits},
      {"volume_psnr_db", "PSNR dB",
       "of the decoded volume: 10 log10(peak^2 / mean squared error), peak 255 for u8, else the "
       "range of the original",
       [](L l) { return error_of(l, of_error<&Error::psnr_db>, "{:.2f}", kInfinity); }},
      {"time_steps", "steps", "time steps of a series",
       [](L l) { return from_any(l, of_dataset<&DatasetFacts::time_steps>, 0); }},
      {"worst_step_psnr_db", "worst step PSNR dB",
       "of the time step of a series with the largest mean squared error, by the peak of the whole",
       [](L l) { return error_of(l, of_error<&Error::worst_step_psnr_db>, "{:.2f}", kInfinity); }},
      {"edge_psnr_db", "edge PSNR dB", "the same over the 5 % of the voxels of steepest gradient",
       [](L l) { return error_of(l, of_error<&Error::edge_psnr_db>, "{:.2f}", kInfinity); }},
      {"largest_error", "max error", "largest absolute error of a voxel",
       [](L l) { return error_of(l, of_error<&Error::largest_error>, "{:.4g}"); }},
      {"mean_squared_error", "MSE", "mean squared error of the voxels",
       [](L l) { return error_of(l, of_error<&Error::mean_squared_error>, "{:.4g}"); }},
      {"edge_mean_squared_error", "edge MSE",
       "mean squared error of the 5 % of the voxels of steepest gradient",
       [](L l) { return error_of(l, of_error<&Error::edge_mean_squared_error>, "{:.4g}"); }},
      {"relative_error_p99", "rel. error p99",
       "of f32: |error| / |voxel| that 99 % of the voxels other than 0 do not exceed",
       [](L l) { return error_of(l, relative_error_p99, "{:.3g}"); }},
      {"pareto", "front",
       "* where no other line of the data set has at most its bits and at least its PSNR",
       [](L l) { return Reading(l.on_front ? "*" : ""); }, false},
      {"step_bits_per_voxel", "step bits/voxel",
       "bits of the file per voxel that each step of a progressive codec needs",
       [](L l) { return of_each_step(l, 4, 1, [](const Step& s) { return s.bits_per_voxel; }); },
       false},
      {"step_psnr_db", "step PSNR dB", "of the volume that each step decodes to",
       [](L l) { return of_each_step(l, 2, 1, [](const Step& s) { return Figure(s.psnr_db); }); },
       false},
      {"step_ms", "step ms", "median wall time of decoding each step",
       [](L l) {
         return of_each_step(l, 1, 1e3, [](const Step& s) {
           return s.seconds ? Figure(s.seconds->median) : Figure();
         });
       },
       false},
      {"published_rate", "rate %",
       "bytes by the accounting of the papers' tables / bytes of the original by the same, in "
       "percent",
       [](L l) { return from_any(l, of_size<&Size::published_rate>, 3); }},
      {"labels", "labels", "distinct labels of the volume, background included",
       [](L l) { return from_any(l, of_dataset<&DatasetFacts::labels>, 0); }},
      {"original_labels", "labels of original",
       "distinct labels of the original, as its description states them",
       [](L l) { return from_any(l, of_dataset<&DatasetFacts::original_labels>, 0); }},
      {"rate_gzip", "rate % gzip -6", "the whole file through gzip -6, in percent of the original",
       [](L l) {
         return l.pseudo ? Reading() : from_stage(l, kEncode, of_size<&Size::rate_gzip>, 3);
       }},
      {"rate_xz", "rate % xz -6", "the whole file through xz -6, in percent of the original",
       [](L l) {
         return l.pseudo ? Reading() : from_stage(l, kEncode, of_size<&Size::rate_xz>, 3);
       }},
      {"published", "published %", "the rate that the publication states, in percent",
       [](L l) { return published_reading(l, &PublishedFigure::rate, 3); }, true, true},
      {"logged_rate", "logged %",
       "the rate in the authors' own log, which the publication rounds, in percent",
       [](L l) { return published_reading(l, &PublishedFigure::logged_rate, 5); }, true, true},
      {"published_labels", "published labels", "distinct labels that the publication states",
       [](L l) { return published_reading(l, &PublishedFigure::labels, 0); }, true, true},
      {"published_original_gb", "published GB", "10^9 bytes of the original by the publication",
       [](L l) { return published_reading(l, &PublishedFigure::original_gb, 3); }, true, true},
      {"ratio", "ours/published", "published_rate measured here / rate published",
       ratio_to_published, true, true},
      {"encode_seconds", "encode s", "median wall time of encoding, file reading and writing apart",
       [](L l) { return seconds(l, kEncode, &Time::seconds, "{:.3g}"); }},
      {"encode_gb_per_s", "encode GB/s", "10^9 bytes of the original encoded a second of wall time",
       [](L l) { return speed(l, kEncode, of_time<&Time::gb_per_s>, 3); }},
      {"encode_mvoxel_per_s", "encode Mvoxel/s", "10^6 voxels encoded a second of wall time",
       [](L l) { return speed(l, kEncode, of_time<&Time::mvoxel_per_s>, 1); }},
      {"encode_interval", "encode +-%",
       "half width of the 95 % interval of the median encoding time, in percent",
       [](L l) { return from_stage(l, kEncode, of_time<&Time::relative_interval>, 1, 50); }},
      {"encode_cpu_seconds", "encode CPU s",
       "median processor time of encoding, all threads together",
       [](L l) { return seconds(l, kEncode, &Time::cpu_seconds, "{:.4f}"); }},
      {"decode_seconds", "decode s", "median wall time of opening and decoding into memory",
       [](L l) { return seconds(l, kDecode, &Time::seconds, "{:.3g}"); }},
      {"decode_gb_per_s", "decode GB/s", "10^9 bytes of the original decoded a second of wall time",
       [](L l) { return speed(l, kDecode, of_time<&Time::gb_per_s>, 3); }},
      {"decode_mvoxel_per_s", "decode Mvoxel/s", "10^6 voxels decoded a second of wall time",
       [](L l) { return speed(l, kDecode, of_time<&Time::mvoxel_per_s>, 1); }},
      {"decode_interval", "decode +-%",
       "half width of the 95 % interval of the median decoding time, in percent",
       [](L l) { return from_stage(l, kDecode, of_time<&Time::relative_interval>, 1, 50); }},
      {"decode_whole_seconds", "decode s, whole",
       "decode_seconds times voxels of the original / voxels decoded: what the whole volume would "
       "take",
       [](L l) {
         const Reading part = seconds(l, kDecode, &Time::seconds, "{}");
         return part.number ? of_whole(part, *l.rows.find(kDecode)) : part;
       }},
      {"access_uniform_ns", "access ns", "median ns per voxel, uniform points, finest level",
       [](L l) { return access_time(l, "uniform"); }},
      {"access_clustered_ns", "clustered ns",
       "median ns per voxel, points along rays, finest level",
       [](L l) { return access_time(l, "clustered"); }},
      {"access_uniform_lod3_ns", "access ns, level 3",
       "median ns per voxel, uniform points, level of detail 3",
       [](L l) { return access_time(l, "uniform", 3); }},
      {"access_clustered_lod3_ns", "clustered ns, level 3",
       "median ns per voxel, points along rays, level of detail 3",
       [](L l) { return access_time(l, "clustered", 3); }},
      {"access_by", "access by",
       "what is decoded to answer a point: the voxel, or the brick it lies in (unless it is that "
       "of the point before)",
       [](L l) {
         return from_stage(l, kRandomAccess,
                           [](const Result& row) { return Reading(row.access_by.value_or("")); });
       },
       false},
      {"access_front", "front",
       "*: no other line of the data set is smaller and faster at uniform points",
       [](L l) { return Reading(l.on_access_front ? "*" : ""); }, false},
      {"access_label_ns", "one-label ns", "median ns per voxel, points of one label, finest level",
       [](L l) { return access_time(l, "one-label"); }},
      {"label_statistics_ns", "labels ns",
       "median ns per voxel to count the voxels and the bounding box of every label",
       [](L l) {
         return from_stage(l, kLabelStatistics, [](const Result& row) -> Reading {
           const Figure ns = of_labels<&Labels::ns_per_voxel>(row);
           if (!ns || !row.time || !row.time->seconds) return "";
           const Repeated& seconds = *row.time->seconds;
           return timed({fmt::format("{:.3g}", *ns), *ns}, seconds, *ns / seconds.median);
         });
       }},
      {"label_statistics_mvoxel_per_s", "labels Mvoxel/s",
       "voxels per second, counting the voxels and the bounding box of every label",
       [](L l) { return speed(l, kLabelStatistics, of_time<&Time::mvoxel_per_s>, 1); }},
      {"bricks_decoded", "bricks decoded",
       "bricks that had to be decoded to count labels, of those that the codec has",
       [](L l) { return from_stage(l, kLabelStatistics, of_labels<&Labels::bricks_decoded>, 0); }},
      {"exact", "exact", "voxels of the decoded volume that differ from the original", exact_text},
      {"bound_kept", "bound kept",
       "yes or no: whether the largest error is at most the one that the codec's parameters "
       "promise; nothing where they promise none",
       bound_text, false},
      {"peak_mib", "peak MiB",
       "largest resident memory while encoding or decoding, the mapped input included", peak_text},
      {"published_seconds", "published s",
       "the seconds that the publication states, on its machine and its volume",
       [](L l) { return published_reading(l, &PublishedFigure::seconds, 2); }, true, true},
      {"published_gb_per_s", "published GB/s",
       "the GB/s that the publication states, on its machine",
       [](L l) { return published_reading(l, &PublishedFigure::gb_per_s, 3); }, true, true},
      {"samples", "n", "rounds measured, one number a stage", samples_text, false},
      {"status", "status", "ok, the statuses of the stages that are not, or not measured",
       status_text, false},
  };
  return kMetrics;
}

}  // namespace

Reading published_reading(const LineContext& line, std::optional<double> PublishedFigure::*figure,
                          int digits) {
  if (line.published == nullptr || !(line.published->*figure)) return "";
  return reading_of(*(line.published->*figure), digits);
}

std::optional<RatePoint> rate_point(const LineContext& line) {
  const Result* row = line.pseudo ? nullptr : verified_row(line);
  if (row == nullptr) return std::nullopt;
  const Figure bits = of_size<&Size::bits_per_voxel>(*row);
  const Figure psnr = of_error<&Error::psnr_db>(*row);
  if (!bits || (!psnr && !is_exact(*row))) return std::nullopt;
  return RatePoint{*bits, psnr.value_or(kInfinity)};
}

std::optional<RatePoint> access_point(const LineContext& line) {
  const auto bits = from_any(line, of_size<&Size::bits_per_voxel>, 4).number;
  const auto ns = access_time(line, "uniform").number;
  if (!bits || !ns) return std::nullopt;
  return RatePoint{*bits, -*ns};
}

std::span<const Metric> all_metrics() {
  static const std::vector<Metric> kAll = [] {
    const auto voxels = voxel_metrics(), images = render_metrics();
    std::vector<Metric> all(voxels.begin(), voxels.end());
    all.insert(all.end(), images.begin(), images.end());
    return all;
  }();
  return kAll;
}

const Metric* find_metric(std::string_view name) {
  for (const Metric& metric : all_metrics()) {
    if (metric.name == name) return &metric;
  }
  return nullptr;
}

MetricNames metric_names() {
  static const std::vector<MetricName> kNames = [] {
    std::vector<MetricName> names;
    for (const Metric& metric : voxel_metrics())
      names.push_back({metric.name, metric.numeric, false, published_beside(metric) != nullptr,
                       metric.of_publication});
    for (const Metric& metric : render_metrics())
      names.push_back({metric.name, metric.numeric, true, published_beside(metric) != nullptr,
                       metric.of_publication});
    return names;
  }();
  return kNames;
}

}  // namespace cvr::experiments
