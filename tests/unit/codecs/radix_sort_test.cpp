// Many numbers sorted by digits: spread evenly, where the highest digits tell them apart, and not.
#include "codecs/radix_sort.hpp"

#include <gtest/gtest.h>

#include <random>

namespace cvr::codecs {
namespace {

void expect_sorted(std::uint64_t (*number)(std::uint64_t random, std::uint64_t i)) {
  std::mt19937_64 random(1);
  std::vector<std::uint64_t> numbers(20000), spare;
  for (std::uint64_t i = 0; i < numbers.size(); ++i) numbers[i] = number(random(), i);
  std::vector<std::uint64_t> expected = numbers;
  std::ranges::sort(expected);
  radix_sort(numbers, spare);
  EXPECT_EQ(numbers, expected);
}

TEST(RadixSort, NumbersSpreadEvenly) {
  expect_sorted([](std::uint64_t random, std::uint64_t) { return random; });
}

TEST(RadixSort, AHighestDigitThatTellsOneFromAllOthers) {
  expect_sorted([](std::uint64_t random, std::uint64_t i) {
    return (random & 0xffffff) | std::uint64_t{i == 77} << 63;
  });
}

TEST(RadixSort, FewNumbersAtOneEndOfTheOthersThatAgreeInTheirHighestDigits) {
  expect_sorted([](std::uint64_t random, std::uint64_t i) {
    return i < 300 ? 300 - i : random | std::uint64_t{1} << 63;
  });
}

TEST(RadixSort, ManyOfTheSame) {
  expect_sorted([](std::uint64_t random, std::uint64_t) { return random & 0xff000000000000ffu; });
}

TEST(RadixSort, NumbersOfFewBits) {
  expect_sorted([](std::uint64_t random, std::uint64_t i) { return (random + i) & 0x1ff; });
}

}  // namespace
}  // namespace cvr::codecs
