// `none`: every access decodes.
#include "gpu/caches/cache.hpp"

namespace cvr::gpu {

namespace {

class NoCache final : public Cache {
 public:
  explicit NoCache(const CacheSetting& setting) : setting_(setting) {}
  void extend_kernel(KernelSource& source) const override {
    append_source(source, setting_.decoder);
    source.files.emplace_back("shaders/caches/none.glsl");
  }
  void describe(FrameConstants&) const override {}
  void clear(Commands&, bool) override {}

 private:
  CacheSetting setting_;
};

class DirectSamples final : public SampleAccess {
 public:
  void extend_kernel(KernelSource&) const override {}
  void describe(ScalarFrame&) const override {}
  std::uint32_t slabs_at_a_time(const ScalarFrame&) const override { return UINT32_MAX; }
  std::uint64_t record(Commands&, const ScalarFrame&, std::uint32_t, std::uint32_t) override {
    return 0;
  }
};

}  // namespace

CacheTraits no_cache() {
  return {
      .id = "none",
      .summary = "each access decodes",
      .sized = false,
      .placeholders = false,
      .scalars = true,
      .refuses =
          [](const codecs::GpuEncoding& encoding, const DeviceLimits&) {
            return encoding.voxel_access ? std::string()
                                         : "the codec decodes whole bricks, not single voxels";
          },
      .make = [](const CacheSetting& setting) -> volumes::Expected<std::unique_ptr<Cache>> {
        return std::make_unique<NoCache>(setting);
      },
      .make_samples = [](const SampleSetting&) -> volumes::Expected<std::unique_ptr<SampleAccess>> {
        return std::make_unique<DirectSamples>();
      }};
}

}  // namespace cvr::gpu
