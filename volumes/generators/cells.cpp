// cells: a dense packing of rough, compact cells, as a Cellular Potts Model leaves them (Graner, Glazier: Simulation of biological cell
// sorting using a two-dimensional extended Potts model, PRL 69, 1992). A stand-in for CELLS of the CSGV-R paper.
//
//  1. One cell a box of a jittered grid, so that volumes are even, as the volume constraint of the model makes them. A voxel belongs
//     to the nearest of the centres whose reach (a box around the centre) contains it, after a warp by value noise at two scales.
//  2. A few sweeps of Potts dynamics roughen and relax the borders: every voxel, at even odds, proposes to copy one of its six
//     neighbours; with c of its 26 neighbours like the copy and o like the own label the copy is taken with probability
//     min(1, heat^(o - c)), Metropolis' rule at temperature -1 / ln(heat). All voxels of a sweep are judged by the state before it: a
//     sweep then reaches one voxel far, a box needs a halo of as many voxels as there are sweeps, and the result does not depend on
//     any order. (The model itself updates one voxel at a time.)
//  3. Ids are 1 .. number of cells, scattered over the volume by a permutation; a cell that lost all its voxels leaves a gap.
//
// Beyond the volume there is nothing: 0 marks it and is never copied.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "volumes/error.hpp"
#include "volumes/generators/kinds.hpp"
#include "volumes/generators/noise.hpp"
#include "volumes/generators/random.hpp"

namespace cvr::volumes {

namespace {

constexpr std::array kParameters{
    GeneratorParameter{"volume", 937, 8, 1e6, "mean voxels of a cell"},
    GeneratorParameter{"jitter", 0.7, 0, 1, "how far a centre strays in its grid box; 0 gives a lattice"},
    GeneratorParameter{"warp", 2.0, 0, 8, "amplitude of the warp of the borders in voxels"},
    GeneratorParameter{"sweeps", 4, 0, 32, "sweeps of Potts dynamics; also the halo of a box", true},
    GeneratorParameter{"heat", 0.2, 0, 0.95, "probability of a change that costs one unlike neighbour"},
    GeneratorParameter{"scatter", 1, 0, 1, "1: ids scattered over the volume, 0: in scan order", true},
};

constexpr Extent kTile{128, 64, 64};
constexpr unsigned kStates = 9;  ///< costs 0 .. 8 may be paid; dearer changes never happen

/// Labels of a region with a border of one voxel around it.
struct Field {
  explicit Field(const Extent& size)
      : size(size), row(size.x + 2), plane(row * (size.y + 2)), labels(plane * (size.z + 2), 0) {}
  std::size_t at(std::uint64_t x, std::uint64_t y, std::uint64_t z) const {
    return (x + 1) + row * (y + 1) + plane * (z + 1);
  }
  Extent size;
  std::size_t row, plane;
  std::vector<std::uint32_t> labels;
};

/// The grid boxes along one axis: the width that comes closest to the wished one and divides the axis evenly.
struct Axis {
  Axis(std::uint64_t extent, double wished)
      : boxes(std::max<std::int64_t>(1, static_cast<std::int64_t>(static_cast<double>(extent) / wished + 0.5))),
        width(static_cast<double>(extent) / static_cast<double>(boxes)) {}
  std::int64_t boxes;
  double width;
};

/// The edge of a cube of the given volume, by Newton's method: libm's cbrt may differ between machines.
double cube_root(double volume) {
  double edge = volume < 1 ? 1 : volume;
  for (int i = 0; i < 100; ++i) edge = (2 * edge + volume / (edge * edge)) / 3;
  return edge;
}

class CellsSource final : public TiledSource {
 public:
  explicit CellsSource(const GeneratorRequest& request)
      : TiledSource(request, VoxelType::kU32, kTile),
        seed_(mix64(request.seed ^ 0xCE115)),
        axes_{Axis(request.extent.x, cube_root(request["volume"])), Axis(request.extent.y, cube_root(request["volume"])),
              Axis(request.extent.z, cube_root(request["volume"]))},
        jitter_(request["jitter"]),
        warp_(request["warp"]),
        sweeps_(static_cast<std::uint64_t>(request["sweeps"])),
        scatter_(request["scatter"] != 0),
        permutation_(cells(), mix64(seed_)) {
    if (cells() > std::numeric_limits<std::uint32_t>::max()) {
      throw InputError(fmt::format("generator cells: volume: expected fewer than 2^32 cells, found {}", cells()));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      coarse_.emplace_back(hash(seed_, 1, static_cast<std::int64_t>(axis)), 11);
      fine_.emplace_back(hash(seed_, 2, static_cast<std::int64_t>(axis)), 4);
    }
    double probability = 1;
    for (std::uint32_t& threshold : thresholds_) {
      probability *= request["heat"];
      threshold = static_cast<std::uint32_t>(probability * 65536.0);
    }
  }

