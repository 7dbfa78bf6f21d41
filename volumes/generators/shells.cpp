// shells: nested walls around a common middle as in a CT scan of a layered object: each wall of one
// density, the room inside it empty or filled with something light, measurement noise in what is
// not air, and exactly 0 everywhere else.
//
// Walls are ellipsoids with the proportions of the volume, dented by smooth noise. The distance to
// a wall is measured along the ray from the middle; over `blur` voxels a wall fades into its
// neighbours, as partial volumes do.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "volumes/generators/kinds.hpp"
#include "volumes/generators/noise.hpp"
#include "volumes/generators/random.hpp"

namespace cvr::volumes {

namespace {

constexpr std::array kParameters{
    kScalarBits,
    GeneratorParameter{"shells", 5, 1, 64, "number of walls", true},
    GeneratorParameter{"thickness", 5, 0.5, 256, "of a wall in voxels"},
    GeneratorParameter{"blur", 1.5, 0.01, 64, "voxels over which a wall fades"},
    GeneratorParameter{"dents", 4, 0, 64, "largest displacement of a wall in voxels"},
    GeneratorParameter{"noise", 0.02, 0, 1, "largest deviation from the density"},
};

constexpr float kOutermost = 0.9F;  // radius of the outermost wall / half the volume
constexpr std::uint32_t kDentSpacing = 24;

class ShellsSource final : public TiledScalars {
 public:
  explicit ShellsSource(const GeneratorRequest& request)
      : TiledScalars("shells", request),
        seed_(mix64(request.seed ^ 0x5e11)),
        half_thickness_(static_cast<float>(request["thickness"]) / 2),
        blur_(static_cast<float>(request["blur"])),
        dents_(static_cast<float>(request["dents"])),
        noise_(static_cast<float>(request["noise"])),
        dent_noise_(hash(seed_, 1), kDentSpacing) {
    const Extent& e = info().extent;
    half_ = {0.5F * static_cast<float>(e.x), 0.5F * static_cast<float>(e.y),
             0.5F * static_cast<float>(e.z)};
    scale_ = std::min({half_[0], half_[1], half_[2]});
    const auto count = static_cast<std::uint64_t>(request["shells"]);
    RandomSequence random(hash(seed_, 2));
    for (std::uint64_t i = 0; i < count; ++i) {
      const float radius =
          kOutermost * scale_ * static_cast<float>(count - i) / static_cast<float>(count);
      const auto density = static_cast<float>(random.between(0.4, 0.95));
      const double filling = random.between(-0.25, 0.25);
      shells_.push_back({radius, density, static_cast<float>(std::max(0.0, filling))});
    }
  }

 protected:
  void fill_row(const Coordinate& start, std::uint64_t count, float* values) const override {
    std::fill_n(values, count, 0.0F);
    if (dents_ > 0) {
      dent_noise_.add_row(static_cast<std::int64_t>(start.x), count,
                          static_cast<std::int64_t>(start.y), static_cast<std::int64_t>(start.z),
                          dents_, values);
    }
    const float y = from_middle(start.y, 1), z = from_middle(start.z, 2);
    for (std::uint64_t i = 0; i < count; ++i) {
      const float x = from_middle(start.x + i, 0);
      const float radius = scale_ * std::sqrt(x * x + y * y + z * z) + values[i];
      const float density = density_at(radius);
      values[i] = density == 0
                      ? 0
                      : std::clamp(density + noise_ * deviation({start.x + i, start.y, start.z}),
                                   0.0F, 1.0F);
    }
  }

 private:
  struct Shell {
    float radius;            ///< of the middle of the wall, in voxels along the shortest axis
    float density, filling;  ///< of the wall; of the room inside it
  };

  float from_middle(std::uint64_t voxel, std::size_t axis) const {
    return (static_cast<float>(voxel) + 0.5F - half_[axis]) / half_[axis];
  }

  /// From the outside in: each wall fades in over its outer face and out, into its filling, over
  /// its inner one.
  float density_at(float radius) const {
    const auto inside = [&](float face) {
      return std::clamp(0.5F + (face - radius) / blur_, 0.0F, 1.0F);
    };
    float density = 0;
    for (const Shell& shell : shells_) {
      const float outer = inside(shell.radius + half_thickness_),
                  inner = inside(shell.radius - half_thickness_);
      if (outer == 0) break;
      density += outer * (shell.density - density);
      density += inner * (shell.filling - density);
    }
    return density;
  }

  float deviation(const Coordinate& c) const {
    return 2 * unit_float(hash(seed_, static_cast<std::int64_t>(info().extent.index(c)))) - 1;
  }

  std::uint64_t seed_;
  float half_thickness_, blur_, dents_, noise_;
  ValueNoise dent_noise_;
  std::array<float, 3> half_{};
  float scale_ = 0;
  std::vector<Shell> shells_;
};

}  // namespace

constinit const GeneratorInfo kShellsInfo{
    .kind = "shells",
    .summary = "nested walls in air, like a CT scan of a layered object",
    .volume_kind = VolumeKind::kScalars,
    .default_extent = {128, 112, 96},
    .paper_extent = {},
    .parameters = kParameters,
};

std::unique_ptr<VolumeSource> make_shells(const GeneratorRequest& request) {
  return std::make_unique<ShellsSource>(request);
}

}  // namespace cvr::volumes
