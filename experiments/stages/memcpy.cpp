// The speed of light of the table: the original copied plane by plane into memory that is there
// already. The encode stage reads the mapped original as encoders do; the decode stage reads
// allocated memory as decoders do.
#include "experiments/stages/memcpy.hpp"

#include <cstring>

#include "experiments/stages/destination.hpp"
#include "volumes/parallel.hpp"

namespace cvr::experiments {

namespace {

class MemcpyRun final : public StageRun {
 public:
  MemcpyRun(const WorkerSpec& spec, const volumes::VolumeSource& truth)
      : spec_(spec), truth_(truth), destination_(truth.info(), spec.memory_limit / 2) {}

  Parts prepare() override {
    const std::byte* mapped = truth_.data();
    if (spec_.stage == "decode" && destination_.whole() && mapped != nullptr) {
      voxels_.append(mapped, truth_.info().bytes());
    }
    round();
    Parts parts;
    parts.destination = destination_.whole() ? "whole volume" : "one slab";
    return parts;
  }

  std::vector<Sample> round() override {
    const volumes::Extent& extent = truth_.info().extent;
    const std::size_t plane = extent.x * extent.y * size_of(truth_.info().type);
    const Stopwatch watch;
    for (std::uint64_t z0 = 0; z0 < extent.z; z0 += destination_.preferred_depth()) {
      const std::uint64_t z1 = std::min(extent.z, z0 + destination_.preferred_depth());
      std::byte* out = destination_.begin(z0, z1);
      const std::byte* voxels = voxels_.empty() ? truth_.data() : voxels_.data();
      if (voxels == nullptr) {
        truth_.read({{0, 0, z0}, {extent.x, extent.y, z1 - z0}}, out);
        continue;
      }
      volumes::parallel_for(spec_.threads, z1 - z0, [&](unsigned, std::uint64_t z) {
        std::memcpy(out + z * plane, voxels + (z0 + z) * plane, plane);
      });
    }
    return {watch.lap(spec_.stage, extent.voxels())};
  }

 private:
  WorkerSpec spec_;
  const volumes::VolumeSource& truth_;
  Destination destination_;
  volumes::Buffer voxels_;
};

}  // namespace

std::unique_ptr<StageRun> make_memcpy_run(const StageInput& input) {
  return std::make_unique<MemcpyRun>(input.spec, input.truth);
}

}  // namespace cvr::experiments
