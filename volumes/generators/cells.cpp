// cells: a dense packing of rough, compact cells, as a Cellular Potts Model leaves them (Graner,
// Glazier: Simulation of biological cell sorting using a two-dimensional extended Potts model, PRL
// 69, 1992). A stand-in for CELLS of the CSGV-R paper.
//
//  1. One cell a box of a jittered grid, so that volumes are even, as the volume constraint of the
//     model makes them. A voxel
//     belongs to the nearest of the centres whose reach (a box around the centre) contains it,
//     after a warp by value noise at
//     two scales.
//  2. A few sweeps of Potts dynamics roughen and relax the borders: every voxel, at even odds,
//     proposes to copy one of its six
//     neighbours; with c of its 26 neighbours like the copy and o like the own label the copy is
//     taken with
//     probability min(1, heat^(o - c)), Metropolis' rule at temperature -1 / ln(heat). All voxels
//     of a sweep
//     are judged by the state before it: a sweep then reaches one voxel far, a box needs a halo of
//     as many
//     voxels as there are sweeps, and the result does not depend on any order. (The model itself
//     updates one
//     voxel at a time.)
//  3. Ids are 1 .. number of cells, scattered over the volume by a permutation; a cell that lost
//     all its voxels leaves a gap.
//
// Beyond the volume there is nothing: 0 marks it and is never copied.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/generators/kinds.hpp"
#include "volumes/generators/noise.hpp"
#include "volumes/generators/random.hpp"

