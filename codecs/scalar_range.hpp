// What lossy codecs ask of the scalars of a volume before they encode it: their range, and that all
// of them are numbers.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

struct ScalarRange {
  double minimum = 0, maximum = 0;
};

/// The least and the largest voxel of a scalar volume, in one pass over slabs of planes. Refuses a
/// volume with NaN or infinite voxels (kUnsupported), naming how many there are and where the first
/// one is.
Expected<ScalarRange> finite_range(const VolumeSource& source, unsigned threads);

/// The value `t` of the way from minimum to maximum, rounded to the nearest voxel of type T. `t`
/// outside 0..1 and NaN are cut.
template <class T>
T voxel_at(const ScalarRange& range, double t) {
  const double cut = t >= 0 ? (t > 1 ? 1 : t) : 0;
  const double value = range.minimum + cut * (range.maximum - range.minimum);
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value);
  } else {
    return static_cast<T>(value < 0 ? value - 0.5 : value + 0.5);
  }
}

/// How far a voxel lies between minimum and maximum, 0..1; 0 where both are equal.
template <class T>
double position_in(const ScalarRange& range, T voxel) {
  const double width = range.maximum - range.minimum;
  return width > 0 ? (static_cast<double>(voxel) - range.minimum) / width : 0;
}

}  // namespace cvr::codecs
