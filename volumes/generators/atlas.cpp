// atlas: a brain of 203 regions of very different sizes in much background, symmetric about the
// middle x. A stand-in for AZBA of the CSGV-R paper; 204 labels with the background 0.
//
// Everything is defined in the space of the paper's volume, 470 x 1224 x 670, and sampled at the
// extent asked for: an atlas keeps its regions at any size. The brain is the union of seven
// ellipsoids (olfactory bulb, telencephalon, tectum, hypothalamus, cerebellum, hindbrain, spinal
// cord), given for one half and mirrored. The tectum is layered by depth. Elsewhere a voxel belongs
// to the region s with the smallest |p - c_s| - w_s, c_s its centre and w_s its heavy-tailed size;
// all p are warped by smooth noise, the same on both sides but for a small part, and by a jitter
// from slice to slice, as outlines drawn by hand have it.
//
// |p - c| - w changes by at most the distance that p moves, so a tile needs to look at few regions:
// those
// whose value at its middle exceeds the smallest by at most twice the tile's radius and warp.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "volumes/generators/kinds.hpp"
#include "volumes/generators/noise.hpp"
#include "volumes/generators/random.hpp"

namespace cvr::volumes {

namespace {

constexpr std::array kParameters{
    GeneratorParameter{
        "warp", 14, 0, 100,
        "amplitude of the smooth warp of the borders, in voxels of the paper's volume"},
    GeneratorParameter{"roughness", 0.4, 0, 20, "amplitude of the fine warp, in the same voxels"},
    GeneratorParameter{"jitter", 0.3, 0, 20,
                       "shift of outlines from slice to slice, in the same voxels"},
    GeneratorParameter{"asymmetry", 0.1, 0, 1, "share of the warp that differs between the sides"},
    GeneratorParameter{"fill", 0.785, 0.2, 1.2, "size of the brain; 1: it fills the volume"},
};

constexpr Extent kTile{64, 16, 16};
constexpr Extent kPaper{470, 1224, 670};
constexpr std::uint32_t kRegions = 203, kLayers = 4;
constexpr std::size_t kTectum = 2;

struct Lobe {
  float x, y, z;  ///< centre; x from the middle plane
  float radius_x, radius_y, radius_z;
};

constexpr std::array kLobes{
    Lobe{44, 130, 330, 40, 95, 62},     Lobe{62, 330, 300, 92, 175, 130},
    Lobe{104, 610, 250, 118, 215, 150}, Lobe{58, 560, 480, 92, 230, 120},
    Lobe{40, 845, 235, 140, 130, 135},  Lobe{46, 920, 400, 104, 230, 120},
    Lobe{20, 1120, 420, 62, 190, 80},
};

struct Region {
  float x, y, z, size;
};

/// How far inside a lobe a point is: 1 at the centre, 0 on the surface, negative outside.
float depth(const Lobe& lobe, float x, float y, float z) {
  const float dx = (x - lobe.x) / lobe.radius_x, dy = (y - lobe.y) / lobe.radius_y,
              dz = (z - lobe.z) / lobe.radius_z;
  return 1.0F - (dx * dx + dy * dy + dz * dz);
}

std::uint32_t scaled(double paper, std::uint64_t extent, std::uint64_t paper_extent) {
  return static_cast<std::uint32_t>(std::max(
      1.0,
      std::floor(paper * static_cast<double>(extent) / static_cast<double>(paper_extent) + 0.5)));
}

class AtlasSource final : public TiledSource {
 public:
  explicit AtlasSource(const GeneratorRequest& request);

 protected:
  void fill(const Box& box, std::uint32_t* labels) const override;

 private:
  struct Warp {
    ValueNoise noise;
    float amplitude;  ///< in voxels of the paper's volume
    bool mirrored;
  };
  struct Row {
    explicit Row(std::size_t count) : x(count), y(count), z(count), best(count), reversed(count) {}
    std::vector<float> x, y, z, best, reversed;
  };
  void place_regions(const GeneratorRequest& request);
  void place_row(const Coordinate& start, std::size_t count, Row& row) const;
  std::vector<std::uint32_t> regions_near(const Box& box) const;

