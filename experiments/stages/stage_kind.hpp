// The stages of this build behind one contract: what a cell of the stage needs, costs, does and
// leaves in its row. Adding a stage is one file here and one line in registry.cpp.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "experiments/config/cells.hpp"
#include "experiments/results/measured.hpp"
#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

/// What of a configuration decides the memory of its workers.
struct MemoryChoices {
  /// Bytes beyond the mapped input; 0: none. A volume above half of it is decoded slab by slab.
  std::uint64_t limit = 0;
  std::vector<unsigned> lods;  ///< of random access; empty: all
};

class StageKind {
 public:
  virtual ~StageKind() = default;
  virtual const StageTraits& traits() const = 0;

  /// Why a codec that accepts the volume cannot run the cell, as far as its traits tell; "": it can.
  virtual std::string unsupported_reason(const Cell&, const codecs::Traits&,
                                         const volumes::VolumeInfo&) const {
    return "";
  }
  /// Seconds that the check and so many rounds are expected to take where no row tells.
  virtual double expected_seconds(const Cell& cell, const volumes::VolumeInfo& info,
                                  double rounds) const = 0;
  /// Bytes beyond the mapped input that the timed rounds are expected to take, by the model alone.
  virtual double expected_memory(const Cell& cell, const volumes::VolumeInfo& info,
                                 const MemoryChoices& choices) const = 0;
  /// Whether rows of other volumes tell what a cell takes.
  virtual bool memory_scales() const { return true; }
  /// Whether a worker's address space is limited beside its memory.
  virtual bool limits_address_space() const { return true; }
  /// Whether one thread does the timed work, so that two programs can take turns on one core.
  virtual bool takes_turns_on_a_core(const Cell& cell) const { return cell.threads.count == 1; }

  virtual std::unique_ptr<StageRun> make_run(const StageInput& input) const = 0;

  /// What the rounds add: `parts.time` has the number of rounds and why they ended already.
  virtual void add_times(const Measured& measured, const volumes::VolumeInfo& info,
                         Parts& parts) const;
  /// The most important time of such parts, with its unit: "0.123 s"; "": none.
  virtual std::string headline(const Parts& parts) const;
};

/// In the order in which a run takes them.
std::span<const StageKind* const> all_stages();
StageList stage_traits();
const StageKind& kind_of(const Cell& cell);
/// Throws StageFailure where there is none of this id.
const StageKind& kind_of(const WorkerSpec& spec);

/// The run of a cell: of memcpy, or of the stage's own kind.
std::unique_ptr<StageRun> make_stage_run(const StageInput& input);

const StageKind& encode_stage();
const StageKind& decode_stage();
const StageKind& random_access_stage();
const StageKind& label_statistics_stage();
const StageKind& render_stage();

}  // namespace cvr::experiments
