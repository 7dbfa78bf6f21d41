// Neuroglancer precomputed volumes: a folder with a JSON file `info` and one folder of chunk files a scale
// (unsharded).
//
//   info                     type image | segmentation, data_type, num_channels 1, scales: [{key, size, resolution (nm),
//                            voxel_offset, chunk_sizes, encoding raw | compressed_segmentation, ...}], all arrays x y z
//   KEY/x0-x1_y0-y1_z0-z1    the voxels x0 <= x < x1 ..., coordinates including voxel_offset, clipped at the upper border;
//                            x fastest; optionally gzipped, with or without the ending .gz
//
// Source: Neuroglancer's published description of the format. A chunk without a file is all zeros, as
// Neuroglancer shows it. A scale whose folder is missing is an error: that is a wrong key more often than an
// empty volume.
#pragma once

#include <string>
#include <vector>

#include "volumes/compressed_segmentation.hpp"
#include "volumes/io/format.hpp"

namespace cvr::volumes {

struct PrecomputedScale {
  std::string key;
  Extent size;
  std::array<double, 3> resolution{1, 1, 1};  ///< nm
  std::array<std::int64_t, 3> voxel_offset{};
  Extent chunk;             ///< clipped to the size
  bool compressed = false;  ///< compressed_segmentation, else raw
  BlockSize block;
};

struct PrecomputedInfo {
  StoredType type{VoxelType::kU8};
  std::optional<VolumeKind> kind;
  PrecomputedScale scale;
};

/// Reads `info` and checks the scale of this key; an empty key means the first. Throws InputError that names
/// the JSON member.
PrecomputedInfo read_precomputed_info(const std::string& file, const std::string& key);

/// "x0-x1_y0-y1_z0-z1" of a box inside the volume.
std::string precomputed_chunk_name(const PrecomputedScale& scale, const Box& box);

}  // namespace cvr::volumes
