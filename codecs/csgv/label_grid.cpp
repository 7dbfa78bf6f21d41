#include "codecs/csgv/label_grid.hpp"

#include <algorithm>
#include <bit>

#include "codecs/csgv/lanes.hpp"
#include "shaders/shared/shared.hpp"

namespace cvr::codecs::csgv {

using shaders::cvr_morton_gather;
using shaders::cvr_morton_spread;

namespace {

/// The most frequent label of the lanes in `valid`, the first on a tie. `agree` tells whether all
/// valid lanes are equal.
std::uint32_t vote(Lanes lanes, const std::uint32_t* labels, unsigned valid, bool& agree) {
  const unsigned first = static_cast<unsigned>(std::countr_zero(valid));
  const unsigned same = lanes.equal(Lanes::broadcast(labels[first])) & valid;
  agree = same == valid;
  std::uint32_t winner = labels[first];
  int votes = std::popcount(same);
  // As long as the labels not yet counted could still win.
  for (unsigned rest = valid & ~same; std::popcount(rest) > votes;) {
    const std::uint32_t label = labels[std::countr_zero(rest)];
    const unsigned mask = lanes.equal(Lanes::broadcast(label)) & rest;
    if (std::popcount(mask) > votes) {
      votes = std::popcount(mask);
      winner = label;
    }
    rest &= ~mask;
  }
  return winner;
}

}  // namespace

Validity::Validity(std::uint32_t b, const BrickExtent& extent)
    : whole_(extent == BrickExtent{b, b, b}) {
  const unsigned levels = levels_of_brick(b);
  for (unsigned l = 0; l < levels; ++l) {
    const unsigned shift = levels - 1 - l;
    const auto nodes = [shift](std::uint32_t n) { return (n + (1u << shift) - 1) >> shift; };
    nodes_[l] = {nodes(extent.x), nodes(extent.y), nodes(extent.z)};
  }
}

unsigned Validity::children(unsigned level, std::uint32_t n) const {
  if (whole_) return 0xff;
  const BrickExtent& nodes = nodes_[level + 1];
  const auto axis = [](std::uint32_t child, std::uint32_t count, unsigned low, unsigned high) {
    return (child < count ? low : 0u) | (child + 1 < count ? high : 0u);
  };
  return axis(2 * cvr_morton_gather(n), nodes.x, 0x55, 0xaa) &
         axis(2 * cvr_morton_gather(n >> 1), nodes.y, 0x33, 0xcc) &
         axis(2 * cvr_morton_gather(n >> 2), nodes.z, 0x0f, 0xf0);
}

LabelGrid::LabelGrid(std::uint32_t b)
    : brick_(b),
      levels_(levels_of_brick(b)),
      labels_(offset(levels_)),
      constant_(offset(levels_ - 1)) {}

void LabelGrid::fill_constant(std::uint32_t label) {
  std::ranges::fill(labels_, label);
  std::fill(constant_.begin(), constant_.begin() + offset(levels_ - 2), std::uint8_t{0xff});
  std::fill(constant_.begin() + offset(levels_ - 2), constant_.end(), std::uint8_t{0});
  constant_root_ = true;
}

/// Gathers the finest level in Morton order. False if the whole brick has one label (and then
/// gathers nothing).
template <class T>
bool LabelGrid::gather_whole(const T* voxels, std::uint64_t row, std::uint64_t plane) {
  const T first = voxels[0];
  const auto uniform = [&] {
    for (std::uint32_t z = 0; z < brick_; ++z) {
      for (std::uint32_t y = 0; y < brick_; ++y) {
        const T* at = voxels + y * row + z * plane;
        T differing = 0;
        for (std::uint32_t x = 0; x < brick_; ++x) differing |= static_cast<T>(at[x] ^ first);
        if (differing != 0) return false;
      }
    }
    return true;
  };
  if (uniform()) return false;
  std::uint32_t* finest = labels(levels_ - 1);
  const std::uint32_t half = brick_ / 2;
  for (std::uint32_t z = 0; z < half; ++z) {
    for (std::uint32_t y = 0; y < half; ++y) {
      const std::uint32_t yz = cvr_morton_spread(y) << 1 | cvr_morton_spread(z) << 2;
      const T* row0 = voxels + 2 * y * row + 2 * z * plane;
      const T* row1 = row0 + row;
      const T* row2 = row0 + plane;
      const T* row3 = row2 + row;
      std::uint32_t x_code = 0;
      for (std::uint32_t x = 0; x < brick_; x += 2) {
        std::uint32_t* block = finest + 8 * (x_code | yz);
        block[0] = row0[x];
        block[1] = row0[x + 1];
        block[2] = row1[x];
        block[3] = row1[x + 1];
        block[4] = row2[x];
        block[5] = row2[x + 1];
        block[6] = row3[x];
        block[7] = row3[x + 1];
        x_code = ((x_code | ~CVR_MORTON_X) + 1) & CVR_MORTON_X;
      }
    }
  }
  return true;
}

template <class T>
void LabelGrid::gather_partial(const T* voxels, std::uint64_t row, std::uint64_t plane,
                               const Validity& validity) {
  const BrickExtent& extent = validity.nodes(levels_ - 1);
  std::uint32_t* finest = labels(levels_ - 1);
  std::fill_n(finest, nodes_of_level(levels_ - 1), 0u);
  for (std::uint32_t z = 0; z < extent.z; ++z) {
    for (std::uint32_t y = 0; y < extent.y; ++y) {
      const std::uint32_t yz = cvr_morton_spread(y) << 1 | cvr_morton_spread(z) << 2;
      const T* at = voxels + y * row + z * plane;
      for (std::uint32_t x = 0; x < extent.x; ++x) finest[cvr_morton_spread(x) | yz] = at[x];
    }
  }
}

void LabelGrid::build_coarser(const Validity& validity) {
  std::fill_n(constant_.data() + offset(levels_ - 2), nodes_of_level(levels_ - 2), std::uint8_t{0});
  for (unsigned l = levels_ - 1; l-- > 0;) {
    std::uint32_t* parents = labels(l);
    const std::uint32_t* children = labels(l + 1);
    const std::uint8_t* constant_children = constant_.data() + offset(l);
    const bool second_finest = l + 2 == levels_;
    const auto build_node = [&](std::uint32_t n) {
      const unsigned valid = validity.children(l, n);
      if (valid == 0) {
        parents[n] = 0;
        return false;
      }
      bool agree = false;
      parents[n] = vote(Lanes::load(children + 8 * n), children + 8 * n, valid, agree);
      return agree && (second_finest || (constant_children[n] | (~valid & 0xff)) == 0xff);
    };
    if (l == 0) {
      constant_root_ = build_node(0);
      return;
    }
    std::uint8_t* masks = constant_.data() + offset(l - 1);
    for (std::uint32_t parent = 0; parent < nodes_of_level(l - 1); ++parent) {
      unsigned mask = 0;
      for (unsigned c = 0; c < 8; ++c) mask |= (build_node(8 * parent + c) ? 1u : 0u) << c;
      masks[parent] = static_cast<std::uint8_t>(mask);
    }
  }
}

template <class T>
void LabelGrid::build(const T* voxels, std::uint64_t row, std::uint64_t plane,
                      const Validity& validity) {
  if (!validity.whole()) {
    gather_partial(voxels, row, plane, validity);
  } else if (!gather_whole(voxels, row, plane)) {
    fill_constant(voxels[0]);
    return;
  }
  build_coarser(validity);
}

void LabelGrid::fill_outside(const Validity& validity) {
  if (validity.whole()) return;
  for (unsigned l = 0; l + 1 < levels_; ++l) {
    for (std::uint32_t n = 0; n < nodes_of_level(l); ++n) {
      const unsigned outside = ~validity.children(l, n) & 0xff;
      if (outside == 0) continue;
      for (unsigned c = 0; c < 8; ++c) {
        if ((outside >> c & 1) != 0) labels(l + 1)[8 * n + c] = labels(l)[n];
      }
      if (l + 2 < levels_) constant_[offset(l) + n] |= static_cast<std::uint8_t>(outside);
    }
  }
}

template <class T>
void LabelGrid::scatter(unsigned level, const BrickExtent& nodes, T* voxels, std::uint64_t row,
                        std::uint64_t plane) const {
  const std::uint32_t* source = labels(level);
  for (std::uint32_t z = 0; z < nodes.z; ++z) {
    for (std::uint32_t y = 0; y < nodes.y; ++y) {
      const std::uint32_t* line = source + (cvr_morton_spread(y) << 1 | cvr_morton_spread(z) << 2);
      T* out = voxels + y * row + z * plane;
      std::uint32_t x_code = 0;
      std::uint32_t x = 0;
      for (; x + 2 <= nodes.x; x += 2) {  // children 0 and 1 of a block lie side by side
        out[x] = static_cast<T>(line[x_code]);
        out[x + 1] = static_cast<T>(line[x_code + 1]);
        x_code = ((x_code | ~(CVR_MORTON_X - 1)) + 8) & (CVR_MORTON_X - 1);
      }
      if (x < nodes.x) out[x] = static_cast<T>(line[x_code]);
    }
  }
}

#define CVR_INSTANTIATE(T)                                                                         \
  template void LabelGrid::build(const T*, std::uint64_t, std::uint64_t, const Validity&);         \
  template void LabelGrid::scatter(unsigned, const BrickExtent&, T*, std::uint64_t, std::uint64_t) \
      const;
CVR_INSTANTIATE(std::uint8_t)
CVR_INSTANTIATE(std::uint16_t)
CVR_INSTANTIATE(std::uint32_t)
CVR_INSTANTIATE(std::uint64_t)
#undef CVR_INSTANTIATE

}  // namespace cvr::codecs::csgv
