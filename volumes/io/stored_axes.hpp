// Which stored axis is x, y, z or the time, for formats that list axes from the fastest to the
// slowest (raw, NRRD, NIfTI).
//
// A letter per stored axis says it: x, y, z, t (the time steps of a series), c (channels) or '-'
// (an axis that means nothing). Channels and axes without meaning must have length 1 and are
// dropped; a letter that is missing stands for an axis of length 1. What the file says of its axes
// is overruled by OpenOptions::axes, which may leave out the letters of axes of length 1.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volumes/io/array_source.hpp"
#include "volumes/io/format.hpp"

namespace cvr::volumes {

struct StoredAxes {
  std::array<std::optional<std::size_t>, 3>
      axis;                 ///< the stored axis that is x, y, z; none: an axis of length 1
  Extent step;              ///< voxels of one time step
  std::uint64_t steps = 0;  ///< of a series; 0: a single volume
  std::array<std::uint64_t, 4> strides{};  ///< of x, y, z, t in stored voxels
  std::uint64_t voxels() const { return step.voxels() * (steps == 0 ? 1 : steps); }
};

/// The letters that the caller gave, one per stored axis. Throws InputError at `position` if
/// letters or their number do not fit `sizes`. `options.axes` must not be empty.
std::string letters_of(const std::string& file, std::string_view position,
                       const std::vector<std::uint64_t>& sizes, const OpenOptions& options);

/// Throws InputError for a letter given twice, an axis of another length than 1 that would be
/// dropped, and an extent that check_extent refuses.
StoredAxes resolve_axes(const std::string& file, std::string_view position,
                        const std::vector<std::uint64_t>& sizes, std::string_view letters,
                        VoxelType type);

/// The values of x, y, z out of one value per stored axis; `missing` for axes that the file lacks.
std::array<double, 3> along_xyz(const StoredAxes& axes, const std::vector<double>& values,
                                double missing);

/// Sets extent and time steps of `info` and the sizes and strides of `layout` for the steps that
/// the name asks for. `info.type` is set already.
void apply_axes(const VolumePath& path, std::string_view position, const StoredAxes& axes,
                VolumeInfo& info, ArrayLayout& layout);

}  // namespace cvr::volumes
