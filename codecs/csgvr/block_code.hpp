// The two prefix codes of `csgvr-c`, for the blocks of the finest level and of all others: fitting, storing, looking up.
//
// Stored as bits, first bit lowest, the fine code before the coarse one:
//   16  patterns K     5  parameter p
//   K times: Exp-Golomb code with parameter p of (number - number before - 1, the first: number)     4  code length - 1
//   9 times: 4  length of the escape - 1, of blocks with 0 to 8 labels of their own
// The number of a pattern is its operations in base 6, child 0 lowest. Exp-Golomb: q = value >> p; as many zeros as q + 1 has bits less
// one, the bits of q + 1 from the highest on, the p low bits of the value.
// The lookup tables are those of shaders/shared/csgvr_c.glsl.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "codecs/bytes.hpp"
#include "codecs/csgvr/blocks.hpp"
#include "volumes/error.hpp"

namespace cvr::codecs::csgvr {

/// How often each shape occurs, [0] above the finest level, [1] in it; keys are BlockShape::bits().
using ShapeCounts = std::array<std::unordered_map<std::uint64_t, std::uint64_t>, 2>;

/// Whether operations are such as an encoder writes: all below 6, and no repeated label before the first of the block.
bool valid_operations(BlockOperations operations);

/// A block's code and what it stands for.
struct CodedBlock {
  std::uint64_t bits;
  std::uint32_t length;
  BlockOperations operations;
};

class BlockCode {
 public:
  /// Codes for these shapes; others are coded with escapes.
  void fit(const ShapeCounts& counts);

  void write(ByteWriter& out) const;
  volumes::Expected<void> read(ByteReader& in);

  /// The shortest code of a block of this shape; of equal ones the first in kAxisOrders.
  CodedBlock shortest(const BlockShape& shape, bool fine) const;

  /// Lookup tables for shaders/shared/csgvr_c.glsl.
  const std::vector<std::uint32_t>& tables() const { return tables_; }

 private:
  struct Code {
    std::uint32_t bits;
    std::uint32_t length;
  };
  /// One of the two codes: patterns in ascending order of their numbers, and after them the escapes.
  struct Side {
    std::vector<BlockOperations> patterns;
    std::vector<std::uint8_t> lengths;
    std::vector<Code> codes;
    void assign_codes();
    /// Of a pattern; nullptr where it has none.
    const Code* find(BlockOperations operations) const;
    const Code& escape(BlockOperations operations) const;

   private:
    static std::uint32_t hash(BlockOperations operations) { return operations * 0x9e3779b1u; }
    std::vector<std::uint16_t> slots_;  ///< places of patterns + 1, open addressing, a power of two
    unsigned hash_shift_ = 31;
  };
  using PatternCounts = std::unordered_map<BlockOperations, std::uint64_t>;

  static CodedBlock code_of(BlockOperations operations, const Side& side);
  static void fit_side(Side& side, const PatternCounts& counts);
  void build_tables();

  std::array<Side, 2> sides_;  ///< coarse, fine
  std::vector<std::uint32_t> tables_;
};

}  // namespace cvr::codecs::csgvr
