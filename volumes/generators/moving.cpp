// moving: `steps` steps, from `time` on, of a series of random fields that move and change. The
// extent asked for is that of a step; several steps lie stacked along z, and each is what it is
// alone.
//
// The octaves of turbulence.hpp. The wind carries all of them along x by `velocity` voxels a step,
// and finer octaves faster, by a quarter more each, so that shapes shear; positions are whole
// voxels. An octave lives for `lifetime` steps times its spacing over that of the coarsest, but one
// step at least: between two births its lattice values fade from the old ones to the new, with the
// variance kept.
#include <algorithm>
#include <array>
#include <cmath>

#include "volumes/generators/kinds.hpp"
#include "volumes/generators/random.hpp"
#include "volumes/generators/strict_math.hpp"
#include "volumes/generators/turbulence.hpp"

namespace cvr::volumes {

namespace {

constexpr std::array kParameters{
    kScalarBits,
    GeneratorParameter{"time", 0, 0, 1e6, "the first step of the series"},
    GeneratorParameter{"steps", 1, 1, 4096, "how many steps of it, one after the other", true},
    GeneratorParameter{"velocity", 1.5, 0, 64, "voxels a step along x of the coarsest octave"},
    GeneratorParameter{"lifetime", 32, 1, 1e6, "steps until the coarsest octave is another"},
    GeneratorParameter{"slope", 5.0 / 3, 0, 4, "of the power spectrum: energy ~ frequency^-slope"},
    GeneratorParameter{"smallest", 4, 1, 1024,
                       "voxels between lattice points of the finest octave, a power of two", true},
    GeneratorParameter{"largest", 64, 1, 1024, "of the coarsest", true},
};

GeneratorRequest stacked(GeneratorRequest request) {
  request.extent.z *= static_cast<std::uint64_t>(request["steps"]);
  return request;
}

class MovingSource final : public TiledScalars {
 public:
  explicit MovingSource(const GeneratorRequest& request)
      : TiledScalars("moving", stacked(request), static_cast<std::uint64_t>(request["steps"])),
        depth_(request.extent.z) {
    const OctaveRange octaves = octaves_of(request);
    const std::vector<float> amplitudes = amplitudes_of(octaves, request["slope"]);
    for (std::uint64_t step = 0; step < info().time_steps; ++step)
      steps_.push_back(
          layers_at(request["time"] + static_cast<double>(step), octaves, amplitudes, request));
  }

 protected:
  void fill_row(const Coordinate& start, std::uint64_t count, float* values) const override {
    std::fill_n(values, count, 0.0F);
    for (const Layer& layer : steps_[start.z / depth_]) {
      layer.noise.add_row(static_cast<std::int64_t>(start.x) - layer.shift, count,
                          static_cast<std::int64_t>(start.y),
                          static_cast<std::int64_t>(start.z % depth_), layer.amplitude, values);
    }
    to_values(count, values);
  }

 private:
  struct Layer {
    ValueNoise noise;
    float amplitude;
    std::int64_t shift;  ///< voxels along x
  };

  static std::vector<Layer> layers_at(double time, const OctaveRange& octaves,
                                      const std::vector<float>& amplitudes,
                                      const GeneratorRequest& request) {
    std::vector<Layer> layers;
    double faster = 1;
    for (unsigned k = octaves.largest + 1; k-- > octaves.smallest; faster *= 1.25) {
      const double lifetime =
          std::max(1.0, request["lifetime"] / static_cast<double>(1U << (octaves.largest - k)));
      const double age = time / lifetime;
      const double birth = floor_strict(age);
      const double fresh = age - birth;
      const double scale =
          amplitudes[k - octaves.smallest] / std::sqrt(fresh * fresh + (1 - fresh) * (1 - fresh));
      const auto shift =
          static_cast<std::int64_t>(floor_strict(request["velocity"] * faster * time + 0.5));
      for (const double generation : {0.0, 1.0}) {
        const double share = generation == 0 ? 1 - fresh : fresh;
        if (share == 0) continue;
        const std::uint64_t seed =
            hash(request.seed ^ 0x30f1e, k, static_cast<std::int64_t>(birth + generation));
        layers.push_back({ValueNoise(seed, 1U << k), static_cast<float>(share * scale), shift});
      }
    }
    return layers;
  }

  std::uint64_t depth_;  ///< planes of a step
  std::vector<std::vector<Layer>> steps_;
};

}  // namespace

constinit const GeneratorInfo kMovingInfo{
    .kind = "moving",
    .summary = "steps of a series of moving, changing random scalar fields",
    .volume_kind = VolumeKind::kScalars,
    .default_extent = {128, 112, 96},
    .paper_extent = {},
    .parameters = kParameters,
};

std::unique_ptr<VolumeSource> make_moving(const GeneratorRequest& request) {
  return std::make_unique<MovingSource>(request);
}

}  // namespace cvr::volumes
