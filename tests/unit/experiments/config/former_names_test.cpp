// Names that users type and that have changed: the former ones mean the same.
#include "experiments/config/former_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/config/scene_file.hpp"
#include "experiments/run/load_config.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {
namespace {

using testing::HasSubstr;

std::string config(const std::string& modes, const std::string& frames, const std::string& label,
                   const std::string& metric) {
  return "matrix:\n"
         "  - datasets: [{generator: cells, extent: [8, 8, 8], name: blob}]\n"
         "    codecs: [raw]\n"
         "    stages: [render]\n"
         "    scenes: [cells]\n"
         "    " +
         modes + ": [none, voxel]\n    " + frames +
         ": 2\n"
         "tables:\n"
         "  - {name: t, title: T, rows: [" +
         label + "], columns: [" + metric +
         "]}\n"
         "  - {name: p, title: P, rows: [codec], where: {" +
         label + ": none}, pivot: {columns: [" + label + "], metric: " + metric + "}}\n";
}

TEST(FormerNames, MeanTheSameInConfigurations) {
  const ScratchFolder folder;
  const auto load = [&](const std::string& text) {
    return load_config(folder.write("c.yaml", text), Catalogue(), {});
  };
  const Config now = load(config("access_modes", "warm_frames", "access_mode", "warm_ms"));
  const Config before = load(config("caches", "held_frames", "cache", "held_ms"));
  ASSERT_EQ(now.cells.size(), 2u);
  ASSERT_EQ(before.cells.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(before.cells[i].row_key(), now.cells[i].row_key());
  ASSERT_EQ(before.tables.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(before.tables[i].rows, now.tables[i].rows);
    EXPECT_EQ(before.tables[i].columns, now.tables[i].columns);
    EXPECT_EQ(before.tables[i].where, now.tables[i].where);
  }
}

TEST(FormerNames, StandNotBesideThoseOfToday) {
  const ScratchFolder folder;
  std::string both = config("access_modes", "warm_frames", "access_mode", "warm_ms");
  both.insert(both.find("    warm_frames"), "    caches: [none]\n");
  try {
    load_config(folder.write("c.yaml", both), Catalogue(), {});
    FAIL() << "no error";
  } catch (const volumes::InputError& error) {
    EXPECT_THAT(
        error.what(),
        HasSubstr("c.yaml:7:5: expected each key once, found 'caches' beside 'access_modes'"));
  }
}

TEST(FormerNames, AreKnownBothWays) {
  EXPECT_EQ(current_name("held_ms"), "warm_ms");
  EXPECT_EQ(current_name("warm_ms"), "warm_ms");
  EXPECT_EQ(current_name("rounds"), "rounds");
  EXPECT_EQ(former_name("fixed_view"), "held");
  EXPECT_EQ(former_name("rounds"), "");
}

}  // namespace
}  // namespace cvr::experiments