  std::array<float, 3> offset_;  ///< where voxel 0 starts in the paper's space
  std::array<float, 3> step_;    ///< voxels of the paper's volume a voxel
  std::array<std::vector<Warp>, 3> warps_;
  float reach_ = 0;              ///< the warp moves a point by at most this
  std::vector<Region> regions_;  ///< region i has the label i + 1
};

AtlasSource::AtlasSource(const GeneratorRequest& request)
    : TiledSource(request, VoxelType::kU8, kTile) {
  const std::array<std::uint64_t, 3> extent{request.extent.x, request.extent.y, request.extent.z};
  const std::array<std::uint64_t, 3> paper{kPaper.x, kPaper.y, kPaper.z};
  const auto fill = static_cast<float>(request["fill"]);
  for (std::size_t i = 0; i < 3; ++i) {
    step_[i] = static_cast<float>(paper[i]) / (static_cast<float>(extent[i]) * fill);
    offset_[i] = 0.5F * static_cast<float>(paper[i]) * (1.0F - 1.0F / fill);
  }
  const auto spacing = [&](double x, double y, double z) {
    return std::array<std::uint32_t, 3>{scaled(x, extent[0], paper[0]),
                                        scaled(y, extent[1], paper[1]),
                                        scaled(z, extent[2], paper[2])};
  };
  const auto warp = static_cast<float>(request["warp"]),
             asymmetry = static_cast<float>(request["asymmetry"]);
  const auto roughness = static_cast<float>(request["roughness"]),
             jitter = static_cast<float>(request["jitter"]);
  RandomSequence random(hash(request.seed, 0xA71A5));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    warps_[axis].push_back(
        {ValueNoise(random.next(), spacing(90, 90, 90)), warp * (1 - asymmetry), true});
    warps_[axis].push_back(
        {ValueNoise(random.next(), spacing(90, 90, 90)), warp * asymmetry, false});
    warps_[axis].push_back({ValueNoise(random.next(), spacing(28, 28, 28)), 0.25F * warp, true});
    warps_[axis].push_back({ValueNoise(random.next(), spacing(9, 9, 9)), roughness, false});
    if (axis != 1)
      warps_[axis].push_back({ValueNoise(random.next(), spacing(40, 1, 40)), jitter, false});
  }
  float squares = 0;
  for (const auto& axis : warps_) {
    float sum = 0;
    for (const Warp& w : axis) sum += w.amplitude;
    squares += sum * sum;
  }
  reach_ = std::sqrt(squares);
  place_regions(request);
}

/// Centres inside the brain, none of which lies inside the claim of another.
void AtlasSource::place_regions(const GeneratorRequest& request) {
  RandomSequence random(hash(request.seed, 0x4E6));
  while (regions_.size() < kRegions - kLayers) {
    Region region{static_cast<float>(random.between(0, 235)),
                  static_cast<float>(random.between(0, 1224)),
                  static_cast<float>(random.between(0, 670)), 0};
    const double u = random.unit();
    region.size = static_cast<float>(110 * u * u * u * u);
    const bool inside = std::any_of(kLobes.begin(), kLobes.end(), [&](const Lobe& lobe) {
      return &lobe != &kLobes[kTectum] && depth(lobe, region.x, region.y, region.z) > 0.1F &&
             depth(lobe, region.x, region.y, region.z) >
                 depth(kLobes[kTectum], region.x, region.y, region.z) + 0.1F;
    });
    const bool apart = std::all_of(regions_.begin(), regions_.end(), [&](const Region& other) {
      const float dx = region.x - other.x, dy = region.y - other.y, dz = region.z - other.z;
      const float least = 10 + std::abs(region.size - other.size);
      return dx * dx + dy * dy + dz * dz > least * least;
    });
    if (inside && apart) regions_.push_back(region);
  }
}

/// The warped positions of a row in the paper's space, x from the middle plane.
void AtlasSource::place_row(const Coordinate& start, std::size_t count, Row& row) const {
  const std::uint64_t width = info().extent.x;
  const std::array<float*, 3> rows{row.x.data(), row.y.data(), row.z.data()};
  std::fill_n(row.y.begin(), count, offset_[1] + (static_cast<float>(start.y) + 0.5F) * step_[1]);
  std::fill_n(row.z.begin(), count, offset_[2] + (static_cast<float>(start.z) + 0.5F) * step_[2]);
  const auto middle = static_cast<float>(width);
  for (std::size_t i = 0; i < count; ++i) {
    const float twice = 2.0F * static_cast<float>(start.x + i) + 1.0F - middle;
    row.x[i] = 0.5F * (twice < 0 ? -twice : twice) * step_[0];
  }
  // Voxels left of the middle take the noise of their own x, those right of it that of their mirror
  // image.
  const std::uint64_t half = width / 2;
  const std::size_t left = start.x < half ? std::min<std::size_t>(count, half - start.x) : 0;
  const auto y = static_cast<std::int64_t>(start.y), z = static_cast<std::int64_t>(start.z);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const Warp& warp : warps_[axis]) {
      if (warp.amplitude == 0) continue;
      if (!warp.mirrored) {
        warp.noise.add_row(static_cast<std::int64_t>(start.x), count, y, z, warp.amplitude,
                           rows[axis]);
        continue;
      }
      if (left > 0)
        warp.noise.add_row(static_cast<std::int64_t>(start.x), left, y, z, warp.amplitude,
                           rows[axis]);
      if (const std::size_t right = count - left; right > 0) {
        const auto mirror = static_cast<std::int64_t>(width - (start.x + count));
        std::fill_n(row.reversed.begin(), right, 0.0F);
        warp.noise.add_row(mirror, right, y, z, warp.amplitude, row.reversed.data());
        for (std::size_t i = 0; i < right; ++i) rows[axis][left + i] += row.reversed[right - 1 - i];
      }
    }
  }
}

