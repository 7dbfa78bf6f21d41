// The two prefix codes of `csgvr-c`, for the blocks of the finest level and of all others: fitting,
// storing, looking up.
//
// Stored as bits, first bit lowest, the fine code before the coarse one:
//   16  patterns K     5  parameter p
//   K times: Exp-Golomb code with parameter p of (number - number before - 1, the first: number)     4  code length - 1
//   9 times: 4  length of the escape - 1, of blocks with 0 to 8 labels of their own
// The number of a pattern is its operations in base 6, child 0 lowest. Exp-Golomb: q = value >> p;
// as many zeros as q + 1 has bits less one, the bits of q + 1 from the highest on, the p low bits
// of the value. The lookup tables are those of shaders/shared/csgvr_c.glsl.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codecs/bytes.hpp"
#include "codecs/csgvr/blocks.hpp"
#include "codecs/csgvr/key_counts.hpp"
#include "volumes/error.hpp"

namespace cvr::codecs::csgvr {

/// What shapes are counted by: BlockShape::bits(), and whether the block is of the finest level.
inline std::uint64_t shape_key(const BlockShape& shape, bool fine) {
  return shape.bits() << 1 | (fine ? 1 : 0);
}
inline BlockShape shape_of(std::uint64_t key) { return BlockShape::from_bits(key >> 1); }
inline bool is_fine(std::uint64_t key) { return (key & 1) != 0; }

/// Whether operations are such as an encoder writes: all below 6, and no repeated label before the
/// first of the block.
bool valid_operations(BlockOperations operations);

/// A block's code and what it stands for.
struct CodedBlock {
  std::uint64_t bits;
  BlockOperations operations;
  std::uint16_t length;
  std::uint16_t labels;  ///< of its own
};

/// How often each pattern occurs in coarse and in fine blocks, by its operations.
using PatternCounts = std::array<KeyCounts, 2>;

/// Of the operations that a shape allows the most frequent ones; of equal ones the first in
/// kAxisOrders.
BlockOperations most_frequent(const BlockShape& shape, const KeyCounts& patterns);

class BlockCode {
 public:
  /// Codes for patterns that occur so often; others are coded with escapes.
  explicit BlockCode(const PatternCounts& patterns);

  void write(ByteWriter& out) const;
  /// Takes all that is left. Fails where it is none that an encoder writes.
  static volumes::Expected<BlockCode> read(ByteReader& in);

  CodedBlock coded(BlockOperations operations, bool fine) const {
    return sides_[fine].coded(operations);
  }

  /// Lookup tables for shaders/shared/csgvr_c.glsl.
  const std::vector<std::uint32_t>& tables() const { return tables_; }

 private:
  struct Code {
    std::uint32_t bits;
    std::uint32_t length;
  };
  /// One of the two codes: patterns in ascending order of their numbers, and after them the
  /// escapes.
  struct Side {
    std::vector<BlockOperations> patterns;
    std::vector<std::uint8_t> lengths;
    std::vector<Code> codes;
    void assign_codes();
    CodedBlock coded(BlockOperations operations) const;

   private:
    /// A pattern and its code; length 0: none.
    struct Slot {
      BlockOperations operations = 0;
      std::uint16_t bits = 0, length = 0;
    };
    static std::uint32_t hash(BlockOperations operations) { return operations * 0x9e3779b1u; }
    std::vector<Slot> slots_;  ///< open addressing, a power of two
    unsigned hash_shift_ = 31;
  };

  BlockCode() = default;
  static void fit_side(Side& side, const KeyCounts& patterns);
  void build_tables();

  std::array<Side, 2> sides_;  ///< coarse, fine
  std::vector<std::uint32_t> tables_;
};

}  // namespace cvr::codecs::csgvr
