// Copies of raw voxels: believed for what they hold, made by one, whole or not there.
#include "experiments/run/raw_copies.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <vector>

#include "tests/samples/scratch_folder.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {
namespace {

namespace fs = std::filesystem;

class RawCopies : public testing::Test {
 protected:
  RawCopies() {
    dataset_.name = "d";
    dataset_.extent = dataset_.full_extent = {12, 10, 8};
    dataset_.generator = GeneratorChoice{"cells", 3, {}};
    location_ = locate(dataset_, places_);
  }
  std::string text(const std::string& path) const {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& file : fs::directory_iterator(folder_ / "cache"))
      names.push_back(file.path().filename().string());
    std::ranges::sort(names);
    return names;
  }

  ScratchFolder folder_;
  Places places_{"", folder_ / "cache"};
  Dataset dataset_;
  Location location_;
};

TEST_F(RawCopies, AreMadeOnceAndAnewWhereAnythingWasChanged) {
  const RawCopy first = materialise(location_, places_, 2);
  ASSERT_EQ(first.path, folder_ / "cache/" + location_.identity + ".raw");
  EXPECT_EQ(first.content_hash.size(), 16u);
  EXPECT_GT(first.labels, 0u);
  const std::string voxels = text(first.path), sidecar = text(first.path + ".yaml"),
                    record = text(first.path + ".hash");
  ASSERT_EQ(voxels.size(), location_.info.bytes());
  const auto time = fs::last_write_time(first.path);
  materialise(location_, places_, 2);
  EXPECT_EQ(fs::last_write_time(first.path), time) << "a sound copy is kept";
  const auto damage = [&](const std::string& path, const std::string& changed) {
    std::ofstream(path, std::ios::binary) << changed;
    const RawCopy again = materialise(location_, places_, 2);
    EXPECT_EQ(again.content_hash, first.content_hash);
    EXPECT_EQ(again.labels, first.labels);
    EXPECT_EQ(text(first.path), voxels);
    EXPECT_EQ(text(first.path + ".yaml"), sidecar);
    EXPECT_EQ(text(first.path + ".hash"), record);
  };
  for (std::size_t at : {std::size_t{0}, voxels.size() / 2, voxels.size() - 1}) {
    std::string changed = voxels;
    changed[at] ^= 1;
    damage(first.path, changed);
  }
  damage(first.path, voxels.substr(1));
  damage(first.path, voxels + "x");
  damage(first.path + ".yaml", sidecar + "# mine\n");
  for (std::size_t at = 0; at < record.size(); ++at) {
    std::string changed = record;
    changed[at] = changed[at] == '0' ? '1' : '0';
    damage(first.path + ".hash", changed);
  }
  damage(first.path + ".hash", "");
}

TEST_F(RawCopies, SeveralAtOnceGetTheSame) {
  std::vector<std::future<RawCopy>> copies;
  for (int i = 0; i < 8; ++i)
    copies.push_back(
        std::async(std::launch::async, [&] { return materialise(location_, places_, 1); }));
  const RawCopy expected = materialise(location_, places_, 1);
  for (auto& copy : copies) EXPECT_EQ(copy.get().content_hash, expected.content_hash);
  EXPECT_THAT(files(), testing::SizeIs(4u)) << "copy, sidecar, record, lock";
}

TEST_F(RawCopies, AnInterruptionLeavesNothingUnfinished) {
  EXPECT_THROW(materialise(location_, places_, 1, [] { return true; }), Interrupted);
  for (const std::string& name : files()) EXPECT_EQ(name, location_.identity + ".lock");
}

TEST_F(RawCopies, UnfinishedFilesOfKilledRunsAreRemovedAndNoOthers) {
  const std::string own = location_.identity + ".raw.part0",
                    other = "0123456789abcdef.raw.yaml.part3", foreign = "film.part1";
  for (const std::string& name : {own, other, foreign}) folder_.write("cache/" + name, "half");
  materialise(location_, places_, 1);
  EXPECT_FALSE(fs::exists(folder_ / "cache/" + own));
  EXPECT_FALSE(fs::exists(folder_ / "cache/" + other));
  EXPECT_TRUE(fs::exists(folder_ / "cache/" + foreign));
}

TEST_F(RawCopies, ACacheThatIsNoFolderIsAnErrorOfTheOutput) {
  folder_.write("cache", "a file");
  EXPECT_THROW(materialise(location_, places_, 1), volumes::OutputError);
}

}  // namespace
}  // namespace cvr::experiments
