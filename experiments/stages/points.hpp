// The points of the random-access stage: seeded, the same for every codec, any first n of them a
// point set of its own.
//
// uniform:   every voxel equally likely
// clustered: along rays of random entry and direction, one voxel's edge apart, as a ray caster
// meets them one-label: voxels of one label, chosen by a random voxel that is not 0 where there is
// one, in random order
#pragma once

#include <cstdint>
#include <vector>

#include "volumes/source.hpp"

namespace cvr::experiments {

/// How many points a series has: 1000 by bricks, else 1e5, and more (up to 2e6) where three series
/// a level would take less than 50 ms. `access_ns` is what codecs::estimate_memory knows of the
/// codec, so the count is the same on every machine.
std::uint64_t points_a_series(double access_ns, double levels, bool by_bricks);

std::vector<volumes::Coordinate> uniform_points(const volumes::Extent& extent, std::uint64_t seed,
                                                std::uint64_t count);
std::vector<volumes::Coordinate> clustered_points(const volumes::Extent& extent, std::uint64_t seed,
                                                  std::uint64_t count);
/// Scans the volume once.
std::vector<volumes::Coordinate> one_label_points(const volumes::VolumeSource& source,
                                                  std::uint64_t seed, std::uint64_t count);

/// The labels of the points (of scalars the bits, as VoxelAccess has them), in their order; reads
/// each plane that has points once.
std::vector<std::uint64_t> labels_at(const volumes::VolumeSource& source,
                                     const std::vector<volumes::Coordinate>& points);

}  // namespace cvr::experiments
