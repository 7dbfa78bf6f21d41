// The structures below the codecs: bit vectors with rank, Morton codes, rANS.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numeric>
#include <sdsl/bit_vectors.hpp>
#include <sdsl/rank_support_v5.hpp>

#include "codecs/entropy/rans.hpp"
#include "codecs/succinct/bit_vector.hpp"
#include "shaders/shared/shared.hpp"
#include "tests/property/arbitrary.hpp"

namespace cvr::property {
namespace {

using codecs::entropy::RansDecoder;
using codecs::entropy::RansTable;
using codecs::succinct::BitAppender;

/// Bits of any density; lengths around the blocks of the flat rank (64, 256, 1280) are as likely as
/// any other.
std::vector<bool> arbitrary_bits() {
  const auto blocks = *rc::gen::element<std::uint64_t>(64, 256, 1280, 2560);
  const auto size = *rc::gen::oneOf(
      rc::gen::inRange<std::uint64_t>(0, 9000),
      rc::gen::map(rc::gen::inRange<std::uint64_t>(0, 3), [=](auto d) { return blocks + d - 1; }));
  const auto seed = *rc::gen::inRange<std::uint64_t>(0, 1u << 20);
  const auto density = *rc::gen::element<std::uint64_t>(0, 1, 30, 128, 255, 256);
  std::vector<bool> bits(size);
  for (std::uint64_t i = 0; i < size; ++i) bits[i] = samples::random_at(seed, i) % 256 < density;
  return bits;
}

/// Appends the bits in random portions, as the encoder does.
BitAppender appended(const std::vector<bool>& bits) {
  BitAppender vector;
  for (std::size_t at = 0; at < bits.size();) {
    const auto count = std::min<std::size_t>(*rc::gen::inRange(1, 65), bits.size() - at);
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < count; ++i) word |= std::uint64_t{bits[at + i]} << i;
    vector.append(word, static_cast<unsigned>(count));
    vector.append(0, 0);
    at += count;
  }
  return vector;
}

/// Rank, then bits, as 32-bit words; rank at word 0.
struct Stored {
  std::vector<std::uint32_t> words;
  shaders::BitVector vector;
};

Stored stored(const BitAppender& bits) {
  Stored s;
  codecs::succinct::append_flat_rank(bits.words(), bits.size(), s.words);
  s.vector = {static_cast<std::uint32_t>(s.words.size()), 0, bits.size()};
  codecs::succinct::append_words(bits.words(), s.words);
  return s;
}

bool check(const Stored& s, std::uint32_t bits) {
  return codecs::succinct::check_flat_rank(s.words.data() + s.vector.bits_at, bits,
                                           s.words.data() + s.vector.rank_at);
}

RC_GTEST_PROP(BitVector, AppendsBitsInOrder, ()) {
  const std::vector<bool> bits = arbitrary_bits();
  const BitAppender vector = appended(bits);
  RC_ASSERT(vector.size() == bits.size());
  RC_ASSERT(vector.words().size() == (bits.size() + 63) / 64);
  for (std::size_t i = 0; i < 64 * vector.words().size(); ++i) {
    RC_ASSERT((vector.words()[i / 64] >> (i % 64) & 1) == (i < bits.size() && bits[i]));
  }
  BitAppender twice = appended(bits);
  twice.append(vector);
  RC_ASSERT(twice.size() == 2 * bits.size());
  for (std::size_t i = 0; i < twice.size(); ++i) {
    RC_ASSERT((twice.words()[i / 64] >> (i % 64) & 1) == bits[i % bits.size()]);
  }
}

RC_GTEST_PROP(BitVector, RankEqualsCountingAndSdsl, ()) {
  const std::vector<bool> bits = arbitrary_bits();
  const Stored s = stored(appended(bits));
  sdsl::bit_vector reference(bits.size());
  for (std::size_t i = 0; i < bits.size(); ++i) reference[i] = bits[i];
  const sdsl::rank_support_v5<1> reference_rank(&reference);
  std::uint32_t ones = 0;
  for (std::uint32_t i = 0; i <= bits.size(); ++i) {
    RC_ASSERT(cvr_rank1({s.words.data()}, s.vector, i) == ones);
    RC_ASSERT(reference_rank(i) == ones);
    if (i == bits.size()) break;
    RC_ASSERT(cvr_bit({s.words.data()}, s.vector, i) == (bits[i] ? 1u : 0u));
    ones += bits[i] ? 1 : 0;
  }
}

RC_GTEST_PROP(BitVector, FlatRankCheckFindsEveryChange, ()) {
  const std::vector<bool> bits = arbitrary_bits();
  RC_PRE(!bits.empty());
  Stored s = stored(appended(bits));
  const auto size = static_cast<std::uint32_t>(bits.size());
  RC_ASSERT(check(s, size));
  // Any bit of the rank, and any bit after the last.
  s.words[*rc::gen::inRange<std::uint32_t>(0, s.vector.bits_at)] ^= 1u << *rc::gen::inRange(0, 32);
  RC_ASSERT(!check(s, size));
  s = stored(appended(bits));
  if (size % 64 != 0) {
    const auto beyond = *rc::gen::inRange<std::uint32_t>(size, (size + 63) / 64 * 64);
    s.words[s.vector.bits_at + beyond / 32] |= 1u << (beyond % 32);
    RC_ASSERT(!check(s, size));
  }
}

RC_GTEST_PROP(BitVector, ExtractAndDepositAreInverse, (std::uint64_t value, std::uint64_t mask)) {
  const std::uint64_t extracted = codecs::succinct::extract_bits(value, mask);
  RC_ASSERT(codecs::succinct::deposit_bits(extracted, mask) == (value & mask));
  unsigned at = 0;
  for (unsigned i = 0; i < 64; ++i) {
    if ((mask >> i & 1) == 0) continue;
    RC_ASSERT((extracted >> at++ & 1) == (value >> i & 1));
  }
  RC_ASSERT(at == 64 || extracted >> at == 0);
}

RC_GTEST_PROP(Morton, EncodeAndGatherAreInverse, ()) {
  const auto coordinate = [] { return *rc::gen::inRange<std::uint32_t>(0, 1024); };
  const std::uint32_t x = coordinate(), y = coordinate(), z = coordinate();
  const std::uint32_t code = shaders::cvr_morton_encode(x, y, z);
  for (unsigned bit = 0; bit < 10; ++bit) {
    RC_ASSERT((code >> (3 * bit) & 7) ==
              ((x >> bit & 1) | (y >> bit & 1) << 1 | (z >> bit & 1) << 2));
  }
  RC_ASSERT(shaders::cvr_morton_gather(code) == x);
  RC_ASSERT(shaders::cvr_morton_gather(code >> 1) == y);
  RC_ASSERT(shaders::cvr_morton_gather(code >> 2) == z);
}

RC_GTEST_PROP(Morton, PlusAndMinusMoveAlongOneAxis, ()) {
  std::array<std::uint32_t, 3> at;
  for (auto& c : at) c = *rc::gen::inRange<std::uint32_t>(0, 1023);
  const auto axis = *rc::gen::inRange(0u, 3u);
  const auto code = [](const auto& c) { return shaders::cvr_morton_encode(c[0], c[1], c[2]); };
  const std::uint32_t here = code(at);
  ++at[axis];
  RC_ASSERT(shaders::cvr_morton_plus(here, axis) == code(at));
  RC_ASSERT(shaders::cvr_morton_minus(code(at), axis) == here);
}

struct RansCase {
  std::vector<std::uint8_t> symbols;
  std::array<std::uint64_t, 16> counts{};
  std::uint32_t possible = 0;
};

/// Symbols of a skewed distribution, and counts that need not be theirs: tables come from sampled
/// bricks.
RansCase arbitrary_symbols() {
  RansCase c;
  c.possible = *rc::gen::inRange<std::uint32_t>(1, 0x10000);
  std::vector<std::uint8_t> alphabet;
  for (unsigned s = 0; s < 16; ++s) {
    if ((c.possible >> s & 1) != 0) alphabet.push_back(static_cast<std::uint8_t>(s));
  }
  const auto size = *rc::gen::inRange<std::size_t>(0, 3000);
  const auto seed = *rc::gen::inRange<std::uint64_t>(0, 1u << 20);
  const auto skew = *rc::gen::element<std::uint64_t>(1, 2, 20, 5000);
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint64_t r = samples::random_at(seed, i);
    c.symbols.push_back(alphabet[r % skew == 0 ? r / skew % alphabet.size() : 0]);
  }
  const auto counting = *rc::gen::inRange(0, 3);
  for (unsigned s = 0; s < 16; ++s)
    c.counts[s] = counting == 1 ? samples::random_at(seed + 1, s) >> 14 : 0;
  if (counting == 2) {
    for (const std::uint8_t s : c.symbols) ++c.counts[s];
  }
  return c;
}

