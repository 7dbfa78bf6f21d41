// Files of lines that were cut, grow, or are none; the lock of a folder.
#include "experiments/results/json_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zstd.h>

#include "experiments/run/run_folder.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {
namespace {

using testing::HasSubstr;

std::vector<std::pair<std::size_t, std::string>> lines_of(const std::string& path,
                                                          std::uint64_t longest = kLongestLine) {
  std::vector<std::pair<std::size_t, std::string>> lines;
  for_each_line(
      path, [&](std::size_t number, std::string_view text) { lines.emplace_back(number, text); },
      longest);
  return lines;
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const volumes::InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(JsonLines, AreReadAcrossBlocksAndWithoutATornLastLine) {
  const ScratchFolder folder;
  const std::string large(700'000, 'x');
  const std::string path = folder.write("f", "a\n\n" + large + "\nb\ntorn");
  const auto lines = lines_of(path);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0], (std::pair<std::size_t, std::string>(1, "a")));
  EXPECT_EQ(lines[1].second, "");
  EXPECT_EQ(lines[2].second, large);
  EXPECT_EQ(lines[3], (std::pair<std::size_t, std::string>(4, "b")));
  EXPECT_TRUE(lines_of(folder / "none").empty());
}

std::string compressed(const std::string& text) {
  std::string packed(ZSTD_compressBound(text.size()), 0);
  packed.resize(ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 3));
  return packed;
}

/// Evidence is kept so. The text of several frames goes on; what is cut or none is told by name.
TEST(JsonLines, AreReadFromZstandardFrames) {
  const ScratchFolder folder;
  const std::string large(700'000, 'x');
  const std::string both = compressed("a\n" + large) + compressed("y\nb\ntorn");
  const auto lines = lines_of(folder.write("f.zst", both));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[1].second, large + "y");
  EXPECT_EQ(lines[2], (std::pair<std::size_t, std::string>(3, "b")));
  // Lines that fill the block exactly, so that a frame ends where the block does.
  const std::string exact(262'143, 'z');
  EXPECT_EQ(lines_of(folder.write("e.zst", compressed(exact + "\n"))).size(), 1u);
  EXPECT_THAT(error_of([&] { lines_of(folder.write("c.zst", both.substr(0, both.size() - 3))); }),
              HasSubstr("c.zst: expected a whole Zstandard frame, found the file's end"));
  EXPECT_THAT(error_of([&] { lines_of(folder.write("p.zst", "a\nb\n")); }),
              HasSubstr("p.zst: expected Zstandard frames, found: "));
  EXPECT_THAT(error_of([&] { lines_of(folder.write("n.zst", "")); }), HasSubstr("whole"));
}

TEST(JsonLines, EnormousLinesAreAnErrorWithTheirPlaceEvenWithoutAnEnd) {
  const ScratchFolder folder;
  const std::string large(1'000'000, 'x');
  EXPECT_THAT(error_of([&] { lines_of(folder.write("f", "a\n" + large + "\n"), 999'999); }),
              HasSubstr("f:2: expected lines of at most 999999 bytes"));
  EXPECT_THAT(error_of([&] { lines_of(folder.write("g", large), 999'999); }), HasSubstr("g:1: "));
  EXPECT_EQ(lines_of(folder.write("h", large + "\n"), 1'000'000).size(), 1u);
}

TEST(JsonLines, WhatIsNoFileIsAnErrorAndNeverHangs) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder / "d");
  ASSERT_EQ(mkfifo((folder / "p").c_str(), 0600), 0);
  EXPECT_THAT(error_of([&] { lines_of(folder / "d"); }),
              HasSubstr("d: expected a regular file, found a folder"));
  EXPECT_THAT(error_of([&] { lines_of(folder / "p"); }),
              HasSubstr("found a device, pipe or socket"));
  EXPECT_THROW(LineWriter(folder / "d"), volumes::OutputError);
  EXPECT_THROW(LineWriter(folder / "p"), volumes::OutputError);
}

TEST(JsonLines, AppendingCutsATornLastLineOffHoweverLong) {
  const ScratchFolder folder;
  const std::string path = folder.write("f", "a\n" + std::string(100'000, 'x'));
  LineWriter(path).append("b");
  EXPECT_EQ(text_of(path), "a\nb\n");
  LineWriter(folder.write("g", std::string(9000, 'x'))).append("c");
  EXPECT_EQ(text_of(folder / "g"), "c\n");
}

TEST(JsonLines, AFolderHasOneHolderOfItsLockInAnotherProcessToo) {
  const ScratchFolder folder;
  const auto first = RunLock::take(folder / "o");
  EXPECT_EQ(RunLock::take(folder / "o/../o"), first) << "one process shares it";
  EXPECT_THAT(error_of([&] { LockedFile(folder / "o/.lock"); }),
              HasSubstr("expected to be the only run that writes here, found another one"));
  EXPECT_THROW(RunLock::take(folder.write("file", "")), volumes::OutputError);
}

}  // namespace
}  // namespace cvr::experiments
