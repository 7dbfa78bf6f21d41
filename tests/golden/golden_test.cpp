#include "tests/golden/golden.hpp"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

#include "codecs/registry.hpp"

namespace cvr::golden {
namespace {

using codecs::Codec;

struct Case {
  const Codec* codec;
  const GoldenVolume* volume;
  std::vector<std::string> assignments{};

  codecs::Parameters parameters() const { return golden_parameters(*codec, assignments); }
  std::string path() const { return golden_path(*codec, *volume, parameters()); }
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const Codec* codec : codecs::all_codecs()) {
    for (const GoldenVolume& volume : golden_volumes()) {
      if (samples::accepts(*codec, volume.sample)) cases.push_back({codec, &volume});
    }
    if (!knows_time(*codec)) continue;
    for (const char* books : {"books=step", "books=shared"})
      cases.push_back({codec, &golden_series(), {books}});
  }
  return cases;
}

/// The file's bytes; empty if there is none.
std::vector<char> read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::span<const std::byte> bytes_of(const std::vector<char>& file) {
  return std::as_bytes(std::span(file));
}

TEST(GoldenInput, VoxelsAreTheOnesThatTheFilesWereMadeOf) {
  std::vector<const GoldenVolume*> all{&golden_series()};
  for (const GoldenVolume& volume : golden_volumes()) all.push_back(&volume);
  for (const GoldenVolume* volume : all) {
    const volumes::Volume made = volume->sample.volume();
    EXPECT_EQ(XXH3_64bits(made.data(), made.info().bytes()), volume->hash) << volume->sample.name;
  }
}

class Golden : public testing::TestWithParam<Case> {};

TEST_P(Golden, EncodesToTheFile) {
  const auto& [codec, volume, assignments] = GetParam();
  const volumes::Volume made = volume->sample.volume();
  ASSERT_EQ(XXH3_64bits(made.data(), made.info().bytes()), volume->hash)
      << "the input itself has changed";
  const auto encoded =
      codecs::encode(*codec, volumes::MemorySource(made), GetParam().parameters(), 1);
  ASSERT_TRUE(encoded) << encoded.error().message;
  const std::string path = GetParam().path();
  if (std::getenv("CVRBENCH_WRITE_GOLDEN") != nullptr) {
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(encoded->bytes.data()),
              static_cast<std::streamsize>(encoded->bytes.size()));
    ASSERT_TRUE(out.good()) << path;
  }
  const std::vector<char> file = read_file(path);
  ASSERT_FALSE(file.empty()) << path << " is missing; CVRBENCH_WRITE_GOLDEN=1 writes it";
  EXPECT_LT(file.size(), 6000u);  // golden files stay small
  ASSERT_EQ(encoded->bytes.size(), file.size());
  EXPECT_EQ(std::memcmp(encoded->bytes.data(), file.data(), file.size()), 0);
}

TEST_P(Golden, FileDecodesToTheVolume) {
  const auto& [codec, volume, assignments] = GetParam();
  const volumes::Volume made = volume->sample.volume();
  const std::vector<char> file = read_file(GetParam().path());
  const auto opened = codecs::open_file(bytes_of(file));
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->codec, codec);
  const auto decoded = codecs::decode(bytes_of(file), 0, 1);
  ASSERT_TRUE(decoded) << decoded.error().message;
  ASSERT_EQ(decoded->extent(), made.extent());
  EXPECT_EQ(decoded->info().time_steps, made.info().time_steps);
  if (!codec->traits().lossless) {
    const auto recorded = codecs::open_decoder(*opened).value()->recorded_error();
    EXPECT_TRUE(recorded && samples::keeps(*recorded, made, *decoded));
    return;
  }
  EXPECT_EQ(std::memcmp(decoded->data(), made.data(), made.info().bytes()), 0);
}

INSTANTIATE_TEST_SUITE_P(Registry, Golden, testing::ValuesIn(all_cases()), [](const auto& info) {
  std::string name =
      samples::test_name(*info.param.codec, {}) + "_of_" + info.param.volume->sample.name;
  for (const std::string& assignment : info.param.assignments)
    name += '_' + assignment.substr(assignment.find('=') + 1);
  return name;
});

}  // namespace
}  // namespace cvr::golden
