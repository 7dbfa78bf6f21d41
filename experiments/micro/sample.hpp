// The input of the micro-kernels: one brick of cells, deterministic, with about as many labels as
// segmented tissue has.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "codecs/codec.hpp"
#include "codecs/registry.hpp"
#include "volumes/source.hpp"

namespace cvr::micro {

inline std::uint64_t random_at(std::uint64_t index) {
  std::uint64_t v = (index + 1) * 0x9e3779b97f4a7c15u;
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
  return v ^ (v >> 31);
}

/// side^3 voxels of u32: the nearest of 40 random points, by squared distance.
inline volumes::Volume cells(std::uint32_t side) {
  volumes::Volume volume(
      {.extent = {side, side, side}, .type = volumes::VoxelType::kU32, .voxel_unit = {}});
  const auto voxels = volume.voxels<std::uint32_t>();
  constexpr std::uint32_t kPoints = 40;
  for (std::uint64_t i = 0; i < voxels.size(); ++i) {
    const std::int64_t at[3] = {static_cast<std::int64_t>(i % side),
                                static_cast<std::int64_t>(i / side % side),
                                static_cast<std::int64_t>(i / side / side)};
    std::int64_t least = INT64_MAX;
    for (std::uint32_t p = 0; p < kPoints; ++p) {
      std::int64_t distance = 0;
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const std::int64_t d = at[axis] - static_cast<std::int64_t>(random_at(3 * p + axis) % side);
        distance += d * d;
      }
      if (distance < least) {
        least = distance;
        voxels[i] = 1000 + p;
      }
    }
  }
  return volume;
}

/// The words of the only brick of cells(side), encoded with bricks of that side.
inline std::vector<std::uint32_t> encoded_brick(const char* codec_id, std::uint32_t side) {
  const codecs::Codec& codec = *codecs::find_codec(codec_id);
  const std::vector<std::string> assignments{"brick=" + std::to_string(side)};
  const volumes::Volume volume = cells(side);
  const auto parameters = codecs::Parameters::parse(codec.parameters(), assignments).value();
  const auto payload = codec.encode(volumes::MemorySource(volume), parameters, 1).value();
  constexpr std::size_t kBrickAt =
      16 + 2 * 4;  // no label table, no frequency tables, two brick starts
  std::vector<std::uint32_t> words((payload.bytes.size() - kBrickAt) / 4);
  std::memcpy(words.data(), payload.bytes.data() + kBrickAt, 4 * words.size());
  return words;
}

}  // namespace cvr::micro
