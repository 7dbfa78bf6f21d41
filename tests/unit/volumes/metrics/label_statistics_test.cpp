// Voxels and bounding boxes of labels, in whatever parts they come.
#include "volumes/metrics/label_statistics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace cvr::volumes {
namespace {

using testing::ElementsAre;

TEST(LabelStatistics, OfAVolumeByHand) {
  // 3 x 2 x 2 voxels.
  const std::vector<std::uint16_t> voxels{7, 7, 0, 0, 7, 0, /* z = 1 */ 5, 5, 5, 0, 0, 7};
  LabelCounter counter;
  counter.add_voxels({{0, 0, 0}, {3, 2, 2}}, reinterpret_cast<const std::byte*>(voxels.data()),
                     VoxelType::kU16);
  EXPECT_THAT(counter.result(), ElementsAre(LabelStatistics{0, 5, {0, 0, 0}, {2, 1, 1}},
                                            LabelStatistics{5, 3, {0, 0, 1}, {2, 0, 1}},
                                            LabelStatistics{7, 4, {0, 0, 0}, {2, 1, 1}}));
}

TEST(LabelStatistics, PartsInAnyOrderGiveTheSame) {
  // Labels of 64 bits, more of them than the first table has slots, in boxes of 4^3 of which every
  // second has one label.
  const auto label_of = [](std::uint64_t x, std::uint64_t y, std::uint64_t z) {
    const bool uniform = (x / 4 + y / 4 + z / 4) % 2 == 0;
    return uniform ? ~std::uint64_t{0} - (x / 4) : (x + 16 * y + 256 * z) << 40;
  };
  std::map<std::uint64_t, LabelStatistics> expected;
  std::vector<LabelCounter> counters(3);
  std::size_t turn = 0;
  for (std::uint64_t bz = 4; bz-- > 0;) {
    for (std::uint64_t by = 0; by < 4; ++by) {
      for (std::uint64_t bx = 0; bx < 4; ++bx) {
        const Box box{{4 * bx, 4 * by, 4 * bz}, {4, 4, 4}};
        std::vector<std::uint64_t> voxels;
        for (std::uint64_t i = 0; i < 64; ++i) {
          const Coordinate at{4 * bx + i % 4, 4 * by + i / 4 % 4, 4 * bz + i / 16};
          const std::uint64_t label = label_of(at.x, at.y, at.z);
          voxels.push_back(label);
          auto [entry, fresh] = expected.try_emplace(label, LabelStatistics{label, 0, at, at});
          LabelStatistics& one = entry->second;
          ++one.voxels;
          one.first = {std::min(one.first.x, at.x), std::min(one.first.y, at.y),
                       std::min(one.first.z, at.z)};
          one.last = {std::max(one.last.x, at.x), std::max(one.last.y, at.y),
                      std::max(one.last.z, at.z)};
        }
        LabelCounter& counter = counters[turn++ % counters.size()];
        if ((bx + by + bz) % 2 == 0)
          counter.add_uniform(box, voxels.front());
        else
          counter.add_voxels(box, reinterpret_cast<const std::byte*>(voxels.data()),
                             VoxelType::kU64);
      }
    }
  }
  counters[2].merge(counters[0]);
  counters[2].merge(counters[1]);
  std::vector<LabelStatistics> all;
  for (const auto& [label, one] : expected) all.push_back(one);
  EXPECT_EQ(counters[2].result(), all);
}

}  // namespace
}  // namespace cvr::volumes
