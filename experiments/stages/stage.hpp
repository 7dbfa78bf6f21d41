// What a worker process does: one stage of one cell, first checked, then timed round by round.
//
// The check comes before any timing and apart from it: the encoding with one thread and with
// several has the same bytes, the breakdown sums to the size, every decoded voxel is compared. A
// stage that fails its check throws StageFailure and is never timed.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/results/rows.hpp"
#include "experiments/results/samples.hpp"
#include "experiments/stages/worker_spec.hpp"
#include "volumes/error.hpp"
#include "volumes/source.hpp"

namespace cvr::gpu {
struct DeviceOptions;
}

namespace cvr::experiments {

class StageFailure : public std::runtime_error {
 public:
  StageFailure(std::string_view status, const std::string& reason)
      : std::runtime_error(reason), status_(status) {}
  const std::string& status() const { return status_; }

 private:
  std::string status_;
};

/// What a build of the worker for tests changes (tests/faults); the program's own changes nothing.
class StageHooks {
 public:
  virtual ~StageHooks() = default;
  /// Before the check; need not come back.
  virtual void begin(const WorkerSpec&) {}
  /// What is encoded in place of the original; the original itself, or what lives as long as this.
  virtual const volumes::VolumeSource& source(const WorkerSpec&,
                                              const volumes::VolumeSource& truth) {
    return truth;
  }
  virtual void change_device(gpu::DeviceOptions&) {}
  virtual void begin_round() {}
  /// Samples as the stage has taken them.
  virtual void end_round(std::vector<Sample>&) {}
};

/// What a stage works on; all outlive its run.
struct StageInput {
  const WorkerSpec& spec;
  const volumes::VolumeSource& truth;
  const volumes::VolumeSource& source;  ///< what is encoded: the truth, but in tests
  StageHooks& hooks;
};

class StageRun {
 public:
  virtual ~StageRun() = default;
  /// Checks and returns parts of the result: verification, size and what else the stage knows.
  virtual Parts prepare() = 0;
  virtual std::vector<Sample> round() = 0;
};

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
