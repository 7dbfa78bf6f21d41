// The voxel cache's table on the device, one ray after another, so that the order of all lookups
// and insertions is known: counters and pictures must be those that the table in C++ predicts, for
// cells that were searched to collide and for a table that overflows.
#include "tests/samples/cuckoo.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/gpu/drawing.hpp"

namespace cvr::gpu_tests {
namespace {

using samples::CuckooCell;

constexpr std::uint32_t kSide = 64, kBrick = 16;
constexpr std::uint32_t kMarker = 7, kFirstLabel = 100;
constexpr auto kLeastEntries = static_cast<std::uint32_t>(gpu::kLeastCacheBytes / 8);

/// All labels differ but for one marker a brick, at its corner, which makes rays look into all
/// bricks.
std::uint32_t label_at(const CuckooCell& cell) {
  if (cell.x % kBrick == 0 && cell.y % kBrick == 0 && cell.z % kBrick == 0) return kMarker;
  return kFirstLabel + cell.x + kSide * (cell.y + kSide * cell.z);
}

/// Cells on rays that meet no marker.
std::vector<CuckooCell> free_cells() {
  std::vector<CuckooCell> cells;
  for (std::uint32_t z = 0; z < kSide; ++z) {
    for (std::uint32_t y = 0; y < kSide; ++y) {
      if (y % kBrick == 0 && z % kBrick == 0) continue;
      for (std::uint32_t x = 0; x < kSide; ++x) cells.push_back({x, y, z, 0});
    }
  }
  return cells;
}

volumes::Volume labelled_volume() {
  volumes::Volume volume({.extent = {kSide, kSide, kSide}, .type = volumes::VoxelType::kU32});
  const auto labels = volume.voxels<std::uint32_t>();
  for (std::uint32_t i = 0; i < labels.size(); ++i)
    labels[i] = label_at({i % kSide, i / kSide % kSide, i / kSide / kSide, 0});
  return volume;
}

struct Counts {
  std::uint64_t hits = 0, misses = 0, ejections = 0, losses = 0, wrong = 0;
  bool operator==(const Counts&) const = default;
};
std::ostream& operator<<(std::ostream& out, const Counts& c) {
  return out << c.hits << " hits, " << c.misses << " misses, " << c.ejections << " ejections, "
             << c.losses << " losses, " << c.wrong << " wrong";
}

/// A picture of one pixel, whose ray passes the cells of a row along x in their order until it
/// meets a visible one; on the device and in the table in C++ at once.
class Row {
 public:
  Row(const std::string& codec, std::uint32_t entries, const std::vector<CuckooCell>& visible)
      : table_(entries) {
    const volumes::Volume volume = labelled_volume();
    const auto encoded = encode_for_gpu(volume, codec, {}, kBrick);
    gpu::Scene scene;
    scene.lod_bias = -32;  // the finest level everywhere
    scene.materials = {{.first = kMarker, .last = kMarker}};
    shown_.insert(kMarker);
    for (const CuckooCell& cell : visible) {
      scene.materials.push_back({.first = label_at(cell), .last = label_at(cell)});
      shown_.insert(label_at(cell));
    }
    const auto make = [&](const std::string& access, bool instrumented) {
      auto renderer = gpu::Renderer::make(device(), encoded->encoding, volume.info(),
                                          {.access = access,
                                           .cache_bytes = std::uint64_t{entries} * 8,
                                           .width = 1,
                                           .height = 1,
                                           .instrumented = instrumented})
                          .value();
      if (!renderer->set_scene(scene)) ADD_FAILURE();
      return renderer;
    };
    cached_ = make("voxel", true);
    direct_ = make("none", false);
    cached_->clear_counters();
  }

  /// Draws the row of a cell; returns the labels that the two renderers show.
  std::pair<std::uint64_t, std::uint64_t> draw(const CuckooCell& cell) {
    const auto centre = [](std::uint32_t at) { return (at + 0.5 - kSide / 2.0) / kSide; };
    const gpu::Camera camera{
        {-1, centre(cell.y), centre(cell.z)}, {0, centre(cell.y), centre(cell.z)}, {0, 1, 0}, 30};
    cached_->render(camera);
    direct_->render(camera);
    return {cached_->read_image().labels.at(0), direct_->read_image().labels.at(0)};
  }
  /// The same row in C++: the label that is seen.
  std::uint64_t predict(CuckooCell cell) {
    for (cell.x = 0; cell.x < kSide; ++cell.x) {
      const std::uint32_t own = label_at(cell);
      const auto found = table_.find(cell);
      ++(found ? predicted_.hits : predicted_.misses);
      if (!found) table_.insert(cell, own);
      if (found && *found != own) ++predicted_.wrong;
      if (shown_.contains(found.value_or(own))) return found.value_or(own);
    }
    return gpu::kNoLabel;
  }
  Counts predicted() const {
    Counts counts = predicted_;
    counts.ejections = table_.ejections();
    counts.losses = table_.losses();
    return counts;
  }
  Counts counted() const {
    const gpu::Counters counters = cached_->read_counters();
    const auto of = [&](const char* name) {
      return std::ranges::find(counters, name, &std::pair<std::string, std::uint64_t>::first)
          ->second;
    };
    return {of("cache_hits"), of("cache_misses"), of("cache_ejections"), of("cache_losses"),
            of("wrong_labels")};
  }

