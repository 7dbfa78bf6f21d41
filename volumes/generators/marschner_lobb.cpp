// marschner-lobb: the test signal of Marschner and Lobb (An evaluation of reconstruction filters
// for volume rendering, IEEE Visualization 1994), almost all of whose energy lies just below the
// Nyquist frequency of 40^3 samples:
//   rho(x, y, z) = (1 - sin(pi z / 2) + alpha (1 + cos(2 pi f cos(pi r / 2)))) / (2 (1 + alpha)),   r = sqrt(x^2 + y^2)
// over -1 <= x, y, z <= 1, with f = 6 and alpha = 1/4 there. The first and the last voxel of an
// axis lie at -1 and 1.
#include <array>
#include <cmath>

#include "volumes/generators/kinds.hpp"
#include "volumes/generators/strict_math.hpp"

namespace cvr::volumes {

namespace {

constexpr std::array kParameters{
    kScalarBits,
    GeneratorParameter{"frequency", 6, 0, 1000,
                       "f of the formula, waves from the middle to the side"},
    GeneratorParameter{"alpha", 0.25, 0, 1000, "share of the waves"},
};

class MarschnerLobbSource final : public TiledScalars {
 public:
  explicit MarschnerLobbSource(const GeneratorRequest& request)
      : TiledScalars("marschner-lobb", request),
        frequency_(request["frequency"]),
        alpha_(request["alpha"]) {}

 protected:
  void fill_row(const Coordinate& start, std::uint64_t count, float* values) const override {
    const Extent& e = info().extent;
    const double y = position(start.y, e.y), z = position(start.z, e.z);
    // sin(pi z / 2) = cos(pi z / 2 - pi / 2)
    const double axial = 1 - cos_turns(z / 4 - 0.25);
    for (std::uint64_t i = 0; i < count; ++i) {
      const double x = position(start.x + i, e.x);
      const double radial = cos_turns(frequency_ * cos_turns(std::sqrt(x * x + y * y) / 4));
      values[i] = static_cast<float>((axial + alpha_ * (1 + radial)) / (2 * (1 + alpha_)));
    }
  }

 private:
  static double position(std::uint64_t voxel, std::uint64_t voxels) {
    return voxels == 1 ? 0 : 2 * static_cast<double>(voxel) / static_cast<double>(voxels - 1) - 1;
  }

  double frequency_, alpha_;
};

}  // namespace

constinit const GeneratorInfo kMarschnerLobbInfo{
    .kind = "marschner-lobb",
    .summary = "the test signal of Marschner and Lobb",
    .volume_kind = VolumeKind::kScalars,
    .default_extent = {41, 42, 43},
    .paper_extent = {},
    .parameters = kParameters,
};

std::unique_ptr<VolumeSource> make_marschner_lobb(const GeneratorRequest& request) {
  return std::make_unique<MarschnerLobbSource>(request);
}

}  // namespace cvr::volumes
