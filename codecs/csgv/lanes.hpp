// Eight labels at once: the 2x2x2 children of one node, lane c = x + 2y + 4z.
//
// Two texts, one behaviour: AVX2 where the build has it, plain loops otherwise (and with
// CVR_SCALAR, which the tests build).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#if defined(__AVX2__) && !defined(CVR_SCALAR)
#define CVR_LANES_AVX2 1
#include <immintrin.h>
#endif

namespace cvr::codecs::csgv {

/// Spreads the bits of an 8-bit mask to the low bits of 8 bytes: kSpread[m] has byte c = bit c of
/// m.
inline constexpr auto kSpread = [] {
  std::array<std::uint64_t, 256> table{};
  for (std::uint64_t mask = 0; mask < 256; ++mask) {
    for (unsigned c = 0; c < 8; ++c) table[mask] |= (mask >> c & 1) << (8 * c);
  }
  return table;
}();

/// Collects bit 0 of each of 8 bytes.
inline unsigned gather_low_bits(std::uint64_t bytes) {
  return static_cast<unsigned>(((bytes & 0x0101010101010101u) * 0x0102040810204080u) >> 56);
}

/// Spreads 8 nibbles to 8 bytes.
inline std::uint64_t nibbles_to_bytes(std::uint32_t nibbles) {
  std::uint64_t v = nibbles;
  v = (v | (v << 16)) & 0x0000ffff0000ffffu;
  v = (v | (v << 8)) & 0x00ff00ff00ff00ffu;
  return (v | (v << 4)) & 0x0f0f0f0f0f0f0f0fu;
}

#ifdef CVR_LANES_AVX2

struct Lanes {
  __m256i v;

  static Lanes load(const std::uint32_t* labels) {
    return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(labels))};
  }
  static Lanes broadcast(std::uint32_t label) {
    return {_mm256_set1_epi32(static_cast<int>(label))};
  }
  void store(std::uint32_t* labels) const {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(labels), v);
  }
  /// The eight bytes of a word, the lowest first.
  static Lanes of_bytes(std::uint64_t bytes) {
    return {_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(bytes)))};
  }
  /// All bits of the lanes in a mask of 8 bits.
  static Lanes where(unsigned mask) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return {
        _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(mask)), bit), bit)};
  }
  /// All bits of the lanes where the two agree.
  Lanes same(Lanes other) const { return {_mm256_cmpeq_epi32(v, other.v)}; }
  /// Lanes where the two agree, as a mask of 8 bits.
  unsigned equal(Lanes other) const {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(same(other).v)));
  }
  Lanes operator|(Lanes other) const { return {_mm256_or_si256(v, other.v)}; }
  Lanes operator&(Lanes other) const { return {_mm256_and_si256(v, other.v)}; }
  /// This & ~other.
  Lanes without(Lanes other) const { return {_mm256_andnot_si256(other.v, v)}; }
  Lanes operator<<(int count) const { return {_mm256_slli_epi32(v, count)}; }
  /// Lane c is the lane of this that lane c of `places` names.
  Lanes picked(Lanes places) const { return {_mm256_permutevar8x32_epi32(v, places.v)}; }
  /// This, with the lanes of which `where` has all bits taken from `other`.
  Lanes replaced(Lanes other, Lanes where) const {
    return {_mm256_blendv_epi8(v, other.v, where.v)};
  }
  /// What a neighbour operation along an axis copies: children at 0 take the child at 1 of the
  /// block `minus`, children at 1 take the label `plus` of the next coarser level.
  static Lanes neighbours_x(Lanes minus, std::uint32_t plus) {
    return {_mm256_blend_epi32(_mm256_shuffle_epi32(minus.v, 0xf5), broadcast(plus).v, 0xaa)};
  }
  static Lanes neighbours_y(Lanes minus, std::uint32_t plus) {
    return {_mm256_blend_epi32(_mm256_shuffle_epi32(minus.v, 0xee), broadcast(plus).v, 0xcc)};
  }
  static Lanes neighbours_z(Lanes minus, std::uint32_t plus) {
    return {_mm256_blend_epi32(_mm256_permute2x128_si256(minus.v, minus.v, 0x11), broadcast(plus).v,
                               0xf0)};
  }
};

#else

struct Lanes {
  std::array<std::uint32_t, 8> v;

  static Lanes load(const std::uint32_t* labels) {
    Lanes lanes;
    std::memcpy(lanes.v.data(), labels, sizeof lanes.v);
    return lanes;
  }
  static Lanes broadcast(std::uint32_t label) {
    Lanes lanes;
    lanes.v.fill(label);
    return lanes;
  }
  void store(std::uint32_t* labels) const { std::memcpy(labels, v.data(), sizeof v); }
  template <class Of>
  static Lanes made(Of&& of) {
    Lanes lanes;
    for (unsigned c = 0; c < 8; ++c) lanes.v[c] = of(c);
    return lanes;
  }
  static Lanes of_bytes(std::uint64_t bytes) {
    return made([&](unsigned c) { return static_cast<std::uint32_t>(bytes >> (8 * c) & 0xff); });
  }
  static Lanes where(unsigned mask) {
    return made([&](unsigned c) { return 0u - (mask >> c & 1); });
  }
  Lanes same(Lanes other) const {
    return made([&](unsigned c) { return v[c] == other.v[c] ? ~0u : 0u; });
  }
  unsigned equal(Lanes other) const {
    unsigned mask = 0;
    for (unsigned c = 0; c < 8; ++c) mask |= (v[c] == other.v[c] ? 1u : 0u) << c;
    return mask;
  }
  Lanes operator|(Lanes other) const {
    return made([&](unsigned c) { return v[c] | other.v[c]; });
  }
  Lanes operator&(Lanes other) const {
    return made([&](unsigned c) { return v[c] & other.v[c]; });
  }
  Lanes without(Lanes other) const {
    return made([&](unsigned c) { return v[c] & ~other.v[c]; });
  }
  Lanes operator<<(int count) const {
    return made([&](unsigned c) { return v[c] << count; });
  }
  Lanes picked(Lanes places) const {
    return made([&](unsigned c) { return v[places.v[c] & 7]; });
  }
  Lanes replaced(Lanes other, Lanes where) const {
    return made([&](unsigned c) { return where.v[c] != 0 ? other.v[c] : v[c]; });
  }
  static Lanes neighbours(Lanes minus, std::uint32_t plus, unsigned bit) {
    return made([&](unsigned c) { return (c & bit) != 0 ? plus : minus.v[c | bit]; });
  }
  static Lanes neighbours_x(Lanes minus, std::uint32_t plus) { return neighbours(minus, plus, 1); }
  static Lanes neighbours_y(Lanes minus, std::uint32_t plus) { return neighbours(minus, plus, 2); }
  static Lanes neighbours_z(Lanes minus, std::uint32_t plus) { return neighbours(minus, plus, 4); }
};

#endif

}  // namespace cvr::codecs::csgv
