// The renderer: one encoded volume, one access mode, one shading mode, on one device; frames of one
// scene after another.
//
// Picture and precision: IMAGE.md. Timed and instrumented renderers are different objects with
// different kernels: counters cost time.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "codecs/gpu_encoding.hpp"
#include "gpu/caches/cache.hpp"
#include "gpu/image.hpp"
#include "gpu/scene.hpp"
#include "gpu/vulkan/commands.hpp"

namespace cvr::gpu {

struct RenderOptions {
  std::string access = "none";                           ///< id of an access mode
  std::uint64_t cache_bytes = std::uint64_t{256} << 20;  ///< from 1 MiB
  Shading shading = Shading::kLocal;
  std::uint32_t width = 640, height = 360;  ///< 1 .. 16384 each
  bool instrumented = false;
};

/// Counters of instrumented frames, by name.
using Counters = std::vector<std::pair<std::string, std::uint64_t>>;

struct FrameResult {
  std::vector<PassTime> passes;  ///< in their order; the last is "render"
  double gpu_seconds = 0;        ///< their sum
  double host_seconds = 0;       ///< levels of detail, recording, submission and waiting
  std::uint32_t incomplete = 0;  ///< pixels that met a placeholder
  std::uint32_t resumed =
      0;  ///< further dispatches of the rendering pass, where the driver bounds loops
  CacheReport cache;
};

/// How the first exact picture of a view came about.
struct Settled {
  bool complete = false;
  std::uint32_t frames = 0;      ///< drawn until then
  std::uint32_t incomplete = 0;  ///< pixels left, where the cache cannot hold what one ray needs
};

class Renderer {
 public:
  /// `encoding` and its buffers outlive the call only. kUnsupported with the reason where mode,
  /// codec, volume or device do not go together.
  static volumes::Expected<std::unique_ptr<Renderer>> make(Device& device,
                                                           const codecs::GpuEncoding& encoding,
                                                           const volumes::VolumeInfo& info,
                                                           const RenderOptions& options);
  ~Renderer();

  /// Materials and bricks without a visible label; clears the cache. Returns the time of its
  /// passes.
  volumes::Expected<std::vector<PassTime>> set_scene(const Scene& scene);
  /// Empties the cache, so that the next frame is a first one.
  void clear_cache();
  /// Draws one frame. `restart`: forget samples of earlier frames (the camera has moved); else one
  /// more sample is added.
  FrameResult render(const Camera& camera, bool restart = true);
  /// Draws frames of one view until all pixels have `samples` complete samples. Where the cache is
  /// too small for the view, parts of the picture are drawn after each other; gives up when even
  /// the smallest part makes no progress.
  Settled settle(const Camera& camera, std::uint32_t samples = 1);

  Image read_image() const;
  Counters read_counters() const;
  void clear_counters();
  std::vector<MemoryUse> memory() const;  ///< device memory by use
  double start_seconds() const;  ///< upload and kernels, of make() and the first set_scene()
  std::vector<std::pair<std::string, double>> start_parts() const;

 private:
  struct Impl;
  explicit Renderer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cvr::gpu
