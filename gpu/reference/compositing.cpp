#include "gpu/reference/compositing.hpp"

#include <bit>

#include "gpu/reference/vector.hpp"

namespace cvr::gpu {

namespace {

constexpr double kExhausted = 1.0 / 256;  ///< a ray with less transmittance ends
constexpr double kOffSurface =
    0x1p-20;  ///< voxels between a surface and the start of its secondary rays

/// Calls visit(material, label) for each cell whose label differs from that of the cell before,
/// until it returns false.
template <class Visit>
void for_each_change(const View& view, Walk& walk, WorkCounter* counter, double longest,
                     const Visit& visit) {
  bool any_before = false;
  std::uint64_t before = 0;
  for (; !walk.at_end() && walk.t() <= longest; walk.next()) {
    if (!walk.visible_brick()) {
      any_before = false;  // invisible labels alone: whatever comes next differs
      continue;
    }
    if (counter != nullptr) counter->note(walk);
    const std::uint64_t label = walk.label();
    if (any_before && before == label) continue;
    any_before = true;
    before = label;
    const Rgba material = view.material(label);
    if (material.a != 0 && !visit(material, label)) return;
  }
}

Surface surface_at(const Walk& walk, const ReferenceRenderer::Ray& ray, const Vector3& albedo) {
  Surface surface{.albedo = albedo, .through_face = walk.face().has_value()};
  surface.axis = surface.through_face ? *walk.face() : longest_axis(ray.direction);
  surface.side = ray.direction[surface.axis] > 0 ? -1 : 1;
  surface.outside = ray.origin + walk.t() * ray.direction;
  if (surface.through_face)
    surface.outside[surface.axis] =
        static_cast<double>(walk.face_plane()) + surface.side * kOffSurface;
  return surface;
}

}  // namespace

WorkCounter::WorkCounter(const LabelBricks& bricks) {
  const auto words = [](std::uint64_t bits) { return (bits + 63) / 64; };
  for (unsigned level = 0; level < bricks.levels(); ++level)
    cells_.emplace_back(words(bricks.level(level).extent().voxels()));
  bricks_ = Bits(words(bricks.grid().voxels()));
}

void WorkCounter::mark(Bits& bits, std::uint64_t index) {
  bits[index / 64].fetch_or(std::uint64_t{1} << (index % 64), std::memory_order_relaxed);
}

std::uint64_t WorkCounter::count(const Bits& bits) {
  std::uint64_t sum = 0;
  for (const auto& word : bits)
    sum += static_cast<std::uint64_t>(std::popcount(word.load(std::memory_order_relaxed)));
  return sum;
}

void WorkCounter::note(const Walk& walk) {
  visits_.fetch_add(1, std::memory_order_relaxed);
  mark(cells_[walk.level()], walk.cell_index());
  mark(bricks_, walk.brick());
}

NeededWork WorkCounter::work() const {
  NeededWork work{.visits = visits_.load(), .distinct_bricks = count(bricks_)};
  for (const Bits& bits : cells_) work.distinct_cells += count(bits);
  return work;
}

Gathered gather(const View& view, const ReferenceRenderer::Ray& ray, WorkCounter* counter) {
  Gathered gathered;
  Walk walk(view, ray);
  for_each_change(
      view, walk, counter, std::numeric_limits<double>::infinity(),
      [&](const Rgba& material, std::uint64_t label) {
        if (gathered.label == kNoLabel) {
          gathered.label = label;
          gathered.t = walk.t();
        }
        const Vector3 albedo{material.r / 255.0, material.g / 255.0, material.b / 255.0};
        if (material.a >= kOpaque) {
          gathered.opaque = true;
          gathered.surface = surface_at(walk, ray, albedo);
          return false;
        }
        const double alpha = material.a / 255.0;
        gathered.colour = gathered.colour + gathered.transmittance * alpha * albedo;
        gathered.transmittance *= 1 - alpha;
        return gathered.transmittance >= kExhausted;
      });
  return gathered;
}

double transmittance(const View& view, const ReferenceRenderer::Ray& ray, WorkCounter* counter,
                     double longest) {
  double passes = 1;
  Walk walk(view, ray);
  for_each_change(view, walk, counter, longest, [&](const Rgba& material, std::uint64_t) {
    passes *= material.a >= kOpaque ? 0 : 1 - material.a / 255.0;
    if (passes < kExhausted) passes = 0;
    return passes > 0;
  });
  return passes;
}

}  // namespace cvr::gpu
