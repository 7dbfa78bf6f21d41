// Writes the groups of `csgvr-c`: the bricks of 64^3 voxels, with one dictionary of labels. Layout:
// shaders/shared/csgvr_c.glsl.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codecs/csgv/encoder_strategy.hpp"
#include "codecs/csgvr/block_code.hpp"
#include "codecs/csgvr/blocks.hpp"
#include "codecs/succinct/bit_vector.hpp"

namespace cvr::codecs::csgvr {

/// Keeps what is needed of the groups that one worker has been shown, in 4 bytes per block. Keepers
/// stand side by side, on lines of the cache of their own.
class alignas(64) GroupKeeper {
 public:
  explicit GroupKeeper(std::uint32_t b) : levels_(csgv::levels_of_brick(b)), finder_(b) {}

  /// Takes a group whose nodes outside the volume are filled; returns its number, from 0 on.
  std::size_t keep(csgv::SourceGroup& group);

  // Which of its possible operations a shape is given: those that are frequent where every shape
  // names the neighbours along the axes with most matches. All workers first count the ones, then
  // the others, then encode what they have met.
  void count_widest(PatternCounts& patterns) const;
  void choose(const PatternCounts& widest, PatternCounts& chosen);
  void encode(const BlockCode& code);

 private:
  friend class BlockGroupWriter;
  struct Brick {
    std::uint32_t root;  ///< dictionary index of its coarsest node
    std::size_t first_block, fine_block,
        end_block;  ///< in blocks_: all, those of the finest level, the next brick's
    std::size_t first_mask, first_label;  ///< in masks_, own_labels_
    bool constant() const { return first_block == end_block; }
  };
  struct Group {
    std::size_t first_brick, end_brick, first_entry, end_entry;  ///< in bricks_, dictionary_
  };

  void add(const csgv::LabelGrid& grid);

  unsigned levels_;
  BlockFinder finder_;
  std::vector<std::uint64_t> keys_;          ///< of a brick's blocks: shape_key()
  std::vector<std::uint64_t> own_keys_;      ///< of a brick's blocks: labels of their own
  KeyCounts shapes_;                         ///< of all blocks
  std::vector<BlockOperations> operations_;  ///< of the shapes
  std::vector<CodedBlock> codes_;            ///< of the shapes
  std::vector<Group> groups_;
  std::vector<Brick> bricks_;
  std::vector<std::uint32_t> blocks_;      ///< their shapes
  std::vector<std::uint8_t> masks_;        ///< open children of the coarse blocks
  std::vector<std::uint32_t> own_labels_;  ///< dictionary indices
  std::vector<std::uint32_t> dictionary_;  ///< of one group after the other
  KeyCounts indices_;  ///< labels in the dictionary of the group that is not finished
};

/// Writes kept groups, once their blocks have been encoded.
class BlockGroupWriter final : public csgv::GroupWriter {
 public:
  /// keepers: of each worker.
  explicit BlockGroupWriter(std::span<const GroupKeeper> keepers) : keepers_(keepers) {}
  void write(const csgv::KeptGroup& group, std::vector<std::uint32_t>& words,
             ByteBreakdown& bytes) override;

 private:
  using Brick = GroupKeeper::Brick;
  /// The runs of the coarse or of the fine blocks of a brick: where each begins, from the first,
  /// and their bits together.
  struct Runs {
    std::vector<std::uint32_t> offsets;
    std::uint32_t bits;
  };
  struct Bits {
    std::uint64_t header, labels, masks, samples, codes;
  };

  const CodedBlock& block(std::size_t i) const { return kept_->codes_[kept_->blocks_[i]]; }
  Runs runs_of(std::size_t first, std::size_t end) const;
  void write_bricks(std::span<const Brick> bricks, std::size_t dictionary_size);
  void write_brick(const Brick& brick, unsigned position_bits);
  void write_masks(const Brick& brick);
  void write_runs(std::size_t first, std::size_t end, std::size_t& label);
  void append_group(std::vector<std::uint32_t>& words, ByteBreakdown& bytes);

  std::span<const GroupKeeper> keepers_;
  const GroupKeeper* kept_ = nullptr;  ///< of the group that is written
  unsigned index_bits_ = 0;
  std::uint32_t masks_end_ = 0;  ///< bit behind the last mask of the group
  succinct::BitAppender group_, streams_;
  Bits bits_{};
};

}  // namespace cvr::codecs::csgvr
