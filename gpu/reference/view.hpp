// A scene seen by a camera: its rays, the material of every label, and what each brick is walked
// at.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/reference/label_bricks.hpp"
#include "gpu/reference/reference.hpp"
#include "gpu/scene.hpp"

namespace cvr::gpu {

inline constexpr std::uint8_t kInvisibleBrick =
    255;  ///< in place of a level: no label of the brick is visible

class View {
 public:
  View(const LabelBricks& bricks, const Scene& scene, const Camera& camera, unsigned threads);

  const LabelBricks& bricks() const { return bricks_; }
  const Scene& scene() const { return scene_; }
  const Camera& camera() const { return camera_; }
  const Vector3& scale() const { return scale_; }
  ReferenceRenderer::Ray primary_ray(std::uint32_t px, std::uint32_t py) const;
  /// Of a label of the volume.
  Rgba material(std::uint64_t label) const { return materials_[bricks_.table().number_of(label)]; }
  /// The level of detail of a brick, or kInvisibleBrick.
  std::uint8_t level_of(std::uint64_t brick) const { return brick_levels_[brick]; }

 private:
  unsigned level_of_detail(const volumes::Coordinate& brick) const;

  const LabelBricks& bricks_;
  Scene scene_;
  Camera camera_;
  Vector3 scale_;
  Vector3 eye_, forward_, right_,
      up_;                       ///< in world space; right and up reach to the edge of the image
  double pixel_edge_;            ///< in world units, at distance 1
  std::vector<Rgba> materials_;  ///< by number of the label
  std::vector<std::uint8_t> brick_levels_;
};

}  // namespace cvr::gpu
