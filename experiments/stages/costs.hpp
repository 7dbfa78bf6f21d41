// What the work of stages is expected to cost, where no row tells: passes over the volume, and the
// memory of a worker process.
#pragma once

#include "codecs/estimates.hpp"
#include "experiments/stages/stage_kind.hpp"

namespace cvr::experiments {

/// Seconds of one pass over the volume with the threads of the cell.
double pass_seconds(const Cell& cell, const volumes::VolumeInfo& info);
/// Seconds of a check of four passes and rounds of one pass each.
double seconds_by_passes(const Cell& cell, const volumes::VolumeInfo& info, double rounds);

/// Bytes of a process with the threads of the cell.
double process_memory(const Cell& cell);
/// Bytes of where decoded voxels go: the whole volume, or one slab.
double destination_memory(const volumes::VolumeInfo& info, const MemoryChoices& choices);
/// What the cell's codec says of itself. Not of memcpy.
codecs::MemoryEstimate estimate_of(const Cell& cell, const volumes::VolumeInfo& info);

}  // namespace cvr::experiments
