// What a worker's timed rounds are expected to take in memory beyond the mapped input:
// memory.peak_over_input of rows.
//
// A row of the same cell tells. Else the model, which codecs describe (codecs::MemoryEstimate) and
// stages add their own to; it is scaled by what a row of the same codec, parameters, stage and
// threads measured on the volume of the same kind that is nearest in size.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiments/config/cells.hpp"
#include "experiments/results/rows.hpp"
#include "experiments/stages/stage_kind.hpp"

namespace cvr::experiments {

/// Bytes by the model alone.
double modelled_memory(const Cell& cell, const volumes::VolumeInfo& info,
                       const MemoryChoices& choices);

class MemoryForecast {
 public:
  /// `rows` must outlive it.
  MemoryForecast(const std::vector<Result>& rows, MemoryChoices choices);

  /// Bytes.
  std::uint64_t of(const Cell& cell, const std::string& cell_id,
                   const volumes::VolumeInfo& info) const;

 private:
  std::vector<const Result*> rows_;  ///< that are ok and tell their memory, the last one first
  MemoryChoices choices_;
};

}  // namespace cvr::experiments
