// What a ray gathers on its way: colour and first hit of a primary ray, transmittance of a
// secondary one (IMAGE.md, Materials and Shading of opaque hits).
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "gpu/reference/view.hpp"
#include "gpu/reference/walk.hpp"

namespace cvr::gpu {

/// Marks the cells and bricks that rays visit; several threads may note at once. Only visible
/// bricks count.
class WorkCounter {
 public:
  explicit WorkCounter(const LabelBricks& bricks);
  void note(const Walk& walk);
  NeededWork work() const;

 private:
  using Bits = std::vector<std::atomic<std::uint64_t>>;
  static void mark(Bits& bits, std::uint64_t index);
  static std::uint64_t count(const Bits& bits);

  std::vector<Bits> cells_;  ///< by level
  Bits bricks_;
  std::atomic<std::uint64_t> visits_{0};
};

/// The surface at which a primary ray ends.
struct Surface {
  Vector3 albedo;
  std::size_t axis;   ///< of the normal
  double side;        ///< the normal's component on it, 1 or -1
  bool through_face;  ///< false where the ray began in the cell: no secondary ray starts there
  Vector3 outside;    ///< voxel space; where secondary rays start
};

struct Gathered {
  std::uint64_t label = kNoLabel;  ///< of the first visible cell
  double t = 0;                    ///< where it was entered
  Vector3 colour{0, 0, 0};         ///< of what lies in front of the surface or background
  double transmittance = 1;        ///< with which the surface, or else the background, is seen
  bool opaque = false;             ///< whether `surface` is set
  Surface surface;
};

/// Follows a primary ray to its end. `counter` may be null.
Gathered gather(const View& view, const ReferenceRenderer::Ray& ray, WorkCounter* counter);

/// What reaches the end of a ray, from 0 to 1; cells entered beyond t = longest do not count.
double transmittance(const View& view, const ReferenceRenderer::Ray& ray, WorkCounter* counter,
                     double longest = std::numeric_limits<double>::infinity());

}  // namespace cvr::gpu
