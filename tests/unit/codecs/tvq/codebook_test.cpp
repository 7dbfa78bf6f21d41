// Code vectors: search, LBG, initialisation.
#include "codecs/tvq/codebook.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/samples/sample_volumes.hpp"

namespace cvr::codecs::tvq {
namespace {

struct Cloud {
  std::vector<float> values;
  Vectors vectors;

  /// Random vectors of small whole numbers, so that all distances are exact.
  Cloud(std::uint64_t count, unsigned dimensions, std::uint64_t seed, std::uint64_t range = 64)
      : values(count * dimensions) {
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] =
          static_cast<float>(samples::random_at(seed, i) % range) - static_cast<float>(range / 2);
    vectors = {values.data(), count, dimensions, dimensions};
  }
};

TEST(Search, FindsTheNearestAndOfEqualsTheFirst) {
  for (const unsigned d : {1u, 7u, 24u, 64u}) {
    const Cloud cloud(301, d, 11, 16), codes_cloud(77, d, 12, 16);
    CodeVectors book{d, codes_cloud.values};
    book.append(book[5]);  // a duplicate, which must never win
    std::vector<std::uint16_t> codes(cloud.vectors.count);
    find_nearest(book, cloud.vectors, codes, 2);
    for (std::uint64_t n = 0; n < cloud.vectors.count; ++n) {
      std::uint32_t best = 0;
      for (std::uint32_t k = 1; k < book.size(); ++k) {
        if (squared_distance(cloud.vectors[n], book[k], d) <
            squared_distance(cloud.vectors[n], book[best], d))
          best = k;
      }
      ASSERT_EQ(codes[n], best) << d << ' ' << n;
    }
  }
}

/// |c|^2 / 2 - x c cancels where vectors lie far from the origin and near each other: what is
/// chosen may lose as much as its rounding.
TEST(Search, LosesNoMoreThanRoundingAtNearTies) {
  constexpr unsigned kDimensions = 64;
  constexpr float kFar = 8;
  Cloud cloud(200, kDimensions, 31), codes_cloud(60, kDimensions, 32);
  for (float& value : cloud.values) value = kFar + value / 64;
  for (float& value : codes_cloud.values) value = kFar + value / 64;
  const CodeVectors book{kDimensions, codes_cloud.values};
  std::vector<std::uint16_t> codes(cloud.vectors.count);
  find_nearest(book, cloud.vectors, codes, 2);
  double lost = 0, first = 0;  // by the chosen code vector, and by any one
  for (std::uint64_t n = 0; n < cloud.vectors.count; ++n) {
    double best = squared_distance(cloud.vectors[n], book[0], kDimensions);
    for (std::uint32_t k = 1; k < book.size(); ++k)
      best = std::min(best, squared_distance(cloud.vectors[n], book[k], kDimensions));
    lost = std::max(lost, squared_distance(cloud.vectors[n], book[codes[n]], kDimensions) - best);
    first = std::max(first, squared_distance(cloud.vectors[n], book[0], kDimensions) - best);
  }
  EXPECT_GT(first, 20 * 1e-5 * 2 * kDimensions * kFar * kFar);
  EXPECT_LE(lost, 1e-5 * 2 * kDimensions * kFar * kFar);
}

TEST(Search, HandlesStridesAndSingleCodeVectors) {
  const Cloud cloud(50, 10, 13);
  const Vectors part{cloud.values.data() + 3, 50, 4, 10};
  std::vector<std::uint16_t> codes(50, 9);
  find_nearest({4, {1, 2, 3, 4}}, part, codes, 1);
  EXPECT_EQ(std::ranges::count(codes, 0), 50);
}

TEST(Lbg, DistortionNeverRises) {
  for (const auto how : {Initialisation::kSplit, Initialisation::kRandom, Initialisation::kScalar,
                         Initialisation::kPnn}) {
    const Cloud cloud(2000, 6, 17);
    CodeVectors book = initial_codebook(how, cloud.vectors, 40, 1);
    ASSERT_LE(book.size(), 40u);
    ASSERT_GT(book.size(), 20u);
    const std::vector<double> history =
        refine(book, cloud.vectors, {.iterations = 30, .tolerance = 0}, 2);
    ASSERT_GT(history.size(), 2u);
    EXPECT_TRUE(std::ranges::is_sorted(history, std::greater<>()));
    EXPECT_LT(history.back(), history.front());
  }
}

TEST(Lbg, LeavesNoCellEmpty) {
  const Cloud cloud(500, 3, 19, 1000);
  CodeVectors book{3, std::vector<float>(3 * 30, 1e6f)};  // all but one far from everything
  std::fill_n(book[0], 3, 0.0f);
  refine(book, cloud.vectors, {.iterations = 20}, 1);
  std::vector<std::uint16_t> codes(500);
  find_nearest(book, cloud.vectors, codes, 1);
  EXPECT_EQ(std::set(codes.begin(), codes.end()).size(), book.size());
  EXPECT_EQ(book.size(), 30u);
}

TEST(Lbg, ShrinksToTheDistinctVectors) {
  std::vector<float> values;
  for (unsigned n = 0; n < 100; ++n) values.insert(values.end(), {static_cast<float>(n % 3), 1.0f});
  const Vectors vectors{values.data(), 100, 2, 2};
  for (const auto how : {Initialisation::kSplit, Initialisation::kRandom, Initialisation::kPnn}) {
    CodeVectors book = initial_codebook(how, vectors, 16, 1);
    const std::vector<double> history = refine(book, vectors, {}, 1);
    EXPECT_EQ(book.size(), 3u);
    EXPECT_EQ(history.back(), 0.0);
  }
}

TEST(Lbg, KeepsWhatIsFixed) {
  const Cloud cloud(300, 4, 23);
  CodeVectors book{4, std::vector<float>(4 * 9, 0.0f)};
  for (unsigned i = 4; i < 36; ++i) book.values[i] = static_cast<float>(i);
  refine(book, cloud.vectors, {.iterations = 10, .fixed = 1}, 1);
  for (unsigned j = 0; j < 4; ++j) EXPECT_EQ(book[0][j], 0.0f);
}

TEST(Lbg, SameBitsForAnyThreads) {
  const Cloud cloud(5000, 24, 29);
  CodeVectors one = initial_codebook(Initialisation::kSplit, cloud.vectors, 100, 1), seven = one;
  const auto first = refine(one, cloud.vectors, {}, 1),
             second = refine(seven, cloud.vectors, {}, 7);
  EXPECT_EQ(one.values, seven.values);
  EXPECT_EQ(first, second);
}

TEST(SplitTree, SizesAreNestedAndLoseLess) {
  const Cloud cloud(3000, 5, 31);
  const SplitTree tree(cloud.vectors, 64);
  EXPECT_EQ(tree.leaves(), 64u);
  double last = 1e300;
  for (std::uint32_t size = 1; size <= 64; size *= 2) {
    const CodeVectors book = tree.codebook(size);
    EXPECT_EQ(book.size(), size);
    EXPECT_EQ(book.values, SplitTree(cloud.vectors, size).codebook(size).values);
    std::vector<std::uint16_t> codes(3000);
    find_nearest(book, cloud.vectors, codes, 1);
    const double distortion = total_distortion(book, cloud.vectors, codes, 1);
    EXPECT_LT(distortion, last);
    last = distortion;
  }
}

TEST(Pnn, MergesTheNearestFirst) {
  // Two pairs and a loner: three clusters are the pairs' centres and the loner.
  const std::vector<float> values{0, 1, 10, 12, 100};
  CodeVectors book = initial_codebook(Initialisation::kPnn, {values.data(), 5, 1, 1}, 3, 1);
  std::ranges::sort(book.values);
  EXPECT_EQ(book.values, (std::vector<float>{0.5f, 11.0f, 100.0f}));
}

}  // namespace
}  // namespace cvr::codecs::tvq
