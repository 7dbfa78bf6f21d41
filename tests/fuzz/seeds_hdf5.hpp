// Small HDF5 files by libhdf5 itself, with what the writer of this project does not use: old and
// new superblocks, each layout, byte orders, and attributes as other programs write them.
#pragma once

#include <string>

namespace cvr::fuzz {

struct Hdf5Seed {
  enum Layout { kCompact, kContiguous, kChunked };
  bool latest = false;  ///< the newest superblock and object headers
  Layout layout = kContiguous;
  int rank = 3;       ///< 1 to 5; the sides are 3 4 5 1 1
  unsigned type = 0;  ///< u8, u32, i64, u16 big endian, f32, f64
  bool attributes = false;
  bool variable_length = false;  ///< text
};

void write_hdf5_seed(const std::string& path, const Hdf5Seed& seed);

}  // namespace cvr::fuzz