 protected:
  void fill(const Box& box, std::uint32_t* labels) const override;

 private:
  std::uint64_t cells() const {
    return static_cast<std::uint64_t>(axes_[0].boxes) * static_cast<std::uint64_t>(axes_[1].boxes) *
           static_cast<std::uint64_t>(axes_[2].boxes);
  }
  void assign_plane(const Box& region, std::uint64_t z, Field& field, std::vector<float>& scratch) const;
  void sweep(const Box& region, std::uint64_t number, const Field& before, Field& after) const;

  std::uint64_t seed_;
  std::array<Axis, 3> axes_;
  double jitter_, warp_;
  std::uint64_t sweeps_;
  bool scatter_;
  Permutation permutation_;
  std::vector<ValueNoise> coarse_, fine_;
  std::array<std::uint32_t, kStates - 1> thresholds_;  ///< of 2^16: cost d is paid below thresholds_[d - 1]
};

/// Gives the voxels of one plane of the region to their centres.
void CellsSource::assign_plane(const Box& region, std::uint64_t z, Field& field, std::vector<float>& scratch) const {
  const std::size_t width = region.size.x, count = width * region.size.y;
  scratch.assign(4 * count, 0.0F);
  float *px = scratch.data(), *py = px + count, *pz = py + count, *best = pz + count;
  std::fill(best, best + count, std::numeric_limits<float>::max());
  const auto absolute_z = static_cast<std::int64_t>(region.origin.z + z);
  const auto x0 = static_cast<std::int64_t>(region.origin.x);
  for (std::uint64_t y = 0; y < region.size.y; ++y) {
    const auto absolute_y = static_cast<std::int64_t>(region.origin.y + y);
    const std::array<float*, 3> rows{px + y * width, py + y * width, pz + y * width};
    for (std::size_t i = 0; i < width; ++i) {
      rows[0][i] = static_cast<float>(region.origin.x + i);
      rows[1][i] = static_cast<float>(absolute_y);
      rows[2][i] = static_cast<float>(absolute_z);
    }
    if (warp_ == 0) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      coarse_[axis].add_row(x0, width, absolute_y, absolute_z, static_cast<float>(warp_), rows[axis]);
      fine_[axis].add_row(x0, width, absolute_y, absolute_z, static_cast<float>(0.5 * warp_), rows[axis]);
    }
  }
  // A centre reaches 1.25 box widths and the warp far; every voxel lies within reach of the centre of its own box.
  struct Range {
    std::int64_t first, last;
  };
  const auto boxes_near = [](const Axis& axis, double from, double to, double reach) {
    const auto box = [&](double position) {
      return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(position / axis.width)), 0, axis.boxes - 1);
    };
    return Range{box(from - reach), box(to + reach)};
  };
  const auto voxels_near = [](double centre, double reach, std::uint64_t origin, std::uint64_t size) {
    const double low = std::max(std::ceil(centre - reach) - static_cast<double>(origin), 0.0);
    const double high = std::min(std::floor(centre + reach) - static_cast<double>(origin), static_cast<double>(size) - 1);
    return Range{static_cast<std::int64_t>(low), static_cast<std::int64_t>(high)};
  };
  const double reach_x = 1.25 * axes_[0].width + 1.5 * warp_, reach_y = 1.25 * axes_[1].width + 1.5 * warp_,
               reach_z = 1.25 * axes_[2].width + 1.5 * warp_;
  const auto plane = static_cast<double>(absolute_z);
  const auto end = [](std::uint64_t origin, std::uint64_t size) { return static_cast<double>(origin + size - 1); };
  const auto o = region.origin;
  const Range bx = boxes_near(axes_[0], static_cast<double>(o.x), end(o.x, region.size.x), reach_x);
  const Range by = boxes_near(axes_[1], static_cast<double>(o.y), end(o.y, region.size.y), reach_y);
  const Range bz = boxes_near(axes_[2], plane, plane, reach_z);
  for (std::int64_t cz = bz.first; cz <= bz.last; ++cz) {
    for (std::int64_t cy = by.first; cy <= by.last; ++cy) {
      for (std::int64_t cx = bx.first; cx <= bx.last; ++cx) {
        RandomSequence random(hash(seed_, cx, cy, cz));
        const auto centre = [&](const Axis& axis, std::int64_t index) {
          return (static_cast<double>(index) + 0.5 + jitter_ * (random.unit() - 0.5)) * axis.width - 0.5;
        };
        const double x = centre(axes_[0], cx), y = centre(axes_[1], cy), zc = centre(axes_[2], cz);
        if (std::abs(zc - plane) > reach_z) continue;
        const std::uint64_t index = static_cast<std::uint64_t>(cx) + static_cast<std::uint64_t>(axes_[0].boxes) *
                                        (static_cast<std::uint64_t>(cy) +
                                         static_cast<std::uint64_t>(axes_[1].boxes) * static_cast<std::uint64_t>(cz));
        const auto label = static_cast<std::uint32_t>(1 + (scatter_ ? permutation_(index) : index));
        const auto fx = static_cast<float>(x), fy = static_cast<float>(y), fz = static_cast<float>(zc);
        const Range rx = voxels_near(x, reach_x, o.x, region.size.x), ry = voxels_near(y, reach_y, o.y, region.size.y);
        for (std::int64_t row = ry.first; row <= ry.last; ++row) {
          std::uint32_t* target = field.labels.data() + field.at(0, static_cast<std::uint64_t>(row), z);
          const std::size_t base = static_cast<std::size_t>(row) * width;
          for (std::int64_t i = rx.first; i <= rx.last; ++i) {
            const float dx = px[base + i] - fx, dy = py[base + i] - fy, dz = pz[base + i] - fz;
            const float distance = dx * dx + dy * dy + dz * dz;
            const bool nearer = distance < best[base + i];
            best[base + i] = nearer ? distance : best[base + i];
            target[i] = nearer ? label : target[i];
          }
        }
      }
    }
  }
}

