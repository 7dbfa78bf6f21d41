// Encoders against volumes that were made to be slow: every lossless codec returns them exactly,
// and takes at most ten times as long as for ordinary cells. What comes nearest are volumes whose
// labels all differ and take 64 bits: each is sorted, and then looked up in a cache line of its own,
// where ordinary cells take csgv-nibble and csgvr-sb 3 ns per voxel. Other programs that fill the
// cache make that half as slow again, so times are judged on a machine that has nothing else to do.
//
// compresso-lzma has a bound of its own. It is compresso, which is held to the bound above by
// itself, and then liblzma, which takes 20 times as long where nothing repeats.
//
// Times are of the processor, by this thread alone, and the least of several repetitions.
#include <gtest/gtest.h>
#include <malloc.h>
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <stdexcept>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "tests/samples/sample_volumes.hpp"
#include "volumes/generators/generator.hpp"

namespace cvr::codecs {
namespace {

using volumes::Coordinate;

constexpr Extent kExtent{128, 64, 64};
constexpr double kSlowest = 10;
constexpr double kSlowestOfLiblzma = 30;
constexpr std::uint32_t kLargest = std::numeric_limits<std::uint32_t>::max();

VolumeInfo info_of(VoxelType type) {
  return {.extent = kExtent, .type = type, .kind = VolumeKind::kLabels, .voxel_unit = {}};
}

std::uint64_t index_of(const Coordinate& c) { return kExtent.index(c); }

/// The number whose product with an odd number is 1.
constexpr std::uint32_t inverse(std::uint32_t odd) {
  std::uint32_t x = odd;
  for (int i = 0; i < 5; ++i) x *= 2 - odd * x;
  return x;
}

struct Adversary {
  std::string name;
  VoxelType type;
  std::uint64_t (*label)(const Coordinate&);
};

/// A permutation of 32 bits.
std::uint32_t scramble(std::uint64_t i) {
  return static_cast<std::uint32_t>(i) * 0x85ebca6bu + 0x1234567u;
}

const std::vector<Adversary>& adversaries() {
  static const std::vector<Adversary> kAll{
      {"DistinctInOrder", VoxelType::kU32, [](const Coordinate& c) { return index_of(c); }},
      {"DistinctScrambled", VoxelType::kU32,
       [](const Coordinate& c) { return std::uint64_t{scramble(index_of(c))}; }},
      {"DistinctWide", VoxelType::kU64,
       [](const Coordinate& c) { return samples::random_at(3, index_of(c)); }},
      // Multiples of the sizes that hash tables of the standard library take: one bucket for all.
      {"DistinctMultiplesOfAPrime", VoxelType::kU64,
       [](const Coordinate& c) { return (index_of(c) + 1) * std::uint64_t{1447153} * 1048576; }},
      {"TwoExtremesCheckered", VoxelType::kU32,
       [](const Coordinate& c) {
         return (c.x + c.y + c.z) % 2 == 0 ? std::uint64_t{kLargest} : 0;
       }},
      {"TwoExtremesNoise", VoxelType::kU32,
       [](const Coordinate& c) {
         return samples::random_at(5, index_of(c)) % 2 == 0 ? std::uint64_t{kLargest} : 0;
       }},
      {"AllExtremesNoise", VoxelType::kU32,
       [](const Coordinate& c) { return kLargest - samples::random_at(7, index_of(c)) % 256; }},
      // Every label is the one of the neighbour below along x, then y, then z: references lead from
      // one corner to the other.
      {"Staircase", VoxelType::kU32,
       [](const Coordinate& c) { return c.x / 2 + c.y / 2 + c.z / 2; }},
      {"Planes", VoxelType::kU32, [](const Coordinate& c) { return c.z; }},
      // Labels come back as late as they can: distances in the palette are as long as they get.
      {"LongDistances", VoxelType::kU32,
       [](const Coordinate& c) { return std::uint64_t{scramble(index_of(c) % 30011)}; }},
      // Flat and degenerate counts of operations.
      {"FlatCounts", VoxelType::kU16,
       [](const Coordinate& c) { return samples::random_at(11, index_of(c)) % 3; }},
      {"OneVoxelDiffers", VoxelType::kU16,
       [](const Coordinate& c) { return std::uint64_t{index_of(c) == 12345}; }},
      {"NoiseOfBytes", VoxelType::kU8,
       [](const Coordinate& c) { return samples::random_at(13, index_of(c)) % 256; }},
      // Labels that multiplicative hashing brings together: products with 2^32 / phi that differ in
      // their high bits alone.
      {"HashesTogether", VoxelType::kU32,
       [](const Coordinate& c) {
         const auto i = static_cast<std::uint32_t>(index_of(c));
         const std::uint32_t high = (i & 0x1fff) << 19, low = i >> 13;
         const std::uint32_t mixed = high | (((high >> 15) ^ low) & 0x7ffff);
         return std::uint64_t{mixed * inverse(0x9e3779b1u)};
       }},
  };
  return kAll;
}

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// From now on freed memory stays with the process: the first touch of a page costs what the
/// kernel takes for it, on virtual machines more than all that an encoder does there.
void keep_memory() {
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

/// The least time of an encoding with one thread; ends early where it is below `enough`.
double encoding_seconds(const Codec& codec, const Volume& volume, const Parameters& parameters,
                        double enough, Encoded& encoded) {
  constexpr int kRepetitions = 9;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kRepetitions && least > enough; ++i) {
    const double start = cpu_seconds();
    auto result = encode(codec, volumes::MemorySource(volume), parameters, 1);
    least = std::min(least, cpu_seconds() - start);
    if (!result) throw std::runtime_error(result.error().message);
    encoded = std::move(*result);
  }
  return least;
}

/// Cells of the generator, in this type.
const Volume& ordinary(VoxelType type) {
  static std::map<VoxelType, Volume> made;
  if (!made.contains(type)) {
    const auto source = volumes::make_generator("cells", kExtent, 1, {}, 2);
    const Volume cells = volumes::read_all(*source);
    made.emplace(type, samples::make_labels(info_of(type),
                                            [&](const Coordinate& c) { return cells.label(c); }));
  }
  return made.at(type);
}

/// The defaults, and where bricks can be chosen the largest.
std::vector<Parameters> settings(const Codec& codec) {
  std::vector<Parameters> all{Parameters::parse(codec.parameters(), {}).value()};
  for (const ParameterSpec& spec : codec.parameters()) {
    if (spec.name == "brick")
      all.push_back(
          Parameters::parse(codec.parameters(), std::vector<std::string>{"brick=64"}).value());
  }
  return all;
}

class Adversaries : public testing::TestWithParam<std::string> {};

/// Times count by night alone (ctest -L slow), on a machine with nothing else to do: beside other
/// work they prove nothing.
TEST_P(Adversaries, AreExactAndBoundedInTime) {
  const Codec& codec = *find_codec(GetParam());
  const bool timed = std::getenv("CVRBENCH_SLOW") != nullptr;
  if (timed) keep_memory();
  const double slowest = GetParam() == "compresso-lzma" ? kSlowestOfLiblzma : kSlowest;
  for (const Parameters& parameters : settings(codec)) {
    std::map<VoxelType, double> usual;
    for (const Adversary& adversary : adversaries()) {
      const VolumeInfo info = info_of(adversary.type);
      if (!accepts(codec.traits(), info)) continue;
      SCOPED_TRACE(adversary.name + " " + parameters.canonical());
      Encoded encoded;
      if (timed && !usual.contains(adversary.type))
        usual[adversary.type] =
            encoding_seconds(codec, ordinary(adversary.type), parameters, 0, encoded);
      const Volume volume = samples::make_labels(info, adversary.label);
      const double enough =
          timed ? slowest * usual[adversary.type] / 2 : std::numeric_limits<double>::max();
      const double seconds = encoding_seconds(codec, volume, parameters, enough, encoded);
      const double ratio = timed ? seconds / usual[adversary.type] : 0;
      EXPECT_LE(ratio, slowest);
      if (timed && std::getenv("CVR_PRINT_RATIOS") != nullptr)
        std::printf("%-14s %-40s %-26s %8.1f ms %6.2f\n", GetParam().c_str(),
                    parameters.canonical().c_str(), adversary.name.c_str(), 1e3 * seconds, ratio);
      const auto decoded = decode(encoded.bytes.bytes(), 0, 1);
      ASSERT_TRUE(decoded) << decoded.error().message;
      ASSERT_EQ(std::memcmp(decoded->data(), volume.data(), info.bytes()), 0);
    }
  }
}

std::vector<std::string> lossless_codecs() {
  std::vector<std::string> ids;
  for (const Codec* codec : all_codecs()) {
    if (codec->traits().lossless) ids.emplace_back(codec->traits().id);
  }
  return ids;
}

INSTANTIATE_TEST_SUITE_P(All, Adversaries, testing::ValuesIn(lossless_codecs()),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace cvr::codecs
