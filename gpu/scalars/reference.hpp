// The CPU renderer of scalar volumes in double precision: the truth of every image of scalars.
// Its text is its own; it follows gpu/IMAGE.md, Scalars, and reads decoded voxels.
#pragma once

#include "gpu/image.hpp"
#include "gpu/scalars/transfer.hpp"
#include "volumes/volume.hpp"

namespace cvr::gpu {

/// The image of a scalar volume. scene.width, .height, .transfer, .slice_samples, .light,
/// .ambient and .background count.
Image render_scalars(const volumes::Volume& volume, const Scene& scene, const ValueRange& range,
                     const Camera& camera, unsigned threads);

/// 0..255 for u8; else least and largest finite value (0..0 where there is none).
ValueRange value_range(const volumes::Volume& volume);

}  // namespace cvr::gpu
