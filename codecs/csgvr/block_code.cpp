#include "codecs/csgvr/block_code.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "codecs/entropy/prefix_code.hpp"
#include "codecs/succinct/bit_vector.hpp"
#include "shaders/shared/shared.hpp"

namespace cvr::codecs::csgvr {

using volumes::ErrorCode;
using volumes::Expected;
using volumes::fail;

namespace {

constexpr unsigned kFitRounds = 3;  ///< shapes are given the contents that the last round's code makes short
constexpr unsigned kMostLength = CVR_C_MOST_CODE_BITS;
constexpr std::uint32_t kRawBits = 24;        ///< operations after an escape
constexpr std::uint32_t kPatterns = 1679616;  ///< 6^8
constexpr std::uint64_t kMostPatterns = std::uint64_t{1} << 14;
/// What a pattern must save to be worth its place in the table, and the escape that is expected before there is one.
constexpr double kWorthBits = 25;
constexpr double kExpectedEscape = 4;

std::uint32_t number_of(BlockOperations operations) {
  std::uint32_t number = 0;
  for (unsigned c = 8; c-- > 0;) number = 6 * number + (operations >> (3 * c) & 7);
  return number;
}

BlockOperations pattern_of(std::uint32_t number) {
  BlockOperations operations = 0;
  for (unsigned c = 0; c < 8; ++c, number /= 6) operations |= number % 6 << (3 * c);
  return operations;
}

void put_exp_golomb(succinct::BitAppender& out, std::uint32_t value, unsigned parameter) {
  const std::uint64_t q = (std::uint64_t{value} >> parameter) + 1;
  const auto more = static_cast<unsigned>(std::bit_width(q)) - 1;
  out.append(0, more);
  for (unsigned i = more + 1; i-- > 0;) out.append(q >> i & 1, 1);
  out.append(value & ((1u << parameter) - 1), parameter);
}

unsigned exp_golomb_bits(std::uint32_t value, unsigned parameter) {
  return 2 * static_cast<unsigned>(std::bit_width((std::uint64_t{value} >> parameter) + 1)) - 1 + parameter;
}

/// Reads bits, first bit lowest; zeros after the end, and failed().
class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::uint64_t take(unsigned count) {
    std::uint64_t value = 0;
    for (unsigned i = 0; i < count; ++i, ++at_) {
      if (at_ / 8 < bytes_.size()) value |= (static_cast<std::uint64_t>(bytes_[at_ / 8]) >> (at_ % 8) & 1) << i;
    }
    return value;
  }
  /// More than 2^32 - 1 counts as a failure.
  std::uint32_t take_exp_golomb(unsigned parameter) {
    unsigned more = 0;
    while (more <= 32 && take(1) == 0) ++more;
    std::uint64_t q = 1;
    for (unsigned i = 0; i < more; ++i) q = q << 1 | take(1);
    const std::uint64_t value = (q - 1) << parameter | take(parameter);
    if (more > 32 || value > ~std::uint32_t{0}) at_ = ~std::uint64_t{0} / 2;
    return static_cast<std::uint32_t>(value);
  }
  bool failed() const { return at_ > 8 * bytes_.size(); }
  bool whole() const { return (at_ + 7) / 8 == bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  std::uint64_t at_ = 0;
};

}  // namespace

bool valid_operations(BlockOperations operations) {
  if ((operations >> 2 & operations >> 1 & 0x249249) != 0) return false;  // 6 and 7
  const std::uint32_t own = shaders::cvr_c_own_labels(operations);
  const std::uint32_t repeated = operations >> 2 & operations & 0x249249;
  return repeated == 0 || (own != 0 && std::countr_zero(own) < std::countr_zero(repeated));
}

void BlockCode::Side::assign_codes() {
  const std::vector<std::uint32_t> bits = entropy::prefix_codes(lengths);
  codes.clear();
  places.clear();
  for (std::size_t i = 0; i < bits.size(); ++i) codes.push_back({bits[i], lengths[i]});
  for (std::uint32_t i = 0; i < patterns.size(); ++i) places.emplace(patterns[i], i);
}

CodedBlock BlockCode::code_of(BlockOperations operations, const Side& side) {
  if (const auto place = side.places.find(operations); place != side.places.end()) {
    const Code& code = side.codes[place->second];
    return {code.bits, code.length, operations};
  }
  const Code& escape = side.escape();
  return {escape.bits | std::uint64_t{operations} << escape.length, escape.length + kRawBits, operations};
}

CodedBlock BlockCode::shortest(const BlockShape& shape, bool fine) const {
  const Side& side = sides_[fine];
  CodedBlock best = code_of(shape.operations(kAxisOrders[0]), side);
  if (!shape.ambiguous()) return best;
  for (std::size_t i = 1; i < kAxisOrders.size(); ++i) {
    const BlockOperations operations = shape.operations(kAxisOrders[i]);
    if (operations == best.operations) continue;
    const CodedBlock other = code_of(operations, side);
    if (other.length < best.length) best = other;
  }
  return best;
}

/// Gives codes to the patterns that are worth it.
void BlockCode::fit_side(Side& side, const PatternCounts& counts) {
  std::uint64_t total = 1;
  for (const auto& [pattern, count] : counts) total += count;
  struct Candidate {
    std::uint32_t number;
    std::uint64_t count;
  };
  std::vector<Candidate> candidates;
  std::uint64_t escaped = 0;
  for (const auto& [pattern, count] : counts) {
    const auto times = static_cast<double>(count);
    if (times * (kExpectedEscape + kRawBits - std::log2(static_cast<double>(total) / times)) > kWorthBits || pattern == 0) {
      candidates.push_back({number_of(pattern), count});
    } else {
      escaped += count;
    }
  }
  if (!counts.contains(0)) candidates.push_back({0, 1});  // two codes at least
  if (candidates.size() > kMostPatterns) {
    std::ranges::sort(candidates, [](const Candidate& a, const Candidate& b) {
      return a.count != b.count ? a.count > b.count : a.number < b.number;
    });
    for (std::size_t i = kMostPatterns; i < candidates.size(); ++i) escaped += candidates[i].count;
    candidates.resize(kMostPatterns);
    if (std::ranges::none_of(candidates, [](const Candidate& c) { return c.number == 0; })) candidates.back() = {0, 1};
  }
  std::ranges::sort(candidates, {}, &Candidate::number);
  std::vector<std::uint64_t> weights;
  side.patterns.clear();
  for (const Candidate& c : candidates) {
    side.patterns.push_back(pattern_of(c.number));
    weights.push_back(c.count);
  }
  weights.push_back(std::max<std::uint64_t>(escaped, 1));
  side.lengths = entropy::prefix_code_lengths(weights, kMostLength);
  side.assign_codes();
}

void BlockCode::fit(const ShapeCounts& counts) {
  for (unsigned fine = 0; fine < 2; ++fine) {
    for (unsigned round = 0; round < kFitRounds; ++round) {
      PatternCounts patterns;
      for (const auto& [bits, count] : counts[fine]) {
        const BlockShape shape = BlockShape::from_bits(bits);
        patterns[round == 0 ? shape.operations(shape.widest_first()) : shortest(shape, fine != 0).operations] += count;
      }
      fit_side(sides_[fine], patterns);
    }
  }
  build_tables();
}

void BlockCode::write(ByteWriter& out) const {
  succinct::BitAppender bits;
  for (const Side* side : {&sides_[1], &sides_[0]}) {
    std::vector<std::uint32_t> gaps;
    std::uint32_t next = 0;
    for (const BlockOperations pattern : side->patterns) {
      gaps.push_back(number_of(pattern) - next);
      next = number_of(pattern) + 1;
    }
    unsigned best = 0;
    std::uint64_t fewest = ~std::uint64_t{0};
    for (unsigned p = 0; p < 32; ++p) {
      std::uint64_t sum = 0;
      for (const std::uint32_t gap : gaps) sum += exp_golomb_bits(gap, p);
      if (sum < fewest) best = p;
      fewest = std::min(fewest, sum);
    }
    bits.append(gaps.size() - 1, 16);
    bits.append(best, 5);
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      put_exp_golomb(bits, gaps[i], best);
      bits.append(side->lengths[i] - 1u, 4);
    }
    bits.append(side->lengths.back() - 1u, 4);
  }
  for (std::uint32_t i = 0; i < (bits.size() + 7) / 8; ++i) out.put(static_cast<std::uint8_t>(bits.words()[i / 8] >> (8 * (i % 8))));
}

