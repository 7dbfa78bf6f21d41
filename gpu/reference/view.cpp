#include "gpu/reference/view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gpu/reference/vector.hpp"
#include "volumes/parallel.hpp"

namespace cvr::gpu {

View::View(const LabelBricks& bricks, const Scene& scene, const Camera& camera, unsigned threads)
    : bricks_(bricks), scene_(scene), camera_(camera), scale_(world_scale(bricks.info())) {
  eye_ = world_from_scene(bricks.info(), camera.eye);
  const double half_angle = camera.vertical_fov_degrees * std::numbers::pi / 360;
  const double half_height = std::tan(half_angle);
  forward_ = normalize(camera.target - camera.eye);
  const Vector3 right = normalize(cross(forward_, camera.up));
  up_ = half_height * cross(right, forward_);
  right_ = half_height * scene.width / scene.height * right;
  pixel_edge_ = 2 * half_height / scene.height;

  const auto& labels = bricks.table().labels();
  materials_.resize(labels.size());
  volumes::parallel_for(threads, labels.size(), [&](unsigned, std::uint64_t i) {
    materials_[i] = scene.material(labels[i]);
  });
  const volumes::Extent& grid = bricks.grid();
  brick_levels_.resize(grid.voxels());
  volumes::parallel_for(threads, brick_levels_.size(), [&](unsigned, std::uint64_t i) {
    const auto numbers = bricks.numbers_in(i);
    const bool visible = std::any_of(numbers.begin(), numbers.end(),
                                     [&](std::uint32_t n) { return materials_[n].a > 0; });
    const volumes::Coordinate brick = grid.coordinate(i);
    brick_levels_[i] =
        visible ? static_cast<std::uint8_t>(level_of_detail(brick)) : kInvisibleBrick;
  });
}

unsigned View::level_of_detail(const volumes::Coordinate& brick) const {
  const double edge = bricks_.brick();
  const Vector3 centre{(static_cast<double>(brick.x) + 0.5) * edge,
                       (static_cast<double>(brick.y) + 0.5) * edge,
                       (static_cast<double>(brick.z) + 0.5) * edge};
  const double distance = length(scale_ * centre - eye_) + edge;
  const double footprint = pixel_edge_ * distance * std::exp2(scene_.lod_bias);
  const double level = std::floor(std::log2(footprint));
  return static_cast<unsigned>(std::clamp(level, 0.0, static_cast<double>(bricks_.levels() - 1)));
}

ReferenceRenderer::Ray View::primary_ray(std::uint32_t px, std::uint32_t py) const {
  const double a = 2 * (px + 0.5) / scene_.width - 1;
  const double b = 1 - 2 * (py + 0.5) / scene_.height;
  return {eye_ / scale_, (forward_ + a * right_ + b * up_) / scale_};
}

}  // namespace cvr::gpu
