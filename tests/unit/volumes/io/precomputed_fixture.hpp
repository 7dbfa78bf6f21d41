// A small precomputed volume made by hand, for the tests of reading and of writing.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/unit/volumes/io/io_fixture.hpp"

namespace cvr::volumes {

class Precomputed : public IoTest {
 protected:
  static nlohmann::json small_info() {
    return nlohmann::json::parse(
        R"({"type": "image", "data_type": "uint8", "num_channels": 1, "scales": [
      {"key": "8_8_40", "size": [3, 2, 3], "resolution": [8, 8, 40], "voxel_offset": [10, -4, 100],
       "chunk_sizes": [[2, 2, 2]], "encoding": "raw"},
      {"key": "16_16_40", "size": [2, 1, 2], "resolution": [16, 16, 40], "chunk_sizes": [[2, 2, 2]], "encoding": "raw"}]})");
  }

  /// A volume of 3 x 2 x 3 whose voxel (x, y, z) is 100 + x + 10 y + 20 z, in chunks of 2.
  std::string make_small() const {
    write_bytes("vol/info", small_info().dump());
    for (int z = 0; z < 3; z += 2) {
      for (int x = 0; x < 3; x += 2) {
        std::string bytes;
        for (int k = z; k < std::min(z + 2, 3); ++k) {
          for (int j = 0; j < 2; ++j) {
            for (int i = x; i < std::min(x + 2, 3); ++i)
              bytes += static_cast<char>(100 + i + 10 * j + 20 * k);
          }
        }
        write_bytes(fmt::format("vol/8_8_40/{}-{}_-4--2_{}-{}", 10 + x, 10 + std::min(x + 2, 3),
                                100 + z, 100 + std::min(z + 2, 3)),
                    bytes);
      }
    }
    return path("vol");
  }

  void expect_small(const VolumeSource& source) const {
    EXPECT_EQ(source.info().extent, (Extent{3, 2, 3}));
    const Volume volume = read_all(source);
    for (std::uint64_t z = 0; z < 3; ++z) {
      for (std::uint64_t y = 0; y < 2; ++y) {
        for (std::uint64_t x = 0; x < 3; ++x)
          EXPECT_EQ(volume.label({x, y, z}), 100 + x + 10 * y + 20 * z);
      }
    }
    expect_boxes(source, volume);
  }
};

}  // namespace cvr::volumes
