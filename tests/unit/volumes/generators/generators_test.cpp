// What every generator promises: the same bytes for any box and any number of threads, golden
// hashes, sizes down to one voxel, and clear refusals. The shapes of the single kinds are tested in
// shapes_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <xxhash.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/generators/generator.hpp"
#include "volumes/generators/random.hpp"

namespace cvr::volumes {
namespace {

struct Case {
  std::string kind;
  std::map<std::string, double> parameters;
  std::uint64_t golden;  ///< XXH3-64 of the voxels of 150 x 70 x 77, seed 1
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.kind;
  for (const auto& [name, value] : c.parameters) *out << " " << name << "=" << value;
}

/// Crosses tile borders on every axis and is no multiple of anything.
constexpr Extent kExtent{150, 70, 77};

Volume generate(const Case& c, const Extent& extent, std::uint64_t seed = 1, unsigned threads = 2) {
  return read_all(*make_generator(c.kind, extent, seed, c.parameters, threads));
}

std::string bytes_of(const Volume& volume) {
  return {reinterpret_cast<const char*>(volume.data()), volume.info().bytes()};
}

class Generators : public testing::TestWithParam<Case> {};

TEST_P(Generators, AnyBoxEqualsTheCropOfTheWhole) {
  const auto source = make_generator(GetParam().kind, kExtent, 1, GetParam().parameters, 2);
  const Volume whole = read_all(*source);
  const std::size_t voxel = size_of(whole.info().type);
  RandomSequence random(42);
  for (int round = 0; round < 24; ++round) {
    const auto cut = [&](std::uint64_t extent, std::uint64_t& origin, std::uint64_t& size) {
      origin = random.next() % extent;
      size = 1 + random.next() % (extent - origin);
    };
    Box box;
    cut(kExtent.x, box.origin.x, box.size.x);
    cut(kExtent.y, box.origin.y, box.size.y);
    cut(kExtent.z, box.origin.z, box.size.z);
    if (round % 4 == 0) box.size = {1, 1, 1};
    std::vector<std::byte> part(box.size.voxels() * voxel), crop(part.size());
    source->read(box, part.data());
    MemorySource(whole).read(box, crop.data());
    ASSERT_EQ(std::memcmp(part.data(), crop.data(), part.size()), 0)
        << "box at " << box.origin.x << " " << box.origin.y << " " << box.origin.z << " of "
        << to_string(box.size);
  }
}

TEST_P(Generators, AnyNumberOfThreadsGivesTheSameBytes) {
  const std::string one = bytes_of(generate(GetParam(), kExtent, 1, 1));
  for (const unsigned threads : {0u, 2u, 5u}) {
    EXPECT_TRUE(one == bytes_of(generate(GetParam(), kExtent, 1, threads)))
        << threads << " threads";
  }
}

TEST_P(Generators, BytesAreThoseOfEveryMachine) {
  const Volume volume = generate(GetParam(), kExtent);
  EXPECT_EQ(XXH3_64bits(volume.data(), volume.info().bytes()), GetParam().golden);
}

TEST_P(Generators, SmallAndThinVolumes) {
  for (const Extent extent :
       {Extent{1, 1, 1}, Extent{3, 5, 7}, Extent{1, 200, 1}, Extent{2, 1, 130}}) {
    const Volume volume = generate(GetParam(), extent);
    EXPECT_EQ(volume.extent(), extent);
    EXPECT_TRUE(bytes_of(volume) == bytes_of(generate(GetParam(), extent, 1, 1)))
        << to_string(extent);
  }
}

// clang-format off
INSTANTIATE_TEST_SUITE_P(All, Generators,
    testing::Values(
        Case{"cells", {}, 0x75C4D0FB048EA98Fu},
        Case{"cells", {{"sweeps", 0}, {"scatter", 0}, {"warp", 0}}, 0x374D5D954BCA98A9u},
        Case{"fibers", {}, 0x6940334B47ACF5FDu},
        Case{"fibers", {{"density", 60}, {"attempts", 2}}, 0x63B0D49B30A66062u},
        Case{"neurites", {}, 0xAF2D39DCC71652EBu},
        Case{"neurites", {{"calibre", 12}, {"slip", 3}}, 0x6D07D89BAEF6AFF3u},
        Case{"atlas", {}, 0xE6CA27188188B53Cu},
        Case{"worst-case", {}, 0x2CB5E07E1E7480AEu},
        Case{"worst-case", {{"pattern", 1}}, 0xB41AD9CB6FECA383u},
        Case{"worst-case", {{"pattern", 2}, {"bits", 64}}, 0x060251F9227F4806u},
        Case{"worst-case", {{"pattern", 3}, {"bits", 16}}, 0x035ED1DBE5CCC757u},
        Case{"worst-case", {{"pattern", 4}, {"bits", 8}}, 0xA88074E2E0619FB5u},
        Case{"worst-case", {{"pattern", 5}}, 0xD952C545376EC251u},
        Case{"turbulence", {}, 0xCB469E871708CAB8u},
        Case{"turbulence", {{"bits", 32}, {"slope", 3}, {"smallest", 4}}, 0xD330984195014BC4u},
        Case{"shells", {}, 0x17FFDEE4BC98CD1Eu},
        Case{"shells", {{"bits", 16}, {"shells", 2}, {"noise", 0}}, 0x68058353A4E37C78u},
        Case{"marschner-lobb", {}, 0x05BE09EE3EF11511u},
        Case{"marschner-lobb", {{"bits", 32}, {"frequency", 11}}, 0xDC1807D234DE819Du},
        Case{"moving", {}, 0x790043BF796AFD47u},
        Case{"moving", {{"bits", 16}, {"time", 12.5}}, 0x8E848D482BF01A52u}));
// clang-format on

TEST(GeneratorTable, DescribesEveryKind) {
  std::vector<std::string> kinds;
  for (const GeneratorInfo& info : all_generators()) {
    kinds.emplace_back(info.kind);
    EXPECT_FALSE(info.summary.empty());
    EXPECT_NE(info.default_extent.x, info.default_extent.y);
    EXPECT_NE(info.default_extent.y, info.default_extent.z);
    for (const GeneratorParameter& p : info.parameters) {
      EXPECT_LE(p.minimum, p.default_value) << info.kind << " " << p.name;
      EXPECT_GE(p.maximum, p.default_value) << info.kind << " " << p.name;
      EXPECT_FALSE(p.description.empty()) << info.kind << " " << p.name;
      for (const double value : {p.minimum, p.maximum}) {
        // Every value within the declared range is accepted, alone, at the smallest extent.
        EXPECT_NO_THROW(
            read_all(*make_generator(info.kind, {2, 3, 4}, 1, {{std::string(p.name), value}}, 1)))
            << info.kind << " " << p.name << "=" << value;
      }
    }
  }
  EXPECT_THAT(kinds, testing::ElementsAre("cells", "fibers", "neurites", "atlas", "worst-case",
                                          "turbulence", "shells", "marschner-lobb", "moving"));
}

TEST(GeneratorTable, SeedsAndExtentsMatter) {
  for (const char* kind :
       {"cells", "fibers", "neurites", "atlas", "turbulence", "shells", "moving"}) {
    const Extent extent{96, 80, 64};
    const Volume first = generate({kind, {}, 0}, extent, 1),
                 second = generate({kind, {}, 0}, extent, 2);
    EXPECT_FALSE(bytes_of(first) == bytes_of(second)) << kind;
  }
}

/// A reader that exchanges axes must be found out by any of these volumes.
TEST(GeneratorTable, FieldsChangeUnderExchangedAxes) {
  for (const Case& c : {Case{"cells", {}, 0}, Case{"fibers", {{"density", 40}}, 0},
                        Case{"neurites", {{"calibre", 16}}, 0}, Case{"atlas", {}, 0},
                        Case{"worst-case", {{"pattern", 1}}, 0}, Case{"turbulence", {}, 0},
                        Case{"shells", {}, 0}, Case{"moving", {}, 0}}) {
    const Extent extent{60, 60, 60};
    const Volume volume = generate(c, extent);
    std::uint64_t xz = 0, xy = 0, yz = 0;
    for (std::uint64_t z = 0; z < extent.z; ++z) {
      for (std::uint64_t y = 0; y < extent.y; ++y) {
        for (std::uint64_t x = 0; x < extent.x; ++x) {
          const std::uint64_t own = volume.label({x, y, z});
          xz += own != volume.label({z, y, x}) ? 1 : 0;
          xy += own != volume.label({y, x, z}) ? 1 : 0;
          yz += own != volume.label({x, z, y}) ? 1 : 0;
        }
      }
    }
    EXPECT_GT(xz, extent.voxels() / 50) << c.kind;
    EXPECT_GT(xy, extent.voxels() / 50) << c.kind;
    EXPECT_GT(yz, extent.voxels() / 50) << c.kind;
  }
}

std::string refusal(std::string_view kind, const Extent& extent,
                    const std::map<std::string, double>& parameters) {
  try {
    make_generator(kind, extent, 1, parameters, 1);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(GeneratorTable, RefusalsNameWhatIsAllowed) {
  constexpr Extent kSmall{4, 5, 6};
  EXPECT_THAT(refusal("cell", kSmall, {}),
              testing::HasSubstr(
                  "expected one of cells, fibers, neurites, atlas, worst-case, turbulence, shells, "
                  "marschner-lobb, moving, found cell"));
  EXPECT_THAT(refusal("cells", kSmall, {{"volumes", 3}}),
              testing::HasSubstr("expected one of volume, jitter"));
  EXPECT_THAT(refusal("cells", kSmall, {{"volume", 1}}),
              testing::HasSubstr("volume: expected a number from 8 to"));
  EXPECT_THAT(refusal("cells", kSmall, {{"sweeps", 1.5}}),
              testing::HasSubstr("sweeps: expected a whole number from 0 to 32, found 1.5"));
  EXPECT_THAT(refusal("cells", kSmall, {{"heat", std::numeric_limits<double>::quiet_NaN()}}),
              testing::HasSubstr("found nan"));
  EXPECT_THAT(refusal("worst-case", kSmall, {{"pattern", 6}}),
              testing::HasSubstr("from 0 to 5, found 6"));
  EXPECT_THAT(refusal("worst-case", kSmall, {{"bits", 12}}),
              testing::HasSubstr("expected 8, 16, 32 or 64, found 12"));
  EXPECT_THAT(refusal("shells", kSmall, {{"bits", 12}}),
              testing::HasSubstr("generator shells: bits: expected 8, 16 or 32, found 12"));
  EXPECT_THAT(refusal("atlas", {4, 0, 6}, {}),
              testing::HasSubstr("expected 1 to 16777216 voxels per axis, found 4x0x6"));
  EXPECT_THAT(refusal("cells", {1u << 24, 1u << 24, 1u << 24}, {}),
              testing::HasSubstr("fewer than 2^32 cells"));
  EXPECT_THAT(refusal("fibers", {1u << 24, 1u << 24, 1u << 24}, {}), testing::HasSubstr("at most"));
}

}  // namespace
}  // namespace cvr::volumes