 private:
  std::unique_ptr<gpu::Renderer> cached_, direct_;
  samples::CuckooTable table_;
  std::set<std::uint32_t> shown_;
  Counts predicted_;
};

TEST(CuckooTable, CellsThatPushEachOtherAboutStayRight) {
  const auto found = samples::find_eviction(free_cells(), kLeastEntries);
  ASSERT_TRUE(found);
  const auto& [a, b, c, d] = *found;
  for (const std::string codec : {"raw", "csgvr-sb"}) {
    Row row(codec, kLeastEntries, {a, b, c, d});
    const struct {
      CuckooCell cell;
      std::uint64_t ejections, losses;
    } steps[] = {{a, 0, 0}, {b, 1, 0}, {c, 2, 0}, {a, 2, 0}, {d, 2, 1}, {a, 3, 1}, {c, 3, 1}};
    for (const auto& step : steps) {
      const std::uint64_t expected = row.predict(step.cell);
      ASSERT_EQ(expected, label_at(step.cell)) << "the ray does not reach the cell";
      const auto [cached, direct] = row.draw(step.cell);
      EXPECT_EQ(cached, expected);
      EXPECT_EQ(direct, expected);
      EXPECT_EQ(row.counted(), row.predicted());
      // The other cells of the rows are few in a table of a mebibyte; what the searched ones do is
      // known without the table.
      EXPECT_GE(row.counted().ejections, step.ejections);
      EXPECT_GE(row.counted().losses, step.losses);
    }
    EXPECT_GT(row.counted().hits, 0u);
    EXPECT_EQ(row.counted().wrong, 0u);
  }
}

TEST(CuckooTable, AWrongLabelByACollisionOfKeysIsCounted) {
  const auto found = samples::find_key_collision(free_cells(), kLeastEntries);
  ASSERT_TRUE(found);
  Row row("raw", found->size, {found->a});
  EXPECT_EQ(row.predict(found->a), label_at(found->a));
  const auto [first, truth] = row.draw(found->a);
  EXPECT_EQ(first, label_at(found->a));
  EXPECT_EQ(truth, label_at(found->a));
  EXPECT_EQ(row.counted().wrong, 0u);
  EXPECT_EQ(row.predict(found->b), label_at(found->a)) << "the table has b's key, with a's label";
  const auto [wrong, direct] = row.draw(found->b);
  EXPECT_EQ(wrong, label_at(found->a));
  EXPECT_EQ(direct, gpu::kNoLabel);
  EXPECT_EQ(row.counted(), row.predicted());
  EXPECT_EQ(row.counted().wrong, 1u);
}

TEST(CuckooTable, AnOverflowingTableDoesWhatTheOneInCppDoes) {
  // 3,200 rows of 64 cells into 131,079 entries, then some of them again.
  Row row("raw", kLeastEntries + 7, {});
  for (std::uint32_t z = 0; z < kSide; ++z) {
    for (std::uint32_t y = 0; y < 50; ++y) {
      const std::uint64_t expected = row.predict({0, y, z, 0});
      const auto [cached, direct] = row.draw({0, y, z, 0});
      ASSERT_EQ(cached, expected) << y << " " << z;
      ASSERT_EQ(direct, expected) << y << " " << z;
    }
  }
  for (std::uint32_t y = 0; y < 50; ++y) {
    row.predict({0, y, 11, 0});
    row.draw({0, y, 11, 0});
  }
  EXPECT_EQ(row.counted(), row.predicted());
  EXPECT_GT(row.counted().ejections, 10000u);
  EXPECT_GT(row.counted().losses, 1000u);
  EXPECT_GT(row.counted().hits, 1000u);
}

}  // namespace
}  // namespace cvr::gpu_tests
