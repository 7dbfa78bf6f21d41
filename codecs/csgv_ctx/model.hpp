// The static tables of a volume: which distribution codes a symbol in a context, and those of the
// numbers (counts, ranks, distances).
//
// Contexts are the leaves of decision trees. A first tree splits by static bits; each of its
// leaves, a class, has a second tree that splits by at most kMostDynamic dynamic bits. Both are
// flattened here: `classes` has a word for each static context (the dynamic bits that its class
// asks for, and where its rows begin), `rows` the distribution for each value of these bits. There
// are two pairs of trees, for the finest level and for all others, where a symbol carries a stop
// bit.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codecs/bit_stream.hpp"
#include "codecs/csgv/reconstruct.hpp"
#include "codecs/csgv_ctx/contexts.hpp"
#include "codecs/csgv_ctx/rans_stream.hpp"
#include "codecs/succinct/bit_vector.hpp"

namespace cvr::codecs::csgv_ctx {

inline constexpr unsigned kMostDynamic = 7;  ///< dynamic bits of a class
inline constexpr unsigned kMostRows = 128;   ///< distributions of a pair of trees
inline constexpr unsigned kMostRowEntries = 1u << (32 - kDynamicBits);

/// Splits by one bit of the context, or is a leaf.
struct TreeNode {
  std::int32_t bit = -1;  ///< -1: a leaf
  std::array<std::uint32_t, 2>
      next{};  ///< node for each value of the bit; of a leaf [0]: the second tree's root, or the distribution
};

/// A pair of trees: nodes[root] splits by static bits; its leaves name roots of trees that split by
/// dynamic bits.
struct ContextTrees {
  std::vector<TreeNode> nodes;
  std::uint32_t root = 0;
  std::vector<Distribution> distributions;
};

/// The alphabets: operations of the finest level; operations with stop bits.
inline constexpr std::array<std::uint32_t, 2> kPossible{0x007f, 0x7f7f};

// A reference to an older palette entry is coded by the width of its distance minus one (one of 16
// symbols) and the bits below the highest one. Which distribution codes the width depends on how
// many older entries there are.
inline constexpr unsigned kNumberKinds = 8;
/// The distribution of a number that is below `bound` >= 2.
constexpr unsigned number_class(std::uint32_t bound) {
  const unsigned width = static_cast<unsigned>(std::bit_width(bound - 1)) - 1;
  return width < kNumberKinds ? width : kNumberKinds - 1;
}
/// Symbol of a number's width; from kWide on all numbers share one, and have kWideBits bits.
inline constexpr unsigned kWide = 15;
inline constexpr unsigned kWideBits = 24;

class ContextModel {
 public:
  ContextModel() = default;
  /// [0] for the finest level, [1] for all others.
  ContextModel(std::array<ContextTrees, 2> trees, std::array<Distribution, kNumberKinds> numbers);

  void write(BitWriter& out) const;
  /// What is wrong with the bits, or nullptr.
  static csgv::BrickError read(BitReader& in, ContextModel& model);

  /// Number of the distribution for a symbol.
  std::uint32_t row(std::uint32_t static_bits, std::uint32_t dynamic_bits) const {
    const std::uint32_t c = classes_[static_bits];
    return rows_[(c >> kDynamicBits) + static_cast<std::uint32_t>(succinct::extract_bits(
                                           dynamic_bits, c & ((1u << kDynamicBits) - 1)))];
  }
  const Distribution& distribution(std::uint32_t row) const { return distributions_[row]; }
  const Distribution& number(unsigned kind) const { return distributions_[first_number_ + kind]; }
  std::uint32_t first_number() const { return first_number_; }

  std::span<const std::uint32_t> classes() const { return classes_; }
  std::span<const std::uint8_t> rows() const { return rows_; }
  std::span<const Distribution> distributions() const { return distributions_; }

 private:
  void flatten();

  std::array<ContextTrees, 2> trees_;
  std::array<Distribution, kNumberKinds> numbers_;
  std::vector<std::uint32_t>
      classes_;  ///< 2^kStaticBits: dynamic bits, then the first row << kDynamicBits
  std::vector<std::uint8_t> rows_;
  std::vector<Distribution> distributions_;  ///< of the finest level, of the others, of the numbers
  std::uint32_t first_number_ = 0;
};

/// Frequencies of 2^12 in all, close to the counts: at least 1 for each symbol of `possible`, and
/// such that few bits name them.
Distribution fit_distribution(const std::array<std::uint64_t, kSymbols>& counts,
                              std::uint32_t possible);

}  // namespace cvr::codecs::csgv_ctx
