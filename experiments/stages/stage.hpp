// What a worker process does: one stage of one cell, first checked, then timed round by round.
//
// The check comes before any timing and apart from it: the encoding with one thread and with
// several has the same bytes, the breakdown sums to the size, every decoded voxel is compared. A
// stage that fails its check throws StageFailure and is never timed.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/config/cells.hpp"
#include "experiments/config/datasets.hpp"
#include "experiments/results/rows.hpp"
#include "experiments/results/samples.hpp"
#include "volumes/source.hpp"

namespace cvr::experiments {

/// Everything a worker needs; travels as one JSON line.
struct WorkerSpec {
  Location location;
  std::string raw_path;  ///< of the mapped copy; empty: streamed
  std::string codec;
  std::string parameters;  ///< canonical
  Stage stage = Stage::kEncode;
  unsigned threads = 1;
  std::uint32_t bytes_per_voxel = 0;
  std::uint64_t memory_limit = 0;  ///< bytes beyond the mapped input; 0: none
  std::string scratch;   ///< folder for encoded files, shared by the stages of a run; empty: none
  std::string pictures;  ///< path that kept pictures begin with; empty: none are kept
  std::uint64_t seed = 1;
  std::vector<unsigned> lods;  ///< empty: all
  std::string fault;
  std::optional<RenderChoice> render;  ///< of the render stage
};

std::string to_json_line(const WorkerSpec& spec);
/// Throws std::exception on anything malformed.
WorkerSpec worker_spec_from_json(const std::string& line);

class StageFailure : public std::runtime_error {
 public:
  StageFailure(std::string_view status, const std::string& reason)
      : std::runtime_error(reason), status_(status) {}
  const std::string& status() const { return status_; }

 private:
  std::string status_;
};

class StageRun {
 public:
  virtual ~StageRun() = default;
  /// Checks and returns parts of the row: verification, size and what else the stage knows.
  virtual Row prepare() = 0;
  virtual std::vector<Sample> round() = 0;
};

/// `truth` outlives the result.
std::unique_ptr<StageRun> make_stage_run(const WorkerSpec& spec,
                                         const volumes::VolumeSource& truth);

/// Wall and processor time since its construction.
class Stopwatch {
 public:
  Stopwatch();
  Sample lap(std::string series, std::uint64_t count) const;

 private:
  double wall_, cpu_;
};

/// Throws StageFailure with the status that belongs to the error.
[[noreturn]] void fail_stage(const volumes::Error& error);

/// Unwraps a decoder's or encoder's result.
template <class T>
T checked(volumes::Expected<T> result) {
  if (!result) fail_stage(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

}  // namespace cvr::experiments
