// fibers: straight capped glass fibres in a matrix (background 0), one label each. A stand-in for
// FIBER of the CSGV-R paper.
//
// Fibres are cylinders of one radius (with a spread) and heavy-tailed length, placed one after the
// other at random in the volume and a margin around it; a place that touches an earlier fibre is
// given up for another one, a given number of times, and then taken, the earlier fibre staying in
// front. Directions follow an injection-moulded part: along the flow (z) in the shells, across it
// (x) in the core layer around the middle y, little out of plane. Fibres that meet the volume are
// numbered 1 .. n and the numbers scattered. The segmentation's unsharp border is imitated by a
// noise on the radius, per voxel.
//
// The list of all fibres (tens of bytes each, 1/100,000 of the volume) is made at the start; boxes
// are then drawn from the fibres of each 64^3 tile. Voxels are u16 as in FIBER, u32 where more than
// 65,535 fibres are needed.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/generators/kinds.hpp"
#include "volumes/generators/random.hpp"

namespace cvr::volumes {

namespace {

constexpr std::array kParameters{
    GeneratorParameter{"density", 8.1, 0, 60, "fibres per 10^6 voxels"},
    GeneratorParameter{"radius", 3.3, 0.5, 20, "mean radius in voxels"},
    GeneratorParameter{"length", 375, 4, 600, "mean length in voxels"},
    GeneratorParameter{
        "spread", 0.35, 0, 2,
        "angular spread: tangent of the standard deviation around the main direction"},
    GeneratorParameter{"core", 0.1, 0, 1,
                       "share of the core layer, whose fibres lie across the flow"},
    GeneratorParameter{"attempts", 12, 1, 100, "places tried before an overlap is accepted", true},
    GeneratorParameter{"blur", 0.4, 0, 3, "amplitude of the noise on the radius in voxels"},
};

constexpr std::uint64_t kTileEdge = 64;
constexpr double kLongest = 2.01;  ///< of the mean length

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

struct Fiber {
  Vector centre;     ///< in voxels
  Vector direction;  ///< of length 1
  double half_length, radius;
  std::uint32_t label;
};

/// Squared distance of two segments, from the closest pair of points on the clamped lines.
double squared_distance(const Fiber& a, const Fiber& b) {
  const Vector r{a.centre[0] - b.centre[0], a.centre[1] - b.centre[1], a.centre[2] - b.centre[2]};
  const double parallel = dot(a.direction, b.direction), along_a = dot(a.direction, r),
               along_b = dot(b.direction, r);
  const double scale = 1 - parallel * parallel;
  const auto clamp_to = [](double t, const Fiber& f) {
    return std::clamp(t, -f.half_length, f.half_length);
  };
  double s = scale > 1e-12 ? clamp_to((parallel * along_b - along_a) / scale, a) : 0;
  const double t = clamp_to(parallel * s + along_b, b);
  s = clamp_to(parallel * t - along_a, a);
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double d = r[i] + s * a.direction[i] - t * b.direction[i];
    sum += d * d;
  }
  return sum;
}

/// Fibres by the tiles they come near to. Tiles outside the volume are kept too, for the margin.
class FiberGrid {
 public:
  using Tile = std::array<std::int64_t, 3>;

