// The interface of the renderers: one encoded volume, one access mode, one shading mode, on one
// device; frames of one scene after another. Labels are drawn by gpu/renderer.hpp, scalars by
// gpu/scalars/renderer.hpp.
//
// Image and precision: IMAGE.md. Timed and instrumented renderers are different objects with
// different kernels: counters cost time.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "gpu/allocations.hpp"
#include "gpu/image.hpp"
#include "gpu/scene.hpp"
#include "gpu/vulkan/commands.hpp"
#include "volumes/error.hpp"

namespace cvr::gpu {

struct RenderOptions {
  std::string access = "none";  ///< id of an access mode
  /// What the access mode may take: of labels from 1 MiB; of scalars anything, a ring of slices has
  /// four at least.
  std::uint64_t cache_bytes = std::uint64_t{256} << 20;
  Shading shading = Shading::kLocal;
  std::uint32_t width = 640, height = 360;  ///< 1 .. 16384 each
  bool instrumented = false;                ///< count what costs time to count
};

/// Counters by name.
using Counters = std::vector<std::pair<std::string, std::uint64_t>>;

/// What happened in the passes of one frame.
struct CacheReport {
  std::uint32_t requested = 0;  ///< bricks wanted and not there
  std::uint32_t decoded = 0;
  std::uint32_t refused = 0;  ///< bricks for which there was no room
};

struct FrameResult {
  std::vector<PassTime> passes;  ///< in their order; the last is "render"
  double gpu_seconds = 0;        ///< their sum
  double host_seconds = 0;       ///< levels of detail, recording, submission and waiting
  std::uint32_t incomplete = 0;  ///< pixels that met a placeholder
  std::uint32_t resumed =
      0;  ///< further dispatches of the rendering pass, where the driver bounds loops
  CacheReport cache;
};

/// How the first exact image of a view came about.
struct Settled {
  bool complete = false;
  std::uint32_t frames = 0;      ///< drawn until then
  std::uint32_t incomplete = 0;  ///< pixels left, where the cache cannot hold what one ray needs
};

class FrameRenderer {
 public:
  virtual ~FrameRenderer() = default;

  /// Takes the scene's materials or transfer function, light and background, and forgets all cached
  /// voxels. Returns the times of its passes, none where it has none.
  virtual volumes::Expected<std::vector<PassTime>> set_scene(const Scene& scene) = 0;
  /// Whether frames leave voxels in a cache for later ones.
  virtual bool keeps_voxels() const = 0;
  /// Empties the cache, so that the next frame is a first one.
  virtual void clear_cache() = 0;
  /// Draws one frame. `restart`: forget samples of earlier frames (the camera has moved); else one
  /// more sample is added.
  virtual FrameResult render(const Camera& camera, bool restart = true) = 0;
  /// Draws frames of one view until all pixels have `samples` complete samples. Where the cache is
  /// too small for the view, parts of the image are drawn after each other; gives up when even the
  /// smallest part makes no progress.
  virtual Settled settle(const Camera& camera, std::uint32_t samples = 1) = 0;

  virtual Image read_image() const = 0;
  virtual Counters read_counters() const = 0;
  virtual void clear_counters() = 0;
  virtual std::vector<MemoryUse> memory() const = 0;  ///< device memory by use
  /// Upload, kernels and what else came before the first frame, in seconds.
  virtual std::vector<std::pair<std::string, double>> start_parts() const = 0;
  double start_seconds() const;  ///< their sum
};

/// kBadArgument for an access mode that there is not, and an image without or with too many pixels.
volumes::Expected<void> check_options(const RenderOptions& options);

/// Of a clock that only goes forward.
double seconds_now();

}  // namespace cvr::gpu
