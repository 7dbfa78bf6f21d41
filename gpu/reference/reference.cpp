#include "gpu/reference/reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>

#include "gpu/reference/compositing.hpp"
#include "gpu/reference/label_bricks.hpp"
#include "gpu/reference/vector.hpp"
#include "gpu/reference/view.hpp"
#include "volumes/parallel.hpp"

namespace cvr::gpu {

namespace {

/// Three random numbers from three (Jarzynski, Olano: Hash Functions for GPU Rendering, 2020).
std::array<std::uint32_t, 3> pcg3d(std::array<std::uint32_t, 3> v) {
  for (auto& word : v) word = word * 1664525u + 1013904223u;
  const auto stir = [&v] {
    v[0] += v[1] * v[2];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
  };
  stir();
  for (auto& word : v) word ^= word >> 16;
  stir();
  return v;
}

/// A direction of length 1 in world space, cosine-distributed about a normal along an axis.
Vector3 cosine_direction(const Surface& surface, const std::array<std::uint32_t, 3>& random) {
  const double u1 = (random[0] >> 8) * 0x1p-24, u2 = (random[1] >> 8) * 0x1p-24;
  const double r = std::sqrt(u1), phi = 2 * std::numbers::pi * u2;
  Vector3 direction;
  direction[surface.axis] = surface.side * std::sqrt(1 - u1);
  direction[(surface.axis + 1) % 3] = r * std::cos(phi);
  direction[(surface.axis + 2) % 3] = r * std::sin(phi);
  return direction;
}

struct Frames {
  std::uint32_t first, count;
};

/// Part of the hemisphere above a surface that is open, as the rays of some frames find it.
double openness(const View& view, const Surface& surface, std::uint32_t px, std::uint32_t py,
                const Frames& frames, WorkCounter* counter) {
  const double longest = view.scene().ao_distance * world_size(view.bricks().info());
  const bool roulette = view.scene().ao_roulette;
  const double probability = roulette ? std::ranges::max(surface.albedo) : 1;
  const auto of_255 = static_cast<std::uint32_t>(std::lround(255 * probability));
  double sum = 0;
  for (std::uint32_t i = 0; i < frames.count; ++i) {
    const auto random = pcg3d({px, py, frames.first + i});
    if (roulette && (random[2] >> 16) * 255 >= of_255 << 16) continue;
    const Vector3 direction = cosine_direction(surface, random);
    sum += transmittance(view, {surface.outside, direction / view.scale()}, counter, longest);
  }
  return sum / (probability * frames.count);
}

/// The light that a surface sends back, mean over the frames.
Vector3 shade(const View& view, const Surface& surface, std::uint32_t px, std::uint32_t py,
              const Frames& frames, WorkCounter* counter) {
  const Scene& scene = view.scene();
  const Vector3 light = normalize(scene.light);
  double direct = std::max(0.0, surface.side * light[surface.axis]);
  if (scene.shading == Shading::kShadow && surface.through_face && direct > 0)
    direct *= transmittance(view, {surface.outside, light / view.scale()}, counter);
  const double lambert = scene.ambient + (1 - scene.ambient) * direct;
  const bool occluded = scene.shading == Shading::kAo && surface.through_face;
  return lambert * (occluded ? openness(view, surface, px, py, frames, counter) : 1) *
         surface.albedo;
}

Image draw(const View& view, const Frames& frames, unsigned threads, WorkCounter* counter) {
  const Scene& scene = view.scene();
  Image image{.width = scene.width, .height = scene.height};
  image.colour.resize(3 * image.pixels());
  image.labels.resize(image.pixels());
  image.complete.assign(image.pixels(), 1);
  const Vector3 background{scene.background[0] / 255.0, scene.background[1] / 255.0,
                           scene.background[2] / 255.0};
  volumes::parallel_for(threads, scene.height, [&](unsigned, std::uint64_t row) {
    const auto py = static_cast<std::uint32_t>(row);
    for (std::uint32_t px = 0; px < scene.width; ++px) {
      const Gathered gathered = gather(view, view.primary_ray(px, py), counter);
      const Vector3 behind =
          gathered.opaque ? shade(view, gathered.surface, px, py, frames, counter) : background;
      const Vector3 colour = gathered.colour + gathered.transmittance * behind;
      const std::size_t pixel = row * scene.width + px;
      image.labels[pixel] = gathered.label;
      for (std::size_t channel = 0; channel < 3; ++channel)
        image.colour[3 * pixel + channel] = static_cast<float>(colour[channel]);
    }
  });
  return image;
}

bool same_view(const Scene& a, const Scene& b) {
  return a.width == b.width && a.height == b.height && a.materials == b.materials &&
         a.shading == b.shading && a.light == b.light && a.ambient == b.ambient &&
         a.ao_distance == b.ao_distance && a.ao_roulette == b.ao_roulette &&
         a.lod_bias == b.lod_bias && a.background == b.background;
}

}  // namespace

struct ReferenceRenderer::Impl {
  Impl(const volumes::Volume& finest, std::uint32_t brick, unsigned thread_count)
      : bricks(finest, brick, thread_count), threads(thread_count) {}