  /// Calls f(tile) for every tile that the fibre, thickened by `reach`, may meet.
  template <class F>
  static void for_tiles(const Fiber& fiber, double reach, const F& f) {
    Tile low, high;
    for (std::size_t i = 0; i < 3; ++i) {
      const double half = std::abs(fiber.direction[i]) * fiber.half_length + reach;
      low[i] = tile_of(fiber.centre[i] - half);
      high[i] = tile_of(fiber.centre[i] + half);
    }
    const double far = 0.5 * kTileEdge * 1.7320508075688772 + reach;
    for (std::int64_t z = low[2]; z <= high[2]; ++z) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        for (std::int64_t x = low[0]; x <= high[0]; ++x) {
          const auto middle = [](std::int64_t t) {
            return (static_cast<double>(t) + 0.5) * kTileEdge;
          };
          const Vector r{middle(x) - fiber.centre[0], middle(y) - fiber.centre[1],
                         middle(z) - fiber.centre[2]};
          const double t =
              std::clamp(dot(r, fiber.direction), -fiber.half_length, fiber.half_length);
          if (dot(r, r) - 2 * t * dot(r, fiber.direction) + t * t <= far * far) f(Tile{x, y, z});
        }
      }
    }
  }

  void add(const Fiber& fiber, std::uint32_t index, double reach) {
    for_tiles(fiber, reach, [&](const Tile& tile) { tiles_[key(tile)].push_back(index); });
  }
  const std::vector<std::uint32_t>* find(const Tile& tile) const {
    const auto found = tiles_.find(key(tile));
    return found == tiles_.end() ? nullptr : &found->second;
  }

 private:
  static std::int64_t tile_of(double position) {
    return static_cast<std::int64_t>(std::floor(position / kTileEdge));
  }
  static std::uint64_t key(const Tile& t) {
    constexpr std::uint64_t kMask = (1u << 21) - 1;
    const auto part = [](std::int64_t v) {
      return static_cast<std::uint64_t>(v + (1 << 20)) & kMask;
    };
    return part(t[0]) | part(t[1]) << 21 | part(t[2]) << 42;
  }
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> tiles_;
};

/// The fibres of a request, those that meet the volume, in the order in which they were placed.
class FiberList {
 public:
  explicit FiberList(const GeneratorRequest& request);
  std::vector<Fiber> fibers;

 private:
  Fiber propose(RandomSequence& random) const;
  bool meets_volume(const Fiber& fiber) const;

  const GeneratorRequest& request_;
  Vector extent_;
  double margin_;
};

Fiber FiberList::propose(RandomSequence& random) const {
  Fiber fiber;
  for (std::size_t i = 0; i < 3; ++i)
    fiber.centre[i] = random.between(-margin_, extent_[i] + margin_);
  // Lengths: the mean times a factor of mean 1 from 0.3 to kLongest, short ones being common.
  const double u = random.unit();
  fiber.half_length = 0.5 * request_["length"] * (0.3 + 1.8 * u * (0.4 + 0.55 * u));
  fiber.radius = request_["radius"] * (1 + 0.06 * random.bell());
  const bool core =
      std::abs(fiber.centre[1] - 0.5 * extent_[1]) < 0.5 * request_["core"] * extent_[1];
  const double across = request_["spread"] * random.bell(),
               out_of_plane = 0.4 * request_["spread"] * random.bell();
  fiber.direction = core ? Vector{1, out_of_plane, across} : Vector{across, out_of_plane, 1};
  const double length = std::sqrt(dot(fiber.direction, fiber.direction));
  for (double& component : fiber.direction) component /= length;
  fiber.label = 0;
  return fiber;
}

