// Which axis of a stored HDF5 array is x, y, z and time.
//
// What the caller says goes before what the file says, and that before the rule: rank 2 is y x,
// rank 3 z y x, rank 4 t z y x. Of rank 4 an array whose last axis looks like channels, and any
// array of rank 5, has to be named by somebody. Axes of time and channels that have length 1 do not
// matter; longer channels are refused.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "volumes/io/hdf5_attributes.hpp"

namespace cvr::volumes {

struct Hdf5AxisOrder {
  std::array<int, 3> axis{-1, -1,
                          -1};  ///< the place of x, y, z in the file; -1: absent, so of length 1
  int time = -1;                ///< -1: no series

  std::uint64_t length(std::size_t i, const std::vector<std::uint64_t>& size) const {
    return axis[i] < 0 ? 1 : size[static_cast<std::size_t>(axis[i])];
  }
};

/// Throws InputError for `file` at `position`. `asked` are the caller's letters, slowest first, or
/// empty.
Hdf5AxisOrder settle_hdf5_axes(const std::string& file, const std::string& position,
                               const std::vector<std::uint64_t>& size, const std::string& asked,
                               const Hdf5Attributes& dataset);

}  // namespace cvr::volumes