  /// The view of a scene and a camera; the last one is kept, since single rays ask for the same one
  /// again and again.
  std::shared_ptr<const View> view(const Scene& scene, const Camera& camera) {
    const std::lock_guard lock(mutex);
    if (!last || last->camera() != camera || !same_view(last->scene(), scene))
      last = std::make_shared<const View>(bricks, scene, camera, threads);
    return last;
  }

  LabelBricks bricks;
  unsigned threads;
  std::mutex mutex;
  std::shared_ptr<const View> last;
};

ReferenceRenderer::ReferenceRenderer(const volumes::Volume& finest, std::uint32_t brick,
                                     unsigned threads)
    : impl_(std::make_unique<Impl>(finest, brick, threads)) {}
ReferenceRenderer::~ReferenceRenderer() = default;

Image ReferenceRenderer::render(const Scene& scene, const Camera& camera, std::uint32_t first_frame,
                                std::uint32_t frames) const {
  return draw(*impl_->view(scene, camera), {first_frame, frames}, impl_->threads, nullptr);
}

Image ReferenceRenderer::render(const Scene& scene, const Camera& camera,
                                NeededWork& needed) const {
  WorkCounter counter(impl_->bricks);
  Image image = draw(*impl_->view(scene, camera), {0, 1}, impl_->threads, &counter);
  needed = counter.work();
  return image;
}

std::uint64_t ReferenceRenderer::trace(const Scene& scene, const Camera& camera,
                                       const Ray& ray) const {
  return gather(*impl_->view(scene, camera), ray, nullptr).label;
}

ReferenceRenderer::Ray ReferenceRenderer::primary_ray(const Scene& scene, const Camera& camera,
                                                      std::uint32_t px, std::uint32_t py) const {
  return impl_->view(scene, camera)->primary_ray(px, py);
}

bool ReferenceRenderer::is_near_tie(const Scene& scene, const Camera& camera, std::uint32_t px,
                                    std::uint32_t py, std::uint64_t other, double distance) const {
  const auto view = impl_->view(scene, camera);
  const Ray ray = view->primary_ray(px, py);
  const Gathered straight = gather(*view, ray, nullptr);
  if (straight.label == other) return true;
  // Where a turned ray is `distance` off: at the hit, or where a ray that misses passes the middle
  // of the volume.
  const volumes::Extent& extent = view->bricks().info().extent;
  const Vector3 middle{extent.x / 2.0, extent.y / 2.0, extent.z / 2.0};
  const double pivot = straight.label != kNoLabel ? straight.t
                                                  : dot(middle - ray.origin, ray.direction) /
                                                        dot(ray.direction, ray.direction);
  const Vector3 forward = normalize(ray.direction);
  Vector3 least{0, 0, 0};
  least[(longest_axis(forward) + 1) % 3] = 1;
  const Vector3 right = normalize(cross(forward, least)), up = cross(right, forward);

  constexpr std::array kRings{0.001, 0.01, 0.05, 0.2, 0.5, 1.0};
  constexpr unsigned kAngles = 24;
  for (const double ring : kRings) {
    const auto found = [&](const Vector3& offset) {
      const Vector3 moved = ring * distance * offset;
      if (gather(*view, {ray.origin + moved, ray.direction}, nullptr).label == other) return true;
      return pivot > 0 &&
             gather(*view, {ray.origin, ray.direction + (1 / pivot) * moved}, nullptr).label ==
                 other;
    };
    for (unsigned i = 0; i < kAngles; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.37) / kAngles;
      if (found(std::cos(angle) * right + std::sin(angle) * up)) return true;
    }
    // Along the ray: another start matters where the eye is in the volume.
    if (found(forward) || found(-1.0 * forward)) return true;
  }
  return false;
}

LabelCheck check_labels(const ReferenceRenderer& reference, const Scene& scene,
                        const Camera& camera, const Image& truth, const Image& found) {
  LabelCheck check{.pixels = truth.pixels()};
  for (std::uint32_t py = 0; py < truth.height; ++py) {
    for (std::uint32_t px = 0; px < truth.width; ++px) {
      const std::size_t pixel = std::size_t{py} * truth.width + px;
      if (truth.labels[pixel] == found.labels[pixel]) continue;
      ++check.differing;
      check.near_ties += reference.is_near_tie(scene, camera, px, py, found.labels[pixel]);
    }
  }
  return check;
}

}  // namespace cvr::gpu
