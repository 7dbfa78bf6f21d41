#include "gpu/reference/label_bricks.hpp"

#include <algorithm>
#include <bit>

#include "volumes/parallel.hpp"
#include "volumes/pyramid.hpp"

namespace cvr::gpu {

namespace {

constexpr std::uint64_t kMaxDirect = std::uint64_t{1} << 26;

void keep_distinct(std::vector<std::uint64_t>& labels) {
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
}

/// The distinct labels of a box, ascending.
std::vector<std::uint64_t> labels_in(const volumes::Volume& volume, const volumes::Coordinate& from,
                                     const volumes::Coordinate& to) {
  std::vector<std::uint64_t> found;
  volumes::with_label_type(volume.info().type, [&]<class T>() {
    const auto voxels = volume.voxels<T>();
    for (std::uint64_t z = from.z; z < to.z; ++z) {
      for (std::uint64_t y = from.y; y < to.y; ++y) {
        const auto row = voxels.subspan(volume.extent().index({from.x, y, z}), to.x - from.x);
        for (std::size_t x = 0; x < row.size(); ++x) {
          if (x == 0 ? found.empty() || found.back() != row[0] : row[x] != row[x - 1])
            found.push_back(row[x]);
        }
      }
    }
  });
  keep_distinct(found);
  return found;
}

}  // namespace

LabelTable::LabelTable(std::vector<std::uint64_t> labels) : labels_(std::move(labels)) {
  if (labels_.empty()) return;
  if (labels_.back() < kMaxDirect) {
    direct_.resize(labels_.back() + 1);
    for (std::uint32_t i = 0; i < labels_.size(); ++i) direct_[labels_[i]] = i;
  } else {
    for (std::uint32_t i = 0; i < labels_.size(); ++i) hashed_.emplace(labels_[i], i);
  }
}

LabelBricks::LabelBricks(const volumes::Volume& finest, std::uint32_t brick, unsigned threads)
    : brick_(brick), grid_(volumes::ceil_div(finest.extent(), brick)) {
  const auto level_count = static_cast<unsigned>(std::bit_width(brick));
  coarser_.reserve(level_count);  // levels_ points into it
  levels_.push_back(&finest);
  for (unsigned level = 1; level < level_count; ++level) {
    coarser_.push_back(volumes::coarser_level(volumes::MemorySource(*levels_.back()), threads));
    levels_.push_back(&coarser_.back());
  }

  std::vector<std::vector<std::uint64_t>> by_brick(grid_.voxels());
  const volumes::Extent& extent = finest.extent();
  volumes::parallel_for(threads, by_brick.size(), [&](unsigned, std::uint64_t i) {
    const volumes::Coordinate from{i % grid_.x * brick, i / grid_.x % grid_.y * brick,
                                   i / (grid_.x * grid_.y) * brick};
    by_brick[i] = labels_in(finest, from,
                            {std::min(from.x + brick, extent.x), std::min(from.y + brick, extent.y),
                             std::min(from.z + brick, extent.z)});
  });
  std::vector<std::uint64_t> all;
  std::size_t compact = 0;
  for (const auto& labels : by_brick) {
    all.insert(all.end(), labels.begin(), labels.end());
    if (all.size() < 2 * compact + 65536) continue;
    keep_distinct(all);
    compact = all.size();
  }
  keep_distinct(all);
  table_ = LabelTable(std::move(all));
  palettes_.resize(by_brick.size());
  volumes::parallel_for(threads, by_brick.size(), [&](unsigned, std::uint64_t i) {
    for (const std::uint64_t label : by_brick[i]) palettes_[i].push_back(table_.number_of(label));
  });
}

}  // namespace cvr::gpu
