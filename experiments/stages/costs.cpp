#include "experiments/stages/costs.hpp"

#include <algorithm>

#include "codecs/registry.hpp"

namespace cvr::experiments {

namespace {

constexpr double kVoxelsPerSecond = 50e6;
constexpr double kMemcpyPerSecond = 1000e6;
constexpr double kMiB = 1 << 20;
constexpr double kProcess = 15.6 * kMiB;  ///< program and libraries, as far as they are touched
constexpr double kThread = 0.25 * kMiB;   ///< of stack and heap, for each beside the first
constexpr std::uint64_t kSlabPlanes = 64;

}  // namespace

double pass_seconds(const Cell& cell, const volumes::VolumeInfo& info) {
  const double speed = cell.codec == kMemcpy ? kMemcpyPerSecond : kVoxelsPerSecond;
  return static_cast<double>(info.extent.voxels()) / (speed * cell.threads.count);
}

double seconds_by_passes(const Cell& cell, const volumes::VolumeInfo& info, double rounds) {
  return (4 + rounds) * pass_seconds(cell, info);
}

double process_memory(const Cell& cell) { return kProcess + kThread * (cell.threads.count - 1.0); }

double destination_memory(const volumes::VolumeInfo& info, const MemoryChoices& choices) {
  if (choices.limit == 0 || info.bytes() <= choices.limit / 2)
    return static_cast<double>(info.bytes());
  const std::uint64_t planes = std::min(info.extent.z, kSlabPlanes);
  return static_cast<double>(info.extent.x * info.extent.y * planes * size_of(info.type));
}

codecs::MemoryEstimate estimate_of(const Cell& cell, const volumes::VolumeInfo& info) {
  return codecs::estimate_memory(*codecs::find_codec(cell.codec), info, cell.parameters,
                                 cell.threads.count);
}

}  // namespace cvr::experiments
