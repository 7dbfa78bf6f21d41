#include "codecs/csgvr/block_code.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "codecs/bit_stream.hpp"
#include "codecs/entropy/prefix_code.hpp"
#include "shaders/shared/shared.hpp"

namespace cvr::codecs::csgvr {

using volumes::ErrorCode;
using volumes::Expected;
using volumes::fail;

namespace {

constexpr unsigned kMostLength = CVR_C_CODE_BITS;
constexpr std::uint32_t kRawBits = CVR_C_RAW_BITS;
constexpr unsigned kEscapes = 9;              ///< by labels of their own
constexpr std::uint32_t kPatterns = 1679616;  ///< 6^8
constexpr std::uint64_t kMostPatterns =
    std::uint64_t{1} << 12;  ///< of a code, half of what 13 bits could tell apart
/// What a pattern must save to be worth its place in the table, and the escape that is expected
/// before there is one.
constexpr double kWorthBits = 25;
constexpr double kExpectedEscape = 4;

unsigned labels_of(BlockOperations operations) {
  return static_cast<unsigned>(std::popcount(shaders::cvr_c_own_labels(operations)));
}

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

void put_exp_golomb(BitWriter& out, std::uint32_t value, unsigned parameter) {
  const std::uint64_t q = (std::uint64_t{value} >> parameter) + 1;
  const auto more = static_cast<unsigned>(std::bit_width(q)) - 1;
  out.put(0, more);
  for (unsigned i = more + 1; i-- > 0;) out.put(static_cast<std::uint32_t>(q >> i & 1), 1);
  out.put(value & ((1u << parameter) - 1), parameter);
}

unsigned exp_golomb_bits(std::uint32_t value, unsigned parameter) {
  return 2 * static_cast<unsigned>(std::bit_width((std::uint64_t{value} >> parameter) + 1)) - 1 +
         parameter;
}

/// False above 2^32 - 1.
bool take_exp_golomb(BitReader& in, unsigned parameter, std::uint32_t& value) {
  unsigned more = 0;
  while (more <= 32 && in.get(1) == 0) ++more;
  if (more > 32) return false;
  std::uint64_t q = 1;
  for (unsigned i = 0; i < more; ++i) q = q << 1 | in.get(1);
  const std::uint64_t wide = (q - 1) << parameter | in.get(parameter);
  value = static_cast<std::uint32_t>(wide);
  return value == wide;
}

}  // namespace

bool valid_operations(BlockOperations operations) {
  if ((operations >> 2 & operations >> 1 & 0x249249) != 0) return false;  // 6 and 7
  const std::uint32_t own = shaders::cvr_c_own_labels(operations);
  const std::uint32_t repeated = operations >> 2 & operations & 0x249249;
  return repeated == 0 || (own != 0 && std::countr_zero(own) < std::countr_zero(repeated));
}

BlockOperations most_frequent(const BlockShape& shape, const KeyCounts& patterns) {
  BlockOperations best = shape.operations(kAxisOrders[0]);
  const auto others = shape.other_orders();
  if (others.empty()) return best;
  std::uint64_t most = patterns.count(best);
  for (const unsigned i : others) {
    const BlockOperations operations = shape.operations(kAxisOrders[i]);
    if (operations == best) continue;
    const std::uint64_t count = patterns.count(operations);
    if (count > most) {
      most = count;
      best = operations;
    }
  }
  return best;
}

void BlockCode::Side::assign_codes() {
  const std::vector<std::uint32_t> bits = entropy::prefix_codes(lengths);
  codes.clear();
  for (std::size_t i = 0; i < bits.size(); ++i) codes.push_back({bits[i], lengths[i]});
  hash_shift_ = 31 - static_cast<unsigned>(std::bit_width(patterns.size()));
  slots_.assign(std::size_t{1} << (32 - hash_shift_), {});
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    std::size_t at = hash(patterns[i]) >> hash_shift_;
    while (slots_[at].length != 0) at = (at + 1) & (slots_.size() - 1);
    slots_[at] = {patterns[i], static_cast<std::uint16_t>(codes[i].bits),
                  static_cast<std::uint16_t>(codes[i].length)};
  }
}

CodedBlock BlockCode::Side::coded(BlockOperations operations) const {
  const unsigned labels = labels_of(operations);
  const auto block = [&](std::uint64_t bits, std::uint32_t length) {
    return CodedBlock{bits, operations, static_cast<std::uint16_t>(length),
                      static_cast<std::uint16_t>(labels)};
  };
  for (std::size_t at = hash(operations) >> hash_shift_; slots_[at].length != 0;
       at = (at + 1) & (slots_.size() - 1)) {
    if (slots_[at].operations == operations) return block(slots_[at].bits, slots_[at].length);
  }
  const Code& escape = codes[patterns.size() + labels];
  return block(escape.bits | std::uint64_t{operations} << escape.length, escape.length + kRawBits);
}