void CellsSource::sweep(const Box& region, std::uint64_t number, const Field& before, Field& after) const {
  const auto row = static_cast<std::ptrdiff_t>(before.row), plane = static_cast<std::ptrdiff_t>(before.plane);
  const std::array<std::int32_t, 8> proposals{1, -1, static_cast<std::int32_t>(row), static_cast<std::int32_t>(-row),
                                              static_cast<std::int32_t>(plane), static_cast<std::int32_t>(-plane), 0, 0};
  std::array<std::ptrdiff_t, 26> around{};
  std::size_t n = 0;
  for (std::ptrdiff_t dz = -1; dz <= 1; ++dz) {
    for (std::ptrdiff_t dy = -1; dy <= 1; ++dy) {
      for (std::ptrdiff_t dx = -1; dx <= 1; ++dx) {
        if (dx != 0 || dy != 0 || dz != 0) around[n++] = dx + dy * row + dz * plane;
      }
    }
  }
  std::vector<std::uint32_t> proposed(region.size.x), random(region.size.x);
  std::vector<std::int32_t> cost(region.size.x);
  for (std::uint64_t z = 0; z < region.size.z; ++z) {
    for (std::uint64_t y = 0; y < region.size.y; ++y) {
      const std::uint32_t* own = before.labels.data() + before.at(0, y, z);
      std::uint32_t* out = after.labels.data() + after.at(0, y, z);
      const auto base = static_cast<std::uint32_t>(hash(seed_, static_cast<std::int64_t>(region.origin.y + y),
                                                        static_cast<std::int64_t>(region.origin.z + z),
                                                        static_cast<std::int64_t>(number)));
      const auto x0 = static_cast<std::uint32_t>(region.origin.x);
      for (std::uint32_t i = 0; i < region.size.x; ++i) {
        random[i] = mix32(base + (x0 + i) * 0x9E3779B9u);
        cost[i] = 0;
      }
      // The proposal takes three bits; 6 and 7 propose the own label, which with the odd bit above makes 3/8 of all voxels act.
      for (std::uint32_t i = 0; i < region.size.x; ++i) {
        const std::int32_t step = proposals[random[i] & 7u];
        const std::uint32_t copy = (random[i] & 8u) != 0 ? own[static_cast<std::ptrdiff_t>(i) + step] : own[i];
        proposed[i] = copy == 0 ? own[i] : copy;
      }
      for (const std::ptrdiff_t offset : around) {
        const std::uint32_t* other = own + offset;
        for (std::uint32_t i = 0; i < region.size.x; ++i) {
          cost[i] += static_cast<std::int32_t>(other[i] == own[i]) - static_cast<std::int32_t>(other[i] == proposed[i]);
        }
      }
      for (std::uint32_t i = 0; i < region.size.x; ++i) {
        std::int32_t paid = 0;
        for (const std::uint32_t threshold : thresholds_) paid += static_cast<std::int32_t>((random[i] >> 16) < threshold);
        out[i] = cost[i] <= paid ? proposed[i] : own[i];
      }
    }
  }
}

