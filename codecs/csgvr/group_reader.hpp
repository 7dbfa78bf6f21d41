// Reads the groups of `csgvr-c` for whole bricks, and checks them. Layout and single nodes:
// shaders/shared/csgvr_c.glsl.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codecs/csgv/reconstruct.hpp"
#include "codecs/csgv/symbol_tally.hpp"
#include "codecs/csgvr/blocks.hpp"
#include "shaders/shared/shared.hpp"

namespace cvr::codecs::csgvr {

/// The labels of a brick's own in their order, as far as they have been read; entry 0 is the
/// coarsest node's.
struct OwnLabels {
  const std::vector<std::uint32_t>& labels;
  std::uint32_t size = ~std::uint32_t{0};  ///< never asked for more than the reader has handed out
  std::uint32_t operator[](std::uint32_t k) const { return labels[k]; }
};

/// A Reader for Reconstruction over a checked brick.
class BlockReader {
 public:
  /// tally: counts the patterns, or nullptr.
  BlockReader(shaders::Words words, shaders::Words tables, const shaders::CsgvrcBrick& brick,
              csgv::SymbolTally* tally)
      : words_(words), tables_(tables), brick_(brick), tally_(tally) {
    labels_.push_back(label(brick.root));
  }
  OwnLabels labels() const { return {labels_}; }
  void begin_level(unsigned, bool finest) {
    if (!finest) return;
    fine_ = true;
    next_ = 0;
  }
  bool take(unsigned count, std::uint64_t& codes) {
    if (count == 1) {
      codes = csgv::kAdvance | (brick_.constant ? csgv::kStopBit : 0);
      return true;
    }
    if (next_ % CVR_C_RUN == 0) {
      const shaders::CsgvrcRuns& runs = brick_.runs[fine_ ? 1 : 0];
      at_ = cvr_c_run_begin(words_, runs, next_ / CVR_C_RUN);
      labels_at_ = cvr_c_run_end(words_, runs, next_ / CVR_C_RUN);
    }
    const BlockOperations operations = cvr_c_operations(words_, tables_, fine_, at_);
    for (unsigned own = shaders::cvr_popcount32(shaders::cvr_c_own_labels(operations)); own > 0;
         --own) {
      labels_at_ -= brick_.index_bits;
      labels_.push_back(label(cvr_c_bits(words_, labels_at_, brick_.index_bits)));
    }
    codes = spread_operations(operations);
    if (tally_ != nullptr) {
      tally_->add(fine_ ? 1 : 0, operations);
      tally_->add_plain(fine_ ? 0 : 8);  // the mask
    }
    if (!fine_) codes |= csgv::kSpread[~cvr_c_mask(words_, brick_, next_) & 0xff] * csgv::kStopBit;
    ++next_;
    return true;
  }

 private:
  /// Eight times three bits to eight bytes.
  static std::uint64_t spread_operations(std::uint64_t v) {
    v = (v | v << 20) & 0x00000fff00000fffu;
    v = (v | v << 10) & 0x003f003f003f003fu;
    return (v | v << 5) & 0x0707070707070707u;
  }
  std::uint32_t label(std::uint32_t index) const { return cvr_c_label(words_, brick_, index); }

  shaders::Words words_, tables_;
  const shaders::CsgvrcBrick& brick_;
  csgv::SymbolTally* tally_;
  std::vector<std::uint32_t> labels_;
  bool fine_ = false;
  std::uint32_t next_ = 0;       ///< block among the coarse or the fine ones
  std::uint32_t at_ = 0;         ///< bit of its code
  std::uint32_t labels_at_ = 0;  ///< bit behind the next label of the run
};

/// Checks groups one after the other: after success no query of a brick of the group leaves its
/// words.
class GroupCheck {
 public:
  explicit GroupCheck(const std::vector<std::uint32_t>& tables) : tables_{tables.data()} {}
  csgv::BrickError run(std::span<const std::uint32_t> group, std::uint32_t members,
                       unsigned levels);

 private:
  csgv::BrickError check_table(std::uint32_t members, unsigned levels);
  csgv::BrickError check_brick(std::uint32_t member, unsigned levels);
  csgv::BrickError check_header(const shaders::CsgvrcBrick& brick) const;
  csgv::BrickError check_masks(const shaders::CsgvrcBrick& brick) const;
  csgv::BrickError check_runs(const shaders::CsgvrcBrick& brick, bool fine) const;

  shaders::Words tables_;
  std::vector<std::uint32_t> words_;  ///< the group, and zeros where a wrong header may look
  shaders::Words group_{};
  std::uint64_t limit_ = 0;  ///< bits of the group
};

}  // namespace cvr::codecs::csgvr
