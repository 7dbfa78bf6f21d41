// The outcome of one cell, typed. Each field is described once, in a table (part_fields.cpp,
// result.cpp): from the tables come
// the JSON of a row both ways, results/schema/row.schema.json and docs/rows.md, which say what a
// field means and its unit.
//
// What a row of another revision may lack is optional. Null in a row says that there is no number,
// for instance no PSNR of what is exact.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cvr::experiments {

/// JSON whose objects keep the order of their keys.
using Row = nlohmann::ordered_json;

/// Values by names that are free, in the order of the row.
template <class T>
struct Named : std::vector<std::pair<std::string, T>> {
  using std::vector<std::pair<std::string, T>>::vector;

  /// nullptr where there is none.
  const T* find(std::string_view name) const {
    for (const auto& [known, value] : *this)
      if (known == name) return &value;
    return nullptr;
  }
  T& operator[](const std::string& name) {
    if (const T* found = find(name)) return const_cast<T&>(*found);
    return this->emplace_back(name, T()).second;
  }
};

/// A value that is null where there is none; an optional one is left out instead.
template <class T>
struct Nullable : std::optional<T> {
  using std::optional<T>::optional;
  Nullable(std::optional<T> value) : std::optional<T>(std::move(value)) {}
};

using Figure = std::optional<double>;
using Count = std::optional<std::uint64_t>;

/// Aggregates of the samples of all rounds, in the unit of the samples (statistics.hpp). Computed
/// once, when the row is written; tables, claims, tracking and the report read them.
struct Repeated {
  double median = 0, mad = 0, lower_quartile = 0, upper_quartile = 0;
  std::array<double, 2> interval{};  ///< of the median
  double interval_coverage = 0, minimum = 0, maximum = 0, mean = 0;
  std::string note;
  std::vector<double> samples;
};

/// The types of Parts, in a class of their own: it is complete where Parts needs their initial
/// values.
struct PartTypes {
  struct Device {
    std::string name, type, driver, api;
  };
  /// Of scalars; null: a decoded voxel is not finite, or nothing differs.
  struct Error {
    Nullable<double> psnr_db;
    bool exact = false;
    Nullable<double> largest_error, mean_squared_error, mean_absolute_error,
        edge_mean_squared_error, edge_psnr_db;
    Count edge_voxels, non_finite_voxels, time_steps, worst_step;
    std::optional<Nullable<double>> worst_step_psnr_db;
    std::optional<Named<Nullable<double>>> relative_error;
    std::optional<Named<double>> recorded;
  };
  struct Verification {
    Count voxels_compared, mismatches;
    std::optional<std::vector<std::uint64_t>> same_bytes_with_threads;
    Count points_compared, labels_compared, pixels_compared, label_mismatches, near_ties,
        other_colours;
    std::optional<bool> same_as_raw;
    Count samples;
    std::optional<Nullable<double>> psnr_db;
    Figure largest_difference;
  };
  /// Of a progressive codec.
  struct Step {
    std::string name;
    Count bytes;
    Figure bits_per_voxel;
    Nullable<double> psnr_db, largest_error;
    std::optional<Repeated> seconds;
  };
  struct Size {
    Count bytes, published_bytes;
    Figure rate, published_rate;
    Count published_bytes_per_voxel;
    Figure bits_per_voxel;
    Count gpu_bytes;
    Figure gpu_bits_per_voxel, bound;
    std::optional<bool> bound_kept;
    std::optional<Named<std::uint64_t>> breakdown;
    std::optional<Named<std::string>> checksums;
    Count entropy_bytes;
    Figure rate_gzip, rate_xz;
  };
  /// The step that is drawn.
  struct DrawnStep {
    std::string name;
    std::uint64_t bytes = 0;
  };
  /// Milliseconds of frames.
  struct Spread {
    Figure min_ms, mean_ms, median_ms, p95_ms, p99_ms, max_ms;
  };
  struct Pass {
    double median_ms = 0, mean_ms = 0;
  };
  struct Incomplete {
    std::uint64_t first;
    double median, largest;
  };
  /// What the frames of the path and those of the held view have in common: the spread of the
  /// rounds after the first.
  struct FrameTimes : Spread {
    Count count, rounds;
    std::optional<Spread> wall;
    std::optional<Named<Pass>> passes;
    Figure host_median_ms;
    std::optional<Incomplete> incomplete;
    std::vector<std::vector<double>> ms;  ///< every frame, round by round
  };
  struct Frames : FrameTimes {
    Figure first_round_mean_ms, first_frame_ms;
    std::vector<double> first;
  };
  struct Held : FrameTimes {
    Count key, exact_after_frames;
    std::optional<bool> compared;
    Count cells_read, cells_decoded, bytes_touched;
    std::optional<Nullable<bool>> cache_complete;
  };
  struct Pictures {
    std::string picture, difference;
    double gain = 0;
    Nullable<double> psnr_db;
    double ssim = 0;
  };
  struct JumpFrame {
    Nullable<double> psnr_db;
    std::uint64_t label_mismatches = 0, incomplete = 0;
    double ms = 0;
  };
  struct Jump {
    std::vector<JumpFrame> frames;
    std::uint64_t pixels = 0;
  };
  struct PictureError {
    Nullable<double> psnr_db;
    Figure ssim, largest;
    Count label_mismatches, pixels, samples_of_truth;
  };
  struct Needed {
    Count visits, distinct_cells, distinct_bricks, cells_read, cells_decoded, bytes_touched;
    Nullable<double> decoded_over_needed;
  };
  struct LabelStatistics {
    Count labels;
    std::string by;
    Count bricks, bricks_decoded;
    Figure ns_per_voxel;
  };
  struct Memory {
    Count gpu_bytes;
    std::optional<Named<std::uint64_t>> gpu_uses;
    Count peak_bytes, peak_over_input, check_peak_bytes;
  };
  struct Time {
    Count rounds;
    std::string stop;
    Nullable<double> relative_interval;
    std::optional<Repeated> seconds, cpu_seconds;
    std::optional<Nullable<double>> gb_per_s, mvoxel_per_s;
  };
  struct Access {
    std::string points;
    std::uint64_t lod = 0, count = 0;
    std::optional<Repeated> ns_per_voxel;
    double cpu_ns_per_voxel = 0;
  };
};

