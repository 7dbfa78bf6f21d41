// `slices`: deferred filtering of the transform vector quantisation paper. Slices along the axis
// nearest to the view are decoded into a ring, from which values are interpolated and gradients
// taken. The paper's ring has the four slices that one slab needs; a larger one draws several slabs
// at a time.
#include <algorithm>
#include <bit>

#include "gpu/caches/cache.hpp"
#include "gpu/scalars/groups.hpp"

namespace cvr::gpu {

namespace {

/// Slices in the ring besides one for each slab that is drawn at a time.
constexpr std::uint32_t kAround = 3;

class SliceRing final : public SampleAccess {
 public:
  static volumes::Expected<std::unique_ptr<SampleAccess>> make(const SampleSetting& setting) {
    auto ring = std::make_unique<SliceRing>(setting);
    const volumes::Extent& e = setting.info.extent;
    const std::uint64_t bytes = 4 * std::max({e.x * e.y, e.x * e.z, e.y * e.z});
    ring->slices_ = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(
        std::bit_floor(setting.cache_bytes / bytes), kAround + 1,
        std::max<std::uint64_t>(kAround + 1, std::bit_ceil(std::max({e.x, e.y, e.z})))));
    if (auto made = setting.allocations.make(ring->ring_, bytes * ring->slices_, "slices"); !made)
      return tl::unexpected(made.error());
    KernelSource source = setting.decoder;
    source.name = "slice";
    source.files.emplace_back("shaders/scalars/slice.comp");
    ring->decode_ = std::make_unique<Kernel>(setting.device, setting.commands, source);
    return ring;
  }

  explicit SliceRing(const SampleSetting& setting) : groups_(setting.device.limits().groups) {}
  void extend_kernel(KernelSource& source) const override {
    source.definitions.emplace_back("CVR_FROM_RING", "1");
  }
  void describe(ScalarFrame& frame) const override {
    frame.ring = ring_.address();
    frame.ring_slices = slices_;
  }
  std::uint32_t slabs_at_a_time(const ScalarFrame& frame) const override {
    return slices_ >= frame.slices[2] ? frame.slices[2] : slices_ - kAround;
  }
  std::uint64_t record(Commands& commands, const ScalarFrame& frame, std::uint32_t first,
                       std::uint32_t last) override;

 private:
  std::uint32_t groups_;  ///< of a dispatch, at most
  std::uint32_t slices_ = 0;
  DeviceBuffer ring_;
  std::unique_ptr<Kernel> decode_;
};

/// In as many dispatches as the device asks for.
std::uint64_t SliceRing::record(Commands& commands, const ScalarFrame& frame, std::uint32_t first,
                                std::uint32_t last) {
  const std::uint64_t runs = std::uint64_t{(frame.slices[0] + 3) / 4} * frame.slices[1];
  const auto at_a_time = static_cast<std::uint32_t>(kScalarGroup * std::uint64_t{groups_} / runs);
  const std::uint32_t count = frame.slices[2];
  for (std::uint32_t from = first; from < last; from += std::min(at_a_time, last - from)) {
    const std::uint32_t to = from + std::min(at_a_time, last - from);
    const std::uint32_t begin = frame.backwards != 0 ? count - to : from;
    commands.dispatch(*decode_, scalar_groups(runs * (to - from)),
                      {begin, begin + (to - from), 0, 0});
  }
  return std::uint64_t{frame.slices[0]} * frame.slices[1] * (last - first);
}

}  // namespace

CacheTraits slice_ring() {
  return {.id = "slices",
          .summary = "scalars alone: slices are decoded into a ring of four or more, then filtered",
          .sized = true,
          .placeholders = false,
          .labels = false,
          .scalars = true,
          .refuses =
              [](const codecs::GpuEncoding&, const DeviceLimits&) {
                return std::string("only scalar volumes are drawn by slices");
              },
          .make_samples = SliceRing::make};
}

}  // namespace cvr::gpu
