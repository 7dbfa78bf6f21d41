// Counter-based randomness: a number is a hash of the seed and of what it is for (a coordinate, an
// index), so that any box of a generated volume can be made alone and in any order. The mixers are
// the finalisers of splitmix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators,
// OOPSLA 2014) and a 32-bit multiply-xorshift of the same form, which vectorises. Integer
// arithmetic only: the same values on every machine.
#pragma once

#include <cstdint>

namespace cvr::volumes {

inline std::uint64_t mix64(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

inline std::uint32_t mix32(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7FEB352Du;
  x = (x ^ (x >> 15)) * 0x846CA68Bu;
  return x ^ (x >> 16);
}

/// A hash of a seed and up to three coordinates, which may be negative.
inline std::uint64_t hash(std::uint64_t seed, std::int64_t a, std::int64_t b = 0,
                          std::int64_t c = 0) {
  const auto u = [](std::int64_t v) { return static_cast<std::uint64_t>(v); };
  return mix64(mix64(mix64(seed ^ u(a)) ^ u(b)) ^ u(c));
}

/// Uniform in [0, 1), a multiple of 2^-24, from the upper bits.
inline float unit_float(std::uint64_t random) {
  return static_cast<float>(random >> 40) * 0x1p-24F;
}

/// Independent uniform numbers in [0, 1) in a row, a multiple of 2^-53 each.
class RandomSequence {
 public:
  explicit RandomSequence(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() { return state_ = mix64(state_); }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Uniform in [low, high).
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Mean 0, variance 1, at most 3.47 from 0: the sum of four uniform numbers.
  double bell() { return (unit() + unit() + unit() + unit() - 2.0) * 1.7320508075688772; }

 private:
  std::uint64_t state_;
};

/// A permutation of [0, count) that needs no table: a four-round Feistel network over the next even
/// number of bits, walked until it falls into the range.
class Permutation {
 public:
  Permutation(std::uint64_t count, std::uint64_t seed) : count_(count), seed_(seed) {
    while (half_bits_ < 32 && (std::uint64_t{1} << (2 * half_bits_)) < count) ++half_bits_;
  }
  std::uint64_t operator()(std::uint64_t index) const {
    const std::uint64_t mask = (std::uint64_t{1} << half_bits_) - 1;
    do {
      std::uint64_t left = index >> half_bits_, right = index & mask;
      for (std::uint64_t round = 0; round < 4; ++round) {
        const std::uint64_t next = left ^ (mix64(seed_ ^ (right * 4 + round)) & mask);
        left = right;
        right = next;
      }
      index = left << half_bits_ | right;
    } while (index >= count_);
    return index;
  }

 private:
  std::uint64_t count_, seed_;
  unsigned half_bits_ = 1;
};

}  // namespace cvr::volumes
