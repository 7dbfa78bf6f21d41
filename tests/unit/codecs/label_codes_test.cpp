// The distinct labels of a volume, whatever lengths of equal labels it is made of.
#include "codecs/label_codes.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

namespace cvr::codecs {
namespace {

template <class T>
class DistinctLabelsOf : public testing::Test {};
using Types = testing::Types<std::uint8_t, std::uint16_t, std::uint32_t, std::uint64_t>;
TYPED_TEST_SUITE(DistinctLabelsOf, Types);

TYPED_TEST(DistinctLabelsOf, AreAllFoundInRunsOfAnyLength) {
  std::mt19937_64 random(1);
  for (const std::size_t longest : {1, 3, 40, 1000}) {
    std::set<std::uint64_t> expected;
    DistinctLabels distinct(2);
    for (unsigned part = 0; part < 20; ++part) {
      std::vector<TypeParam> labels;
      const std::size_t size = 1 + random() % 5000;
      while (labels.size() < size) {
        const auto label =
            static_cast<TypeParam>(random() & (part % 2 == 0 ? 0x1fu : 0xff000000000000ffu));
        labels.insert(labels.end(), 1 + random() % longest, label);
        expected.insert(label);
      }
      distinct.add(part % 2, std::span<const TypeParam>(labels));
    }
    EXPECT_EQ(distinct.take(), std::vector<std::uint64_t>(expected.begin(), expected.end()))
        << "runs of up to " << longest;
    EXPECT_TRUE(distinct.take().empty());
  }
}

}  // namespace
}  // namespace cvr::codecs
