// The truth of every image: a CPU renderer in double precision over the raw label pyramid,
// written from IMAGE.md alone.
//
// It shares no text with the shaders: rays, traversal and shading are its own. It is made to be
// evident, not fast, but draws 480x270 pixels in a second or so with several threads.
#pragma once

#include <memory>
#include <vector>

#include "gpu/image.hpp"
#include "gpu/scene.hpp"
#include "volumes/source.hpp"
#include "volumes/volume.hpp"

namespace cvr::gpu {

/// Work that an image needs, whoever draws it.
struct NeededWork {
  std::uint64_t visits = 0;  ///< cells visited by all rays, in bricks that hold a visible label
  std::uint64_t distinct_cells = 0;   ///< different (cell, level) among them
  std::uint64_t distinct_bricks = 0;  ///< different bricks with a visible label that were visited
};

class ReferenceRenderer {
 public:
  /// Builds the label pyramid of log2(brick) + 1 levels. `finest` outlives the renderer.
  ReferenceRenderer(const volumes::Volume& finest, std::uint32_t brick, unsigned threads);
  ~ReferenceRenderer();

  struct Ray {
    Vector3 origin, direction;  ///< voxel space; direction of any length
  };
  /// Draws frame `frame` (of the random numbers) of a camera; accumulates `frames` of them.
  Image render(const Scene& scene, const Camera& camera, std::uint32_t first_frame = 0,
               std::uint32_t frames = 1) const;
  /// As render(), and counts what the image needs.
  Image render(const Scene& scene, const Camera& camera, NeededWork& needed) const;
  /// The label that a single ray hits first, kNoLabel for none, with the levels of detail of
  /// `camera`.
  std::uint64_t trace(const Scene& scene, const Camera& camera, const Ray& ray) const;
  /// The primary ray of a pixel.
  Ray primary_ray(const Scene& scene, const Camera& camera, std::uint32_t px,
                  std::uint32_t py) const;

  /// Whether a pixel's label may as well be `other`: some ray of this pixel, moved by at most
  /// `distance` voxels at the hit, hits it. Tries displacements of origin and direction on several
  /// rings up to `distance`.
  bool is_near_tie(const Scene& scene, const Camera& camera, std::uint32_t px, std::uint32_t py,
                   std::uint64_t other, double distance = 1e-4) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Where two label images differ, and how many of these pixels are near-ties.
struct LabelCheck {
  std::uint64_t pixels = 0, differing = 0, near_ties = 0;
};
LabelCheck check_labels(const ReferenceRenderer& reference, const Scene& scene,
                        const Camera& camera, const Image& truth, const Image& found);

}  // namespace cvr::gpu
