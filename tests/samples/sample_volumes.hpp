// Sample volumes: small ones that have broken codecs before, or would. Every test that walks the
// registry walks them too.
//
// Sides differ on all axes (so that exchanged axes show), no volume is drawn from the clock or from
// std:: distributions (so that every machine sees the same voxels), and each has a name that can
// stand in a test's name.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "codecs/codec.hpp"
#include "volumes/volume.hpp"

namespace cvr::samples {

struct SampleVolume {
  std::string name;                         ///< letters, digits and underscores
  volumes::VolumeInfo info;                 ///< known without making the voxels
  std::function<volumes::Volume()> volume;  ///< makes the voxels
  bool finite = true;                       ///< no voxel is NaN or infinite
};

/// All sample_volumes, labels and scalars.
const std::vector<SampleVolume>& sample_volumes();
/// The sample of that name; throws std::out_of_range.
const SampleVolume& sample(const std::string& name);
/// Whether the codec accepts the voxel type and kind of a volume.
bool accepts(const codecs::Codec& codec, const volumes::VolumeInfo& info);
/// The same, and its voxels: lossy codecs refuse those that are NaN or infinite.
bool accepts(const codecs::Codec& codec, const SampleVolume& sample);

/// The bits of a voxel of any type, as VoxelAccess hands them out.
std::uint64_t bits_at(const volumes::Volume& volume, const volumes::Coordinate& c);
/// The error of a decoded scalar volume, by its definition.
codecs::RecordedError error_of(const volumes::Volume& original, const volumes::Volume& decoded);
/// Whether a decoded volume keeps what its encoder recorded, to 1e-6 of the values.
bool keeps(const codecs::RecordedError& recorded, const volumes::Volume& original,
           const volumes::Volume& decoded);

/// Parameters that are worth a test of their own: the defaults; for every parameter alone each
/// choice, or its least, its largest and one inner value; all at their least and all at their
/// largest. Deterministic, no two alike.
std::vector<codecs::Parameters> parameter_corners(const codecs::Codec& codec);
/// Corners whose values are legal each but not together, whatever the volume (a window of more voxels
/// than its word has bits), and with which code they are refused. parameter_corners() lacks them.
std::vector<std::pair<codecs::Parameters, volumes::ErrorCode>> impossible_corners(
    const codecs::Codec& codec);
/// "csgv_nibble_brick_32_delta_0": a codec and its parameters as part of a test's name.
std::string test_name(const codecs::Codec& codec, const codecs::Parameters& parameters);

/// A stateless random number: splitmix64 of seed and index.
std::uint64_t random_at(std::uint64_t seed, std::uint64_t index);

/// Volumes of labels where label(coordinate) gives the voxels. The type narrows the labels.
volumes::Volume make_labels(const volumes::VolumeInfo& info,
                            const std::function<std::uint64_t(const volumes::Coordinate&)>& label);

/// Cells around `seeds` random points, labels 1..seeds: the shape of segmented data.
std::function<std::uint64_t(const volumes::Coordinate&)> voronoi(const volumes::Extent& extent,
                                                                 unsigned seeds,
                                                                 std::uint64_t seed);

/// The label pyramid by its definition: per level and 2x2x2 block the most frequent label, on a tie
/// the first in the order x fastest, y, z. What lies outside the volume has no vote. `volume` is
/// level 0 of the result's level `lod`.
volumes::Volume label_pyramid(const volumes::Volume& volume, unsigned lod);

/// A source that owns no voxels in one piece: every read is copied from `volume`, data() is
/// nullptr.
class StreamedSource final : public volumes::VolumeSource {
 public:
  explicit StreamedSource(const volumes::Volume& volume) : memory_(volume) {}
  const volumes::VolumeInfo& info() const override { return memory_.info(); }
  void read(const volumes::Box& box, std::byte* out) const override { memory_.read(box, out); }

 private:
  volumes::MemorySource memory_;
};

}  // namespace cvr::samples