Expected<void> BlockCode::read(ByteReader& in) {
  BitReader bits(in.take(in.remaining()));
  for (Side* side : {&sides_[1], &sides_[0]}) {
    const std::string_view name = side == &sides_[1] ? "fine" : "coarse";
    const std::uint64_t count = bits.take(16) + 1;
    const auto parameter = static_cast<unsigned>(bits.take(5));
    std::uint64_t next = 0;
    *side = {};
    for (std::uint64_t i = 0; i < count && !bits.failed(); ++i) {
      const std::uint64_t number = next + bits.take_exp_golomb(parameter);
      side->lengths.push_back(static_cast<std::uint8_t>(bits.take(4) + 1));
      if (bits.failed()) break;
      if (number >= kPatterns || !valid_operations(pattern_of(static_cast<std::uint32_t>(number)))) {
        return fail(ErrorCode::kMalformed, fmt::format("{} code, pattern {}: {} is no block that an encoder writes", name, i, number));
      }
      side->patterns.push_back(pattern_of(static_cast<std::uint32_t>(number)));
      next = number + 1;
    }
    side->lengths.push_back(static_cast<std::uint8_t>(bits.take(4) + 1));
    if (bits.failed()) return fail(ErrorCode::kTruncated, fmt::format("{} code: the tables end within it", name));
    if (count > kMostPatterns || !entropy::is_complete_prefix_code(side->lengths)) {
      return fail(ErrorCode::kMalformed, fmt::format("{} code: expected at most {} patterns, and lengths that use up all codes", name,
                                                     kMostPatterns));
    }
    side->assign_codes();
  }
  if (!bits.whole()) return fail(ErrorCode::kMalformed, "block codes: the tables go on behind them");
  build_tables();
  return {};
}