/// Whether the axis of the fibre enters the volume, by slab clipping.
bool FiberList::meets_volume(const Fiber& fiber) const {
  double from = -fiber.half_length, to = fiber.half_length;
  for (std::size_t i = 0; i < 3; ++i) {
    const double low = -0.5 - fiber.centre[i], high = extent_[i] - 0.5 - fiber.centre[i],
                 d = fiber.direction[i];
    if (d == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    from = std::max(from, std::min(low / d, high / d));
    to = std::min(to, std::max(low / d, high / d));
  }
  return from <= to;
}

FiberList::FiberList(const GeneratorRequest& request)
    : request_(request),
      extent_{static_cast<double>(request.extent.x), static_cast<double>(request.extent.y),
              static_cast<double>(request.extent.z)},
      margin_(kLongest / 2 * request["length"]) {
  double room = 1;
  for (const double axis : extent_) room *= axis + 2 * margin_;
  const double wanted = room * request["density"] * 1e-6;
  if (wanted > 1e8)
    throw InputError(
        fmt::format("generator fibers: density: expected at most 10^8 fibres, found {}", wanted));
  RandomSequence random(hash(request.seed, 0xF1BE6));
  const auto attempts = static_cast<std::uint32_t>(request["attempts"]);
  const double reach = 1.3 * request["radius"];
  std::vector<Fiber> placed;
  FiberGrid grid;
  std::vector<std::uint32_t> near;
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(wanted); ++i) {
    Fiber fiber = propose(random);
    for (std::uint32_t attempt = 1; attempt < attempts; ++attempt) {
      near.clear();
      FiberGrid::for_tiles(fiber, reach, [&](const FiberGrid::Tile& tile) {
        if (const auto* there = grid.find(tile))
          near.insert(near.end(), there->begin(), there->end());
      });
      const bool free = std::none_of(near.begin(), near.end(), [&](std::uint32_t other) {
        const double touch = fiber.radius + placed[other].radius + 1;
        return squared_distance(fiber, placed[other]) < touch * touch;
      });
      if (free) break;
      fiber = propose(random);
    }
    grid.add(fiber, static_cast<std::uint32_t>(placed.size()), reach);
    placed.push_back(fiber);
  }
  std::copy_if(placed.begin(), placed.end(), std::back_inserter(fibers),
               [&](const Fiber& f) { return meets_volume(f); });
  const Permutation permutation(std::max<std::size_t>(fibers.size(), 1), hash(request.seed, 0x1D5));
  for (std::size_t i = 0; i < fibers.size(); ++i)
    fibers[i].label = static_cast<std::uint32_t>(1 + permutation(i));
}

class FibersSource final : public TiledSource {
 public:
  FibersSource(const GeneratorRequest& request, std::vector<Fiber> fibers)
      : TiledSource(request, fibers.size() > 65535 ? VoxelType::kU32 : VoxelType::kU16,
                    {kTileEdge, kTileEdge, kTileEdge}),
        fibers_(std::move(fibers)),
        seed_(hash(request.seed, 0xB1C4)),
        blur_(static_cast<float>(request["blur"])) {
    for (std::uint32_t i = 0; i < fibers_.size(); ++i)
      grid_.add(fibers_[i], i, fibers_[i].radius + blur_ + 1);
  }

 protected:
  void fill(const Box& box, std::uint32_t* labels) const override;

 private:
  void draw(const Fiber& fiber, const Box& box, const float* noise, std::uint32_t* labels) const;

  std::vector<Fiber> fibers_;
  FiberGrid grid_;
  std::uint64_t seed_;
  float blur_;
};

