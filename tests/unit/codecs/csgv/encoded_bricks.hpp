// Bricks of an encoded volume beside their naive operations, for the tests of this folder.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "codecs/registry.hpp"
#include "tests/samples/sample_volumes.hpp"
#include "tests/unit/codecs/csgv/naive_csgv.hpp"

namespace cvr::naive {

/// The payload of an encoding, taken apart by hand (layout: codecs/csgv/FORMAT.md).
struct Bricks {
  volumes::Volume volume;
  int side = 0;
  volumes::Extent grid;
  codecs::Payload payload;
  std::vector<std::uint8_t> tables;
  std::vector<std::uint32_t> starts;
  std::vector<std::uint32_t> words;

  std::span<const std::uint32_t> brick(std::size_t i) const {
    return std::span(words).subspan(starts[i], starts[i + 1] - starts[i]);
  }
  Voxel voxel(std::size_t i) const {
    const auto s = static_cast<std::uint64_t>(side);
    const volumes::Coordinate origin{i % grid.x * s, i / grid.x % grid.y * s,
                                     i / (grid.x * grid.y) * s};
    return [this, origin](int x, int y, int z, std::uint32_t& label) {
      const volumes::Coordinate c{origin.x + static_cast<std::uint64_t>(x),
                                  origin.y + static_cast<std::uint64_t>(y),
                                  origin.z + static_cast<std::uint64_t>(z)};
      if (!volume.extent().contains(c)) return false;
      label = static_cast<std::uint32_t>(volume.label(c));
      return true;
    };
  }
};

/// Encodes a volume whose labels fit in 32 bits.
inline Bricks encode_bricks(volumes::Volume volume, std::string_view codec_id, int side,
                            std::vector<std::string> more = {}) {
  const codecs::Codec& codec = *codecs::find_codec(codec_id);
  more.push_back("brick=" + std::to_string(side));
  const auto parameters = codecs::Parameters::parse(codec.parameters(), more);
  Bricks bricks;
  bricks.side = side;
  bricks.grid = volumes::ceil_div(volume.extent(), static_cast<std::uint64_t>(side));
  bricks.payload = codec.encode(volumes::MemorySource(volume), *parameters, 1).value();
  bricks.volume = std::move(volume);
  const std::byte* at = bricks.payload.bytes.data();
  const std::byte* const end = at + bricks.payload.bytes.size();
  std::uint64_t remapped = 1;
  std::memcpy(&remapped, at, 8);
  EXPECT_EQ(remapped, 0u);
  std::uint32_t table_bytes = 0;
  std::memcpy(&table_bytes, at + 8, 4);
  at += 16;
  bricks.tables.resize(table_bytes);
  if (table_bytes > 0) std::memcpy(bricks.tables.data(), at, table_bytes);
  at += (table_bytes + 3) / 4 * 4;
  bricks.starts.resize(bricks.grid.voxels() + 1);
  std::memcpy(bricks.starts.data(), at, 4 * bricks.starts.size());
  at += 4 * bricks.starts.size();
  bricks.words.resize(static_cast<std::size_t>(end - at) / 4);
  if (!bricks.words.empty()) std::memcpy(bricks.words.data(), at, 4 * bricks.words.size());
  EXPECT_EQ(bricks.starts.front(), 0u);
  EXPECT_EQ(bricks.starts.back(), bricks.words.size());
  return bricks;
}

/// Specimens of labels that are stored without a remap table.
inline std::vector<std::string> stored_as_they_are() {
  std::vector<std::string> names;
  for (const samples::SampleVolume& sample : samples::sample_volumes()) {
    if (sample.info.kind == volumes::VolumeKind::kLabels &&
        sample.info.type != volumes::VoxelType::kU64) {
      names.push_back(sample.name);
    }
  }
  return names;
}

/// The naive operations of brick i.
inline Operations naive_operations(const Bricks& bricks, std::size_t i, const Options& options) {
  Grid grid = make_grid(bricks.side, bricks.voxel(i));
  if (options.keep_outside) fill_outside(grid);
  return make_operations(grid, options);
}

}  // namespace cvr::naive