/// Enters the codes of a side into the lookup from word `first` on; its patterns lie from word `patterns_at` on.
void BlockCode::add_lookups(const Side& side, std::size_t first, std::size_t patterns_at) {
  std::array<unsigned, CVR_C_LOOKUP> further{};  // bits of the longest code behind each lookup
  for (const Code& code : side.codes) {
    if (code.length <= CVR_C_LOOKUP_BITS) continue;
    unsigned& bits = further[code.bits % CVR_C_LOOKUP];
    bits = std::max(bits, code.length - CVR_C_LOOKUP_BITS);
  }
  for (std::uint32_t i = 0; i < CVR_C_LOOKUP; ++i) {
    if (further[i] == 0) continue;
    tables_[first + i] = CVR_C_RARE | further[i] << 24 | static_cast<std::uint32_t>(tables_.size()) << 5;
    tables_.resize(tables_.size() + (std::size_t{1} << further[i]));
  }
  for (std::size_t i = 0; i < side.codes.size(); ++i) {
    const auto [bits, length] = side.codes[i];
    std::uint32_t entry = CVR_C_RARE | length;
    if (i < side.patterns.size()) {
      entry = length | static_cast<std::uint32_t>(patterns_at + i) << 5 |
              static_cast<std::uint32_t>(std::popcount(shaders::cvr_c_own_labels(side.patterns[i]))) << 24;
    }
    std::size_t at = first + bits;
    std::size_t end = first + CVR_C_LOOKUP;
    std::uint32_t stride = 1u << length;
    if (length > CVR_C_LOOKUP_BITS) {
      const std::uint32_t link = tables_[first + bits % CVR_C_LOOKUP];
      at = (link >> 5 & 0x7ffff) + (bits >> CVR_C_LOOKUP_BITS);
      end = (link >> 5 & 0x7ffff) + (std::size_t{1} << (link >> 24 & 15));
      stride = 1u << (length - CVR_C_LOOKUP_BITS);
    }
    for (; at < end; at += stride) tables_[at] = entry;
  }
}

/// [lookup, coarse][lookup, fine][patterns, coarse][patterns, fine][entries of longer codes]
void BlockCode::build_tables() {
  tables_.assign(2 * CVR_C_LOOKUP, 0);
  for (const Side& side : sides_) tables_.insert(tables_.end(), side.patterns.begin(), side.patterns.end());
  add_lookups(sides_[0], 0, 2 * CVR_C_LOOKUP);
  add_lookups(sides_[1], CVR_C_LOOKUP, 2 * CVR_C_LOOKUP + sides_[0].patterns.size());
}

}  // namespace cvr::codecs::csgvr
