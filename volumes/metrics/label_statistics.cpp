#include "volumes/metrics/label_statistics.hpp"

#include <algorithm>

#include "volumes/label_hash.hpp"

namespace cvr::volumes {

namespace {

void include(LabelStatistics& entry, const Coordinate& first, const Coordinate& last,
             std::uint64_t voxels) {
  if (entry.voxels == 0) {
    entry.first = first;
    entry.last = last;
  } else {
    entry.first = {std::min(entry.first.x, first.x), std::min(entry.first.y, first.y),
                   std::min(entry.first.z, first.z)};
    entry.last = {std::max(entry.last.x, last.x), std::max(entry.last.y, last.y),
                  std::max(entry.last.z, last.z)};
  }
  entry.voxels += voxels;
}

}  // namespace

LabelStatistics& LabelCounter::entry(std::uint64_t label) {
  if (2 * used_ >= slots_.size()) grow();
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t at = hash_of(label) & mask;; at = (at + 1) & mask) {
    LabelStatistics& slot = slots_[at];
    if (slot.voxels == 0) {
      slot.label = label;
      ++used_;
      return slot;
    }
    if (slot.label == label) return slot;
  }
}

void LabelCounter::grow() {
  std::vector<LabelStatistics> former(2 * slots_.size());
  former.swap(slots_);
  const std::size_t mask = slots_.size() - 1;
  for (const LabelStatistics& one : former) {
    if (one.voxels == 0) continue;
    std::size_t at = hash_of(one.label) & mask;
    while (slots_[at].voxels != 0) at = (at + 1) & mask;
    slots_[at] = one;
  }
}

void LabelCounter::add_uniform(const Box& box, std::uint64_t label) {
  const Coordinate& o = box.origin;
  include(entry(label), o, {o.x + box.size.x - 1, o.y + box.size.y - 1, o.z + box.size.z - 1},
          box.size.voxels());
}

template <class T>
void LabelCounter::add_rows(const Box& box, const T* voxels) {
  const Coordinate& o = box.origin;
  for (std::uint64_t z = o.z; z < o.z + box.size.z; ++z) {
    for (std::uint64_t y = o.y; y < o.y + box.size.y; ++y) {
      for (std::uint64_t x = 0; x < box.size.x;) {
        const std::uint64_t begin = x;
        const T label = voxels[begin];
        do ++x;
        while (x < box.size.x && voxels[x] == label);
        include(entry(label), {o.x + begin, y, z}, {o.x + x - 1, y, z}, x - begin);
      }
      voxels += box.size.x;
    }
  }
}

void LabelCounter::add_voxels(const Box& box, const std::byte* voxels, VoxelType type) {
  with_label_type(type, [&]<class T>() { add_rows(box, reinterpret_cast<const T*>(voxels)); });
}

void LabelCounter::merge(const LabelCounter& other) {
  for (const LabelStatistics& one : other.slots_) {
    if (one.voxels > 0) include(entry(one.label), one.first, one.last, one.voxels);
  }
}

std::vector<LabelStatistics> LabelCounter::result() const {
  std::vector<LabelStatistics> all;
  for (const LabelStatistics& one : slots_) {
    if (one.voxels > 0) all.push_back(one);
  }
  std::ranges::sort(all, {}, &LabelStatistics::label);
  return all;
}

}  // namespace cvr::volumes