/// Gives codes to the patterns that are worth it.
void BlockCode::fit_side(Side& side, const KeyCounts& patterns) {
  std::uint64_t total = 1;
  for (const auto& [key, count] : patterns.entries()) total += count;
  struct Candidate {
    std::uint32_t number;
    std::uint64_t count;
  };
  std::vector<Candidate> candidates;
  std::array<std::uint64_t, kEscapes> escaped{};
  for (const auto& [key, count] : patterns.entries()) {
    const auto pattern = static_cast<BlockOperations>(key);
    const auto times = static_cast<double>(count);
    if (times * (kExpectedEscape + kRawBits - std::log2(static_cast<double>(total) / times)) >
        kWorthBits) {
      candidates.push_back({number_of(pattern), count});
    } else {
      escaped[labels_of(pattern)] += count;
    }
  }
  if (candidates.size() > kMostPatterns) {
    std::ranges::sort(candidates, [](const Candidate& a, const Candidate& b) {
      return a.count != b.count ? a.count > b.count : a.number < b.number;
    });
    for (std::size_t i = kMostPatterns; i < candidates.size(); ++i) {
      escaped[labels_of(pattern_of(candidates[i].number))] += candidates[i].count;
    }
    candidates.resize(kMostPatterns);
  }
  std::ranges::sort(candidates, {}, &Candidate::number);
  std::vector<std::uint64_t> weights;
  for (const Candidate& c : candidates) {
    side.patterns.push_back(pattern_of(c.number));
    weights.push_back(c.count);
  }
  for (const std::uint64_t count : escaped) weights.push_back(std::max<std::uint64_t>(count, 1));
  side.lengths = entropy::prefix_code_lengths(weights, kMostLength);
  side.assign_codes();
}

BlockCode::BlockCode(const PatternCounts& patterns) {
  for (unsigned fine = 0; fine < 2; ++fine) fit_side(sides_[fine], patterns[fine]);
  build_tables();
}

void BlockCode::write(ByteWriter& out) const {
  std::vector<std::uint32_t> words;
  BitWriter bits(words);
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
    bits.put(static_cast<std::uint32_t>(gaps.size()), 16);
    bits.put(best, 5);
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      put_exp_golomb(bits, gaps[i], best);
      bits.put(side->lengths[i] - 1u, 4);
    }
    for (std::size_t i = gaps.size(); i < side->lengths.size(); ++i)
      bits.put(side->lengths[i] - 1u, 4);
  }
  out.append(std::as_bytes(std::span(words)).first((bits.bits() + 7) / 8));
}

Expected<BlockCode> BlockCode::read(ByteReader& in) {
  BlockCode code;
  const auto bytes = in.take(in.remaining());
  std::vector<std::uint32_t> words((bytes.size() + 3) / 4);
  if (!bytes.empty()) std::memcpy(words.data(), bytes.data(), bytes.size());
  BitReader bits(words);
  for (Side* side : {&code.sides_[1], &code.sides_[0]}) {
    const std::string_view name = side == &code.sides_[1] ? "fine" : "coarse";
    const std::uint32_t count = bits.get(16);
    const unsigned parameter = bits.get(5);
    std::uint64_t next = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      std::uint32_t gap = 0;
      const bool numbered = take_exp_golomb(bits, parameter, gap);
      const std::uint64_t number = next + gap;
      side->lengths.push_back(static_cast<std::uint8_t>(bits.get(4) + 1));
      if (bits.failed()) break;
      if (!numbered || number >= kPatterns ||
          !valid_operations(pattern_of(static_cast<std::uint32_t>(number)))) {
        return fail(ErrorCode::kMalformed,
                    fmt::format("{} code, pattern {}: {} is no block that an encoder writes", name,
                                i, number));
      }
      side->patterns.push_back(pattern_of(static_cast<std::uint32_t>(number)));
      next = number + 1;
    }
    for (unsigned i = 0; i < kEscapes; ++i)
      side->lengths.push_back(static_cast<std::uint8_t>(bits.get(4) + 1));
    if (bits.failed() || bits.position() > 8 * bytes.size()) {
      return fail(ErrorCode::kTruncated, fmt::format("{} code: the tables end within it", name));
    }
    if (count > kMostPatterns || std::ranges::max(side->lengths) > kMostLength ||
        !entropy::is_complete_prefix_code(side->lengths)) {
      return fail(
          ErrorCode::kMalformed,
          fmt::format("{} code: expected at most {} patterns, and lengths that use up all codes",
                      name, kMostPatterns));
    }
    side->assign_codes();
  }
  if ((bits.position() + 7) / 8 != bytes.size())
    return fail(ErrorCode::kMalformed, "block codes: the tables go on behind them");
  code.build_tables();
  return code;
}

/// As shaders/shared/csgvr_c.glsl has them.
void BlockCode::build_tables() {
  tables_.assign(CVR_C_OPERATIONS, 0);
  for (unsigned fine = 0; fine < 2; ++fine) {
    const Side& side = sides_[fine];
    for (std::size_t k = 0; k < side.codes.size(); ++k) {
      const auto [bits, length] = side.codes[k];
      const bool escape = k >= side.patterns.size();
      const auto labels = static_cast<std::uint32_t>(escape ? k - side.patterns.size()
                                                            : labels_of(side.patterns[k]));
      const std::uint32_t entry = (escape ? length + kRawBits : length) | labels << 6;
      const auto place = static_cast<std::uint32_t>(escape ? CVR_C_NO_PLACE
                                                           : tables_.size() - CVR_C_OPERATIONS + k);
      for (std::uint32_t i = fine * CVR_C_LOOKUP + bits; i < (fine + 1) * CVR_C_LOOKUP;
           i += 1u << length) {
        tables_[i / 2] |= entry << (16 * (i % 2));
        tables_[CVR_C_PLACES + i / 2] |= place << (16 * (i % 2));
      }
    }
    tables_.insert(tables_.end(), side.patterns.begin(), side.patterns.end());
  }
}

}  // namespace cvr::codecs::csgvr