/// What a worker tells of its cell, and what its rounds add.
struct Parts : PartTypes {
  std::optional<Device> device;
  std::optional<Verification> verification;
  std::optional<Error> error;
  std::optional<std::vector<Step>> steps;
  std::optional<Size> size;
  std::optional<DrawnStep> step;
  std::optional<Named<double>> start;
  std::optional<Held> held;
  Count exact_after_frames;
  std::optional<Pictures> pictures;
  std::optional<Jump> jump;
  std::optional<PictureError> picture_error;
  std::optional<Needed> needed;
  std::optional<Named<std::uint64_t>> counters;
  std::optional<std::string> destination;
  Count points_per_series;
  std::optional<std::string> access_by;
  std::optional<LabelStatistics> label_statistics;
  std::optional<Time> time;
  std::optional<std::vector<Access>> access;
  std::optional<Frames> frames;
  std::optional<Memory> memory;
};

/// The program and how it was built, the machine and its system (provenance.hpp).
struct Provenance {
  struct CpuFeatures {
    std::vector<std::string> compiled, present;
  };
  std::string harness, revision, compiler, flags, build_type, cpu;
  std::uint64_t cores = 0, memory_bytes = 0;
  std::string kernel, os, machine;
  std::optional<std::string> libc;
  std::optional<Named<std::string>> libraries;
  std::optional<CpuFeatures> cpu_features;
  std::optional<std::string> governor, turbo, huge_pages;
  std::string config_hash, time;
};

struct Result : Parts {
  struct Dataset {
    std::string name, title, label;
    std::optional<std::array<std::uint64_t, 3>> extent;
    Count time_steps;
    std::optional<std::string> type, kind;
    Count voxels, original_voxels, bytes;
    std::optional<std::string> identity;
    std::optional<Nullable<std::string>> content_hash;
    Count labels, original_labels;
    std::optional<std::string> source;
  };
  struct Codec {
    std::string id;
    std::uint64_t version = 0;
    Named<std::string> parameters;
  };

  std::uint64_t schema = 1;
  std::string cell, key, status, reason;
  Dataset dataset;
  Codec codec;
  std::string stage;
  std::uint64_t threads = 1;
  std::optional<Row> render;  ///< what config/render_options.cpp describes
  Provenance provenance;
  std::optional<std::string> interleave_group;
  Count processes;
  Figure elapsed_seconds;

  bool is_ok() const { return status == "ok"; }
  /// The access mode of images; "" of others.
  std::string access_mode() const;
};

/// What JSON is not: "a number as size.bytes".
class ShapeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The JSON of a result, of a worker's parts or of one part, fields in the order of their table.
/// For the types below.
template <class S>
Row to_json(const S& part);
/// The other way. Fields that this revision does not know are passed over, and what is missing
/// stays as it is by default. Throws ShapeError for a value of another type.
template <class S>
S from_json(const Row& row);

/// The JSON schema of a row. `stages`: their ids. `render`: the schema of the part `render`.
std::string row_schema(const std::vector<std::string>& stages, const Row& render);

extern template Row to_json(const Named<double>&);
extern template Row to_json(const Parts&);
extern template Row to_json(const Result&);
extern template Row to_json(const Parts::Device&);
extern template Row to_json(const Parts::Error&);
extern template Row to_json(const Parts::Size&);
extern template Row to_json(const Parts::Memory&);
extern template Row to_json(const Parts::Verification&);
extern template Row to_json(const Provenance&);
extern template Parts from_json(const Row&);
extern template Result from_json(const Row&);

}  // namespace cvr::experiments