void CellsSource::fill(const Box& box, std::uint32_t* labels) const {
  const auto widen = [&](std::uint64_t origin, std::uint64_t size, std::uint64_t extent, std::uint64_t& from,
                         std::uint64_t& count) {
    from = origin - std::min(origin, sweeps_);
    count = std::min(origin + size + sweeps_, extent) - from;
  };
  Box region;
  widen(box.origin.x, box.size.x, info().extent.x, region.origin.x, region.size.x);
  widen(box.origin.y, box.size.y, info().extent.y, region.origin.y, region.size.y);
  widen(box.origin.z, box.size.z, info().extent.z, region.origin.z, region.size.z);
  Field field(region.size), next(region.size);
  std::vector<float> scratch;
  for (std::uint64_t z = 0; z < region.size.z; ++z) assign_plane(region, z, field, scratch);
  for (std::uint64_t number = 0; number < sweeps_; ++number) {
    sweep(region, number, field, next);
    std::swap(field.labels, next.labels);
  }
  for (std::uint64_t z = 0; z < box.size.z; ++z) {
    for (std::uint64_t y = 0; y < box.size.y; ++y, labels += box.size.x) {
      const std::uint32_t* from = field.labels.data() + field.at(box.origin.x - region.origin.x,
                                                                 box.origin.y - region.origin.y + y,
                                                                 box.origin.z - region.origin.z + z);
      std::copy(from, from + box.size.x, labels);
    }
  }
}

}  // namespace

constinit const GeneratorInfo kCellsInfo{
    .kind = "cells",
    .summary = "rough compact cells that fill the volume; stands in for CELLS",
    .volume_kind = VolumeKind::kLabels,
    .default_extent = {256, 240, 224},
    .paper_extent = {1000, 1000, 1000},
    .parameters = kParameters,
};

std::unique_ptr<VolumeSource> make_cells(const GeneratorRequest& request) {
  return std::make_unique<CellsSource>(request);
}

}  // namespace cvr::volumes
