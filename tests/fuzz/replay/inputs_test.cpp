// Every input of tests/corpus and tests/fuzz/found through its target, in every build: the found
// ones are regression tests of what libFuzzer found, the corpora reach most of what the decoders
// and readers can do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/fuzz/target.hpp"
#include "tests/fuzz/watch.hpp"

namespace cvr::fuzz {
namespace {

constexpr std::uintmax_t kLargestInput =
    6000;  ///< of the corpora; an HDF5 file with a chunk takes 4.9 KB
constexpr std::uintmax_t kLargestCorpora = 400 << 10;  ///< all together

const std::filesystem::path kCorpora = CVR_SOURCE_DIR "/tests/corpus";
/// One more folder of corpora, of a fuzzing run: scripts/fuzz --coverage.
std::filesystem::path more_corpora() {
  const char* more = std::getenv("CVRBENCH_CORPUS");
  return more == nullptr ? "" : more;
}
const std::filesystem::path kFound = CVR_SOURCE_DIR "/tests/fuzz/found";

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::is_directory(folder)) return files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

std::vector<std::byte> bytes_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> text{std::istreambuf_iterator<char>(in), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

class Inputs : public testing::TestWithParam<Target> {};

TEST_P(Inputs, AreAnswered) {
  GetParam().run({});  // what is made once and kept is no input's doing
  std::size_t inputs = 0;
  for (const auto& root : {kCorpora, kFound, more_corpora()}) {
    for (const auto& path : files_in(root / GetParam().name)) {
      SCOPED_TRACE(path.string());
      const std::vector<std::byte> bytes = bytes_of(path);
      watch(bytes.size(), [&] { GetParam().run(bytes); });
      ++inputs;
    }
  }
  EXPECT_GT(inputs, 0u) << "no inputs below tests/corpus/" << GetParam().name;
  watch(0, [&] { GetParam().run({}); });
}

INSTANTIATE_TEST_SUITE_P(Targets, Inputs, testing::ValuesIn(targets()), [](const auto& info) {
  std::string name = info.param.name;
  std::ranges::replace(name, '-', '_');
  return name;
});

TEST(Corpora, AreSmallAndBelongToTargets) {
  std::uintmax_t total = 0;
  for (const auto& path : files_in(kCorpora)) {
    EXPECT_LT(std::filesystem::file_size(path), kLargestInput) << path;
    total += std::filesystem::file_size(path);
  }
  EXPECT_LT(total, kLargestCorpora);
  for (const auto& root : {kCorpora, kFound}) {
    for (const auto& path : files_in(root)) {
      const std::string folder = path.parent_path().filename().string();
      const std::string target = folder.substr(0, folder.find('-')) + ".cpp";
      EXPECT_TRUE(std::filesystem::exists(CVR_SOURCE_DIR "/tests/fuzz/targets/" + target))
          << path << " belongs to no target";
    }
  }
}

}  // namespace
}  // namespace cvr::fuzz