std::vector<std::uint32_t> AtlasSource::regions_near(const Box& box) const {
  const auto middle = [](std::uint64_t origin, std::uint64_t size) {
    return static_cast<float>(origin) + 0.5F * static_cast<float>(size);
  };
  const float ex = 0.5F * static_cast<float>(box.size.x) * step_[0],
              ey = 0.5F * static_cast<float>(box.size.y) * step_[1],
              ez = 0.5F * static_cast<float>(box.size.z) * step_[2];
  const float x = middle(box.origin.x, box.size.x) * step_[0] -
                  0.5F * static_cast<float>(info().extent.x) * step_[0];
  const float px = x < 0 ? -x : x, py = offset_[1] + middle(box.origin.y, box.size.y) * step_[1],
              pz = offset_[2] + middle(box.origin.z, box.size.z) * step_[2];
  const float slack = 2 * (std::sqrt(ex * ex + ey * ey + ez * ez) + reach_) + 1;
  std::vector<float> values;
  float smallest = std::numeric_limits<float>::max();
  for (const Region& r : regions_) {
    const float dx = px - r.x, dy = py - r.y, dz = pz - r.z;
    values.push_back(std::sqrt(dx * dx + dy * dy + dz * dz) - r.size);
    smallest = std::min(smallest, values.back());
  }
  std::vector<std::uint32_t> near;
  for (std::uint32_t i = 0; i < regions_.size(); ++i) {
    if (values[i] <= smallest + slack) near.push_back(i);
  }
  return near;
}

void AtlasSource::fill(const Box& box, std::uint32_t* labels) const {
  const std::vector<std::uint32_t> near = regions_near(box);
  const std::size_t count = box.size.x;
  Row row(count);
  std::vector<float> deepest(count);
  std::vector<std::uint8_t> in_tectum(count);
  for (std::uint64_t z = box.origin.z; z < box.origin.z + box.size.z; ++z) {
    for (std::uint64_t y = box.origin.y; y < box.origin.y + box.size.y; ++y, labels += count) {
      place_row({box.origin.x, y, z}, count, row);
      std::fill(deepest.begin(), deepest.end(), 0.0F);
      std::fill(in_tectum.begin(), in_tectum.end(), std::uint8_t{0});
      for (std::size_t l = 0; l < kLobes.size(); ++l) {
        for (std::size_t i = 0; i < count; ++i) {
          const float d = depth(kLobes[l], row.x[i], row.y[i], row.z[i]);
          in_tectum[i] = d > deepest[i] ? l == kTectum : in_tectum[i];
          deepest[i] = d > deepest[i] ? d : deepest[i];
        }
      }
      std::fill(labels, labels + count, 0u);
      if (std::all_of(deepest.begin(), deepest.end(), [](float d) { return d == 0; })) continue;
      std::fill(row.best.begin(), row.best.end(), std::numeric_limits<float>::max());
      for (const std::uint32_t index : near) {
        const Region& r = regions_[index];
        for (std::size_t i = 0; i < count; ++i) {
          const float dx = row.x[i] - r.x, dy = row.y[i] - r.y, dz = row.z[i] - r.z;
          const float value = std::sqrt(dx * dx + dy * dy + dz * dz) - r.size;
          labels[i] = value < row.best[i] ? index + 1 : labels[i];
          row.best[i] = value < row.best[i] ? value : row.best[i];
        }
      }
      for (std::size_t i = 0; i < count; ++i) {
        if (deepest[i] == 0) {
          labels[i] = 0;
        } else if (in_tectum[i] != 0) {
          const auto layer =
              static_cast<std::uint32_t>(deepest[i] * 1.6F * static_cast<float>(kLayers));
          labels[i] = kRegions - kLayers + 1 + std::min(layer, kLayers - 1);
        }
      }
    }
  }
}

}  // namespace

constinit const GeneratorInfo kAtlasInfo{
    .kind = "atlas",
    .summary = "a symmetric brain of 203 regions of very different sizes; stands in for AZBA",
    .volume_kind = VolumeKind::kLabels,
    .default_extent = {235, 612, 335},
    .paper_extent = {470, 1224, 670},
    .parameters = kParameters,
};

std::unique_ptr<VolumeSource> make_atlas(const GeneratorRequest& request) {
  return std::make_unique<AtlasSource>(request);
}

}  // namespace cvr::volumes
