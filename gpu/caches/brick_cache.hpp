// The brick cache of CSGV (CSGV-R paper, section 4): bricks are decoded whole, a frame after they
// were first seen.
//
// Before the first frame the coarsest label of each brick is read, which stands in until the brick
// is there. Passes of a frame: provision (compare wishes with what is held), assign (regions),
// decode. shaders/caches/brick_state.glsl has the layout. When bricks find no room, the next frame
// gives up those that the last one did not want; when that is not enough, the frame after starts
// from an empty cache, which mends fragmentation.
#pragma once

#include "gpu/caches/cache.hpp"

namespace cvr::gpu {

enum class BrickDecoding : std::uint8_t {
  kSerial,             ///< one invocation a brick
  kCooperative,        ///< one subgroup a brick
  kCooperativeShared,  ///< the same, with a copy of the encoding in shared memory
};

class BrickCache final : public Cache {
 public:
  static volumes::Expected<std::unique_ptr<Cache>> make(const CacheSetting& setting,
                                                        BrickDecoding decoding);
  /// Why a device cannot decode bricks in one sweep each; empty if it can.
  static std::string refuses_sweep(const codecs::GpuEncoding& encoding, const DeviceLimits& limits);

  void extend_kernel(KernelSource& source) const override;
  void describe(FrameConstants& frame) const override;
  void clear(Commands& commands, bool everything) override;
  void record(Commands& commands, std::uint32_t frame) override;
  CacheReport report() override;
  std::vector<MemoryUse> memory() const override;

 private:
  enum class Relief : std::uint32_t { kNone = 0, kUnwanted = 1, kEverything = 2 };

  BrickCache(const CacheSetting& setting, BrickDecoding decoding)
      : setting_(setting), decoding_(decoding) {}
  volumes::Expected<void> make_buffers();
  void make_kernels();

  CacheSetting setting_;
  BrickDecoding decoding_;
  std::uint32_t bricks_ = 0, units_ = 0, bricks_a_group_ = 1;
  std::uint32_t cells_a_part_ = 0;  ///< of a brick, in one dispatch of the decoding pass
  Relief relief_ = Relief::kNone;
  bool roots_found_ = false;  ///< they do not depend on the scene
  DeviceBuffer cache_, state_, control_, stacks_, list_, roots_;
  std::unique_ptr<Kernel> find_roots_, provision_, assign_, decode_;
};

}  // namespace cvr::gpu