namespace cvr::volumes {

namespace {

constexpr std::array kParameters{
    GeneratorParameter{"volume", 937, 8, 1e6, "mean voxels of a cell"},
    GeneratorParameter{"jitter", 0.7, 0, 1,
                       "how far a centre strays in its grid box; 0 gives a lattice"},
    GeneratorParameter{"warp", 1.6, 0, 8, "amplitude of the warp of the borders in voxels"},
    GeneratorParameter{"sweeps", 3, 0, 32, "sweeps of Potts dynamics; also the halo of a box",
                       true},
    GeneratorParameter{"heat", 0.2, 0, 0.95,
                       "probability of a change that costs one unlike neighbour"},
    GeneratorParameter{"scatter", 1, 0, 1, "1: ids scattered over the volume, 0: in scan order",
                       true},
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

/// The grid boxes along one axis: the width that comes closest to the wished one and divides the
/// axis evenly.
struct Axis {
  Axis(std::uint64_t extent, double wished)
      : boxes(std::max<std::int64_t>(
            1, static_cast<std::int64_t>(static_cast<double>(extent) / wished + 0.5))),
        width(static_cast<double>(extent) / static_cast<double>(boxes)) {}
  std::int64_t boxes;
  double width;
};

/// A cell before it is roughened: where it lies and which voxels it may claim, in voxels of the
/// region.
struct Centre {
  double z;
  float x, y;
  std::uint32_t label;
  std::uint64_t x0, x1, y0, y1;  ///< claims [x0, x1) x [y0, y1)
};

/// The warped positions of a plane's voxels and the smallest squared distance to a centre so far.
struct Plane {
  explicit Plane(std::size_t voxels) : x(voxels), y(voxels), z(voxels), best(voxels) {}
  std::vector<float> x, y, z, best;
};

/// The edge of a cube of the given volume, by Newton's method: libm's cbrt may differ between
/// machines.
double cube_root(double volume) {
  double edge = volume < 1 ? 1 : volume;
  for (int i = 0; i < 100; ++i) edge = (2 * edge + volume / (edge * edge)) / 3;
  return edge;
}

/// Adds to cost[i] the neighbours i - 1, i, i + 1 of one row that are like own[i] less those that
/// are like copy[i].
void count_row(const std::uint32_t* __restrict other, const std::uint32_t* __restrict own,
               const std::uint32_t* __restrict copy, std::size_t count,
               std::int32_t* __restrict cost) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t a = other[static_cast<std::ptrdiff_t>(i) - 1], b = other[i],
                        c = other[i + 1];
    const auto like = [&](std::uint32_t label) {
      return static_cast<std::int32_t>(a == label) + static_cast<std::int32_t>(b == label) +
             static_cast<std::int32_t>(c == label);
    };
    cost[i] += like(own[i]) - like(copy[i]);
  }
}

class CellsSource final : public TiledSource {
 public:
  explicit CellsSource(const GeneratorRequest& request)
      : TiledSource(request, VoxelType::kU32, kTile),
        seed_(mix64(request.seed ^ 0xCE115)),
        axes_{Axis(request.extent.x, cube_root(request["volume"])),
              Axis(request.extent.y, cube_root(request["volume"])),
              Axis(request.extent.z, cube_root(request["volume"]))},
        jitter_(request["jitter"]),
        warp_(request["warp"]),
        sweeps_(static_cast<std::uint64_t>(request["sweeps"])),
        scatter_(request["scatter"] != 0),
        permutation_(cells(), mix64(seed_)) {
    if (cells() > std::numeric_limits<std::uint32_t>::max()) {
      throw InputError(fmt::format(
          "generator cells: volume: expected fewer than 2^32 cells, found {}", cells()));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      reach_[axis] = axes_[axis].width + 1.5 * warp_;
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
  std::vector<Centre> centres_near(const Box& region) const;
  void warp_plane(const Box& region, std::uint64_t z, Plane& plane) const;
  void assign_plane(const Box& region, std::uint64_t z, const std::vector<Centre>& centres,
                    Plane& plane, Field& field) const;
  void sweep(const Box& region, std::uint64_t number, const Field& before, Field& after) const;

  std::uint64_t seed_;
  std::array<Axis, 3> axes_;
  double jitter_, warp_;
  std::array<double, 3> reach_;  ///< of a centre along x, y, z in voxels
  std::uint64_t sweeps_;
  bool scatter_;
  Permutation permutation_;
  std::vector<ValueNoise> coarse_, fine_;
  std::array<std::uint32_t, kStates - 1>
      thresholds_;  ///< of 2^16: cost d is paid below thresholds_[d - 1]
};

/// The centres that reach the region, in ascending order of their grid boxes: of two at the same
/// distance the first wins. A centre reaches one box width and the warp far, so that every voxel
/// lies within reach of the centre of its own box.
std::vector<Centre> CellsSource::centres_near(const Box& region) const {
  const std::array<std::uint64_t, 3> origin{region.origin.x, region.origin.y, region.origin.z};
  const std::array<std::uint64_t, 3> size{region.size.x, region.size.y, region.size.z};
  std::array<std::int64_t, 3> first, last;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto box = [&](double position) {
      return std::clamp<std::int64_t>(
          static_cast<std::int64_t>(std::floor(position / axes_[i].width)), 0, axes_[i].boxes - 1);
    };
    first[i] = box(static_cast<double>(origin[i]) - reach_[i]);
    last[i] = box(static_cast<double>(origin[i] + size[i]) + reach_[i]);
  }
  const auto claim = [&](std::size_t axis, double centre, std::uint64_t& from, std::uint64_t& to) {
    const auto o = static_cast<double>(origin[axis]), end = static_cast<double>(size[axis]);
    from = static_cast<std::uint64_t>(std::clamp(std::ceil(centre - reach_[axis]) - o, 0.0, end));
    to =
        static_cast<std::uint64_t>(std::clamp(std::floor(centre + reach_[axis]) - o + 1, 0.0, end));
  };
  std::vector<Centre> centres;
  for (std::int64_t bz = first[2]; bz <= last[2]; ++bz) {
    for (std::int64_t by = first[1]; by <= last[1]; ++by) {
      for (std::int64_t bx = first[0]; bx <= last[0]; ++bx) {
        RandomSequence random(hash(seed_, bx, by, bz));
        const auto place = [&](std::size_t axis, std::int64_t box) {
          return (static_cast<double>(box) + 0.5 + jitter_ * (random.unit() - 0.5)) *
                     axes_[axis].width -
                 0.5;
        };
        const double x = place(0, bx), y = place(1, by), z = place(2, bz);
        const std::int64_t index = bx + axes_[0].boxes * (by + axes_[1].boxes * bz);
        const auto id = static_cast<std::uint64_t>(index);
        Centre centre{z,
                      static_cast<float>(x),
                      static_cast<float>(y),
                      static_cast<std::uint32_t>(1 + (scatter_ ? permutation_(id) : id)),
                      0,
                      0,
                      0,
                      0};
        claim(0, x, centre.x0, centre.x1);
        claim(1, y, centre.y0, centre.y1);
        if (centre.x0 < centre.x1 && centre.y0 < centre.y1) centres.push_back(centre);
      }
    }
  }
  return centres;
}

void CellsSource::warp_plane(const Box& region, std::uint64_t z, Plane& plane) const {
  const std::size_t width = region.size.x;
  const auto x0 = static_cast<std::int64_t>(region.origin.x),
             absolute_z = static_cast<std::int64_t>(region.origin.z + z);
  for (std::uint64_t y = 0; y < region.size.y; ++y) {
    const auto absolute_y = static_cast<std::int64_t>(region.origin.y + y);
    const std::array<float*, 3> rows{plane.x.data() + y * width, plane.y.data() + y * width,
                                     plane.z.data() + y * width};
    for (std::size_t i = 0; i < width; ++i) rows[0][i] = static_cast<float>(region.origin.x + i);
    std::fill_n(rows[1], width, static_cast<float>(absolute_y));
    std::fill_n(rows[2], width, static_cast<float>(absolute_z));
    if (warp_ == 0) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      coarse_[axis].add_row(x0, width, absolute_y, absolute_z, static_cast<float>(warp_),
                            rows[axis]);
      fine_[axis].add_row(x0, width, absolute_y, absolute_z, static_cast<float>(0.5 * warp_),
                          rows[axis]);
    }
  }
}

/// Gives the voxels of one plane of the region to their centres.
void CellsSource::assign_plane(const Box& region, std::uint64_t z,
                               const std::vector<Centre>& centres, Plane& plane,
                               Field& field) const {
  warp_plane(region, z, plane);
  std::fill(plane.best.begin(), plane.best.end(), std::numeric_limits<float>::max());
  const auto absolute_z = static_cast<double>(region.origin.z + z);
  for (const Centre& centre : centres) {
    if (std::abs(centre.z - absolute_z) > reach_[2]) continue;
    const auto centre_z = static_cast<float>(centre.z);
    const std::size_t count = centre.x1 - centre.x0;
    for (std::uint64_t y = centre.y0; y < centre.y1; ++y) {
      const std::size_t start = y * region.size.x + centre.x0;
      const float* __restrict px = plane.x.data() + start;
      const float* __restrict py = plane.y.data() + start;
      const float* __restrict pz = plane.z.data() + start;
      float* __restrict best = plane.best.data() + start;
      std::uint32_t* __restrict label = field.labels.data() + field.at(centre.x0, y, z);
      for (std::size_t i = 0; i < count; ++i) {
        const float dx = px[i] - centre.x, dy = py[i] - centre.y, dz = pz[i] - centre_z;
        const float distance = dx * dx + dy * dy + dz * dz;
        const bool nearer = distance < best[i];
        best[i] = nearer ? distance : best[i];
        label[i] = nearer ? centre.label : label[i];
      }
    }
  }
}

void CellsSource::sweep(const Box& region, std::uint64_t number, const Field& before,
                        Field& after) const {
  const auto row = static_cast<std::ptrdiff_t>(before.row),
             plane = static_cast<std::ptrdiff_t>(before.plane);
  const std::array<std::int32_t, 8> proposals{1,
                                              -1,
                                              static_cast<std::int32_t>(row),
                                              static_cast<std::int32_t>(-row),
                                              static_cast<std::int32_t>(plane),
                                              static_cast<std::int32_t>(-plane),
                                              0,
                                              0};
  std::vector<std::uint32_t> proposed(region.size.x), random(region.size.x);
  std::vector<std::int32_t> cost(region.size.x);
  const auto thresholds = thresholds_;
  for (std::uint64_t z = 0; z < region.size.z; ++z) {
    for (std::uint64_t y = 0; y < region.size.y; ++y) {
      const std::uint32_t* own = before.labels.data() + before.at(0, y, z);
      std::uint32_t* out = after.labels.data() + after.at(0, y, z);
      const auto base = static_cast<std::uint32_t>(
          hash(seed_, static_cast<std::int64_t>(region.origin.y + y),
               static_cast<std::int64_t>(region.origin.z + z), static_cast<std::int64_t>(number)));
      const auto x0 = static_cast<std::uint32_t>(region.origin.x);
      for (std::uint32_t i = 0; i < region.size.x; ++i)
        random[i] = mix32(base + (x0 + i) * 0x9E3779B9u);
      // The proposal takes three bits; 6 and 7 propose the own label, which with the odd bit above
      // makes 3/8 of all voxels act.
      for (std::uint32_t i = 0; i < region.size.x; ++i) {
        const std::int32_t step = proposals[random[i] & 7u];
        const std::uint32_t copy =
            (random[i] & 8u) != 0 ? own[static_cast<std::ptrdiff_t>(i) + step] : own[i];
        proposed[i] = copy == 0 ? own[i] : copy;
      }
      // Own and copy each meet all 27 voxels; the middle one counts for the own label only, which
      // is undone at the start.
      for (std::uint32_t i = 0; i < region.size.x; ++i)
        cost[i] = static_cast<std::int32_t>(proposed[i] == own[i]) - 1;
      for (std::ptrdiff_t dz = -1; dz <= 1; ++dz) {
        for (std::ptrdiff_t dy = -1; dy <= 1; ++dy) {
          count_row(own + dz * plane + dy * row, own, proposed.data(), region.size.x, cost.data());
        }
      }
      for (std::uint32_t i = 0; i < region.size.x; ++i) {
        std::int32_t paid = 0;
        for (const std::uint32_t threshold : thresholds)
          paid += static_cast<std::int32_t>((random[i] >> 16) < threshold);
        out[i] = cost[i] <= paid ? proposed[i] : own[i];
      }
    }
  }
}

void CellsSource::fill(const Box& box, std::uint32_t* labels) const {
  const auto widen = [&](std::uint64_t origin, std::uint64_t size, std::uint64_t extent,
                         std::uint64_t& from, std::uint64_t& count) {
    from = origin - std::min(origin, sweeps_);
    count = std::min(origin + size + sweeps_, extent) - from;
  };
  Box region;
  widen(box.origin.x, box.size.x, info().extent.x, region.origin.x, region.size.x);
  widen(box.origin.y, box.size.y, info().extent.y, region.origin.y, region.size.y);
  widen(box.origin.z, box.size.z, info().extent.z, region.origin.z, region.size.z);
  Field field(region.size), next(region.size);
  const std::vector<Centre> centres = centres_near(region);
  Plane plane(region.size.x * region.size.y);
  for (std::uint64_t z = 0; z < region.size.z; ++z) assign_plane(region, z, centres, plane, field);
  for (std::uint64_t number = 0; number < sweeps_; ++number) {
    sweep(region, number, field, next);
    std::swap(field.labels, next.labels);
  }
  for (std::uint64_t z = 0; z < box.size.z; ++z) {
    for (std::uint64_t y = 0; y < box.size.y; ++y, labels += box.size.x) {
      const std::uint32_t* from =
          field.labels.data() + field.at(box.origin.x - region.origin.x,
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
