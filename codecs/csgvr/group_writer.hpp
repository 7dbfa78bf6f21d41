// Writes the groups of `csgvr-c`: the bricks of 64^3 voxels, with one dictionary of labels. Layout: shaders/shared/csgvr_c.glsl.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "codecs/csgv/brick_format.hpp"
#include "codecs/csgvr/block_code.hpp"
#include "codecs/csgvr/blocks.hpp"
#include "codecs/succinct/bit_vector.hpp"

namespace cvr::codecs::csgvr {

class GroupWriter final : public csgv::PackWorkspace {
 public:
  explicit GroupWriter(std::uint32_t b) : levels_(csgv::levels_of_brick(b)), finder_(b), chosen_(kChosen) {}

  /// Takes the next brick of the group; its nodes outside the volume are filled.
  void add(const csgv::LabelGrid& grid, const BlockCode& code);
  /// Appends the group and begins the next one.
  void finish(std::vector<std::uint32_t>& words, ByteBreakdown& bytes);

 private:
  static constexpr std::size_t kChosen = 4096;

  struct Brick {
    std::uint32_t root;                             ///< dictionary index of its coarsest node
    std::size_t first_block, fine_block, end_block;  ///< in blocks_: all, those of the finest level, the next brick's
    std::size_t first_label, first_mask;             ///< in own_labels_, masks_
    bool constant() const { return first_block == end_block; }
  };
  /// The runs of the coarse or of the fine blocks of a brick: where each begins, from the first, and their bits together.
  struct Runs {
    std::vector<std::uint32_t> offsets;
    std::uint32_t bits;
  };
  /// A code that was chosen for a shape.
  struct Chosen {
    std::uint64_t shape = ~std::uint64_t{0};
    CodedBlock code{};
  };
  struct Bits {
    std::uint64_t header, labels, masks, samples, codes;
  };

  std::uint32_t index_of(std::uint32_t label);
  const CodedBlock& coded(const BlockShape& shape, bool fine, const BlockCode& code);
  Runs runs_of(std::size_t first, std::size_t end) const;
  void write_bricks();
  void write_brick(const Brick& brick, unsigned position_bits);
  void write_masks(const Brick& brick);
  void write_runs(std::size_t first, std::size_t end, std::size_t& label);
  void append_group(std::vector<std::uint32_t>& words, ByteBreakdown& bytes);

  unsigned levels_;
  BlockFinder finder_;
  std::vector<Chosen> chosen_;  ///< by a hash of the shape
  std::vector<Brick> bricks_;
  std::vector<CodedBlock> blocks_;
  std::vector<std::uint8_t> masks_;        ///< open children of the coarse blocks
  std::vector<std::uint32_t> own_labels_;  ///< dictionary indices
  std::vector<std::uint32_t> dictionary_;
  std::unordered_map<std::uint32_t, std::uint32_t> indices_;  ///< of labels in the dictionary
  unsigned index_bits_ = 0;
  std::uint32_t masks_end_ = 0;  ///< bit behind the last mask of the group
  succinct::BitAppender group_, streams_;
  Bits bits_{};
};

}  // namespace cvr::codecs::csgvr
