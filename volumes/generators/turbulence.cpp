// turbulence: a random field with a given power spectrum (turbulence.hpp), no structure and no
// background: the hard case of codecs that live on either.
#include "volumes/generators/turbulence.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "volumes/generators/kinds.hpp"
#include "volumes/generators/random.hpp"
#include "volumes/generators/strict_math.hpp"

namespace cvr::volumes {

namespace {

constexpr std::array kParameters{
    kScalarBits,
    GeneratorParameter{"slope", 5.0 / 3, 0, 4, "of the power spectrum: energy ~ frequency^-slope"},
    GeneratorParameter{"smallest", 2, 1, 1024,
                       "voxels between lattice points of the finest octave, a power of two", true},
    GeneratorParameter{"largest", 64, 1, 1024, "of the coarsest", true},
};

class TurbulenceSource final : public TiledScalars {
 public:
  explicit TurbulenceSource(const GeneratorRequest& request) : TiledScalars("turbulence", request) {
    const OctaveRange octaves = octaves_of(request);
    amplitudes_ = amplitudes_of(octaves, request["slope"]);
    for (unsigned k = octaves.smallest; k <= octaves.largest; ++k)
      noises_.emplace_back(hash(request.seed ^ 0x7a3b1, k), 1U << k);
  }

 protected:
  void fill_row(const Coordinate& start, std::uint64_t count, float* values) const override {
    std::fill_n(values, count, 0.0F);
    for (std::size_t i = 0; i < noises_.size(); ++i) {
      noises_[i].add_row(static_cast<std::int64_t>(start.x), count,
                         static_cast<std::int64_t>(start.y), static_cast<std::int64_t>(start.z),
                         amplitudes_[i], values);
    }
    to_values(count, values);
  }

 private:
  std::vector<ValueNoise> noises_;
  std::vector<float> amplitudes_;
};

}  // namespace

OctaveRange octaves_of(const GeneratorRequest& request) {
  const auto log2_of = [&](std::string_view name) {
    return static_cast<unsigned>(std::bit_width(static_cast<std::uint64_t>(request[name])) - 1);
  };
  const unsigned smallest = log2_of("smallest");
  return {smallest, std::max(smallest, log2_of("largest"))};
}

std::vector<float> amplitudes_of(const OctaveRange& octaves, double slope) {
  // A lattice value in [-1, 1) has the variance 1/3; interpolated with cubic fades 0.74 of it is
  // left along each axis, on average.
  constexpr double kNoiseVariance =
      0.7428571428571429 * 0.7428571428571429 * 0.7428571428571429 / 3;
  constexpr double kDeviation = 1.0 / 6;
  const double growth = exp2_strict((slope - 1) / 2);
  std::vector<double> raw;
  double amplitude = 1, variance = 0;
  for (unsigned k = octaves.smallest; k <= octaves.largest; ++k, amplitude *= growth) {
    raw.push_back(amplitude);
    variance += amplitude * amplitude * kNoiseVariance;
  }
  std::vector<float> amplitudes;
  for (const double a : raw)
    amplitudes.push_back(static_cast<float>(a * kDeviation / std::sqrt(variance)));
  return amplitudes;
}

void to_values(std::uint64_t count, float* sums) {
  for (std::uint64_t i = 0; i < count; ++i) sums[i] = std::clamp(0.5F + sums[i], 0.0F, 1.0F);
}

constinit const GeneratorInfo kTurbulenceInfo{
    .kind = "turbulence",
    .summary = "a random scalar field with a given power spectrum",
    .volume_kind = VolumeKind::kScalars,
    .default_extent = {128, 112, 96},
    .paper_extent = {},
    .parameters = kParameters,
};

std::unique_ptr<VolumeSource> make_turbulence(const GeneratorRequest& request) {
  return std::make_unique<TurbulenceSource>(request);
}

}  // namespace cvr::volumes