RC_GTEST_PROP(Rans, FittedFrequenciesSumAndAreNeverZeroForWhatIsPossible, ()) {
  const RansCase c = arbitrary_symbols();
  const auto frequencies = RansTable::fit(c.counts, c.possible).frequencies();
  RC_ASSERT(std::accumulate(frequencies.begin(), frequencies.end(), 0u) ==
            codecs::entropy::kRansProbabilitySum);
  for (unsigned s = 0; s < 16; ++s) RC_ASSERT((frequencies[s] > 0) == ((c.possible >> s & 1) != 0));
  RansTable again;
  RC_ASSERT(RansTable::from_frequencies(frequencies, again));
  RC_ASSERT(again.frequencies() == frequencies);
  auto wrong = frequencies;
  ++wrong[*rc::gen::inRange(0, 16)];
  RC_ASSERT(!RansTable::from_frequencies(wrong, again));
}

RC_GTEST_PROP(Rans, AnyStreamRoundTripsAndUsesAllItsBytes, ()) {
  const RansCase c = arbitrary_symbols();
  const RansTable table = RansTable::fit(c.counts, c.possible);
  std::vector<std::uint8_t> bytes{0xab};  // streams are appended
  table.encode(c.symbols, bytes);
  RC_ASSERT(bytes[0] == 0xab);
  const std::span stream(bytes.data() + 1, bytes.size() - 1);
  if (c.symbols.empty()) {
    RC_ASSERT(stream.empty());
    return;
  }
  RansDecoder decoder(table, stream);
  for (const std::uint8_t symbol : c.symbols) RC_ASSERT(decoder.next() == symbol);
  RC_ASSERT(!decoder.failed());
  // One byte less, and the end is missed before the last symbol is out.
  RansDecoder truncated(table, stream.first(stream.size() - 1));
  for (std::size_t i = 0; i < c.symbols.size(); ++i) truncated.next();
  RC_ASSERT(truncated.failed());
}

}  // namespace
}  // namespace cvr::property
