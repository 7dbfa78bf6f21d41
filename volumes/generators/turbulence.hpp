// Octaves of value noise whose amplitudes follow a power spectrum: what `turbulence` and `moving`
// share.
//
// Octave k has its lattice points 2^k voxels apart, from `smallest` to `largest`. A spectrum of
// energy E(f) ~ f^-slope over the frequency f holds 2^((slope - 1) k) times as much energy in
// octave k as in octave 0, so amplitudes grow by 2^((slope - 1) / 2); 5/3 is Kolmogorov's slope.
// The sum is scaled to a standard deviation of 1/6 about 1/2 and cut to 0..1.
#pragma once

#include <vector>

#include "volumes/generators/noise.hpp"
#include "volumes/generators/tiled_source.hpp"

namespace cvr::volumes {

struct OctaveRange {
  unsigned smallest, largest;  ///< log2 of voxels between lattice points
};

/// From the parameters "smallest" and "largest", in voxels, rounded down to powers of two;
/// `largest` is at least `smallest`.
OctaveRange octaves_of(const GeneratorRequest& request);

/// Amplitudes of the octaves, smallest first, which make the sum's standard deviation 1/6.
std::vector<float> amplitudes_of(const OctaveRange& octaves, double slope);

/// 0.5 + sum, cut to 0..1.
void to_values(std::uint64_t count, float* sums);

}  // namespace cvr::volumes
