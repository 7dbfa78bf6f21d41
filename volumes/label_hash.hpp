// The hash of the tables that find labels. Labels come from outside, so every bit of them has to
// reach every bit of the hash: products with a constant alone leave labels together that differ in
// their high bits, or are multiples of what the constant divides.
#pragma once

#include <cstdint>

namespace cvr::volumes {

/// A permutation of 64 bits (the finaliser of MurmurHash3, Appleby 2011).
constexpr std::uint64_t hash_of(std::uint64_t label) {
  label ^= label >> 33;
  label *= 0xff51afd7ed558ccdu;
  label ^= label >> 33;
  label *= 0xc4ceb9fe1a85ec53u;
  return label ^ label >> 33;
}

}  // namespace cvr::volumes