void FibersSource::draw(const Fiber& fiber, const Box& box, const float* noise,
                        std::uint32_t* labels) const {
  const std::array<std::uint64_t, 3> origin{box.origin.x, box.origin.y, box.origin.z};
  const std::array<std::uint64_t, 3> size{box.size.x, box.size.y, box.size.z};
  const double reach = fiber.radius + static_cast<double>(blur_) + 1;
  // The part of the axis near the box, then its bounding box in voxels of the box.
  double from = -fiber.half_length, to = fiber.half_length;
  for (std::size_t i = 0; i < 3; ++i) {
    const double low = static_cast<double>(origin[i]) - reach - fiber.centre[i];
    const double high = static_cast<double>(origin[i] + size[i]) + reach - fiber.centre[i],
                 d = fiber.direction[i];
    if (std::abs(d) < 1e-9) continue;
    from = std::max(from, std::min(low / d, high / d));
    to = std::min(to, std::max(low / d, high / d));
  }
  if (from > to) return;
  std::array<std::int64_t, 3> first, last;
  for (std::size_t i = 0; i < 3; ++i) {
    const double a = fiber.centre[i] + from * fiber.direction[i],
                 b = fiber.centre[i] + to * fiber.direction[i];
    const double low = std::floor(std::min(a, b) - reach) - static_cast<double>(origin[i]);
    const double high = std::ceil(std::max(a, b) + reach) - static_cast<double>(origin[i]);
    first[i] = static_cast<std::int64_t>(std::max(low, 0.0));
    last[i] = static_cast<std::int64_t>(std::min(high, static_cast<double>(size[i]) - 1));
  }
  const auto cx = static_cast<float>(fiber.centre[0]), cy = static_cast<float>(fiber.centre[1]),
             cz = static_cast<float>(fiber.centre[2]);
  const auto ux = static_cast<float>(fiber.direction[0]),
             uy = static_cast<float>(fiber.direction[1]),
             uz = static_cast<float>(fiber.direction[2]);
  const auto half = static_cast<float>(fiber.half_length),
             radius = static_cast<float>(fiber.radius);
  const auto x0 = static_cast<std::int32_t>(origin[0]);
  for (std::int64_t z = first[2]; z <= last[2]; ++z) {
    const float dz = static_cast<float>(static_cast<std::int64_t>(origin[2]) + z) - cz;
    for (std::int64_t y = first[1]; y <= last[1]; ++y) {
      const float dy = static_cast<float>(static_cast<std::int64_t>(origin[1]) + y) - cy;
      const std::size_t row =
          box.size.x * (static_cast<std::size_t>(y) + box.size.y * static_cast<std::size_t>(z));
      for (auto x = static_cast<std::int32_t>(first[0]); x <= static_cast<std::int32_t>(last[0]);
           ++x) {
        const std::size_t i = row + static_cast<std::size_t>(x);
        const float dx = static_cast<float>(x0 + x) - cx;
        const float t = dx * ux + dy * uy + dz * uz;
        const float across = dx * dx + dy * dy + dz * dz - t * t;
        const float r = radius + noise[i];
        const bool inside = (t < 0 ? -t : t) <= half && across < r * r && labels[i] == 0;
        labels[i] = inside ? fiber.label : labels[i];
      }
    }
  }
}

void FibersSource::fill(const Box& box, std::uint32_t* labels) const {
  const std::size_t voxels = box.size.voxels();
  std::fill(labels, labels + voxels, 0u);
  const auto* there = grid_.find({static_cast<std::int64_t>(box.origin.x / kTileEdge),
                                  static_cast<std::int64_t>(box.origin.y / kTileEdge),
                                  static_cast<std::int64_t>(box.origin.z / kTileEdge)});
  if (there == nullptr) return;
  std::vector<float> noise(voxels);
  float* out = noise.data();
  for (std::uint64_t z = box.origin.z; z < box.origin.z + box.size.z; ++z) {
    for (std::uint64_t y = box.origin.y; y < box.origin.y + box.size.y; ++y, out += box.size.x) {
      const auto base = static_cast<std::uint32_t>(
          hash(seed_, static_cast<std::int64_t>(y), static_cast<std::int64_t>(z)));
      for (std::uint32_t i = 0; i < box.size.x; ++i) {
        const std::uint32_t random =
            mix32(base + (static_cast<std::uint32_t>(box.origin.x) + i) * 0x9E3779B9u);
        out[i] =
            blur_ * (static_cast<float>(static_cast<std::int32_t>(random >> 8)) * 0x1p-23F - 1.0F);
      }
    }
  }
  for (const std::uint32_t index : *there) draw(fibers_[index], box, noise.data(), labels);
}

}  // namespace

constinit const GeneratorInfo kFibersInfo{
    .kind = "fibers",
    .summary = "straight glass fibres in a matrix; stands in for FIBER",
    .volume_kind = VolumeKind::kLabels,
    .default_extent = {264, 184, 276},
    .paper_extent = {1579, 1092, 1651},
    .parameters = kParameters,
};

std::unique_ptr<VolumeSource> make_fibers(const GeneratorRequest& request) {
  return std::make_unique<FibersSource>(request, FiberList(request).fibers);
}

}  // namespace cvr::volumes
