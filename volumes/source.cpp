#include "volumes/source.hpp"

#include <cstring>

namespace cvr::volumes {

void MemorySource::read(const Box& box, std::byte* out) const {
  const std::size_t voxel = size_of(info_.type);
  const std::size_t row = box.size.x * voxel;
  for (std::uint64_t z = 0; z < box.size.z; ++z) {
    for (std::uint64_t y = 0; y < box.size.y; ++y) {
      const Coordinate start{box.origin.x, box.origin.y + y, box.origin.z + z};
      std::memcpy(out, voxels_ + info_.extent.index(start) * voxel, row);
      out += row;
    }
  }
}

const std::byte* SlabReader::read(std::uint64_t z0, std::uint64_t z1) {
  const VolumeInfo& info = source_.info();
  const std::size_t plane = info.extent.x * info.extent.y * size_of(info.type);
  if (source_.data() != nullptr) return source_.data() + z0 * plane;
  buffer_.resize((z1 - z0) * plane);
  source_.read({{0, 0, z0}, {info.extent.x, info.extent.y, z1 - z0}}, buffer_.data());
  return buffer_.data();
}

Volume read_all(const VolumeSource& source) {
  Volume volume(source.info());
  source.read({{0, 0, 0}, source.info().extent}, volume.data());
  return volume;
}

std::byte* VolumeSink::begin(std::uint64_t z0, std::uint64_t) {
  return volume_.data() +
         z0 * volume_.extent().x * volume_.extent().y * size_of(volume_.info().type);
}

std::byte* CompareSink::begin(std::uint64_t z0, std::uint64_t z1) {
  const VolumeInfo& info = truth_.info();
  slab_.resize((z1 - z0) * info.extent.x * info.extent.y * size_of(info.type));
  return slab_.data();
}

void CompareSink::end(std::uint64_t z0, std::uint64_t z1) {
  const VolumeInfo& info = truth_.info();
  const std::byte* truth = reader_.read(z0, z1);
  compared_ += (z1 - z0) * info.extent.x * info.extent.y;
  if (std::memcmp(truth, slab_.data(), slab_.size()) == 0) return;
  const std::size_t voxel = size_of(info.type);
  for (std::size_t i = 0; i < slab_.size(); i += voxel) {
    mismatches_ += std::memcmp(truth + i, slab_.data() + i, voxel) != 0 ? 1 : 0;
  }
}

}  // namespace cvr::volumes
