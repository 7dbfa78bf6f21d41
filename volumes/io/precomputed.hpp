// Neuroglancer precomputed volumes: a folder with a JSON file `info` and one folder of chunk files
// a scale (unsharded).
//
//   info                     type image | segmentation, data_type, num_channels 1, scales: [{key, size, resolution (nm),
//                            voxel_offset, chunk_sizes, encoding raw | compressed_segmentation,
//                            ...}], all arrays x y z
//   KEY/x0-x1_y0-y1_z0-z1    the voxels x0 <= x < x1 ..., coordinates including voxel_offset, clipped at the upper border;
//                            x fastest; optionally gzipped, with or without the ending .gz
//
// Source: Neuroglancer's published description of the format. A chunk without a file is all zeros,
// as Neuroglancer shows it, but only in a scale that is otherwise sound: its folder exists, holds
// at least one chunk, and nothing but chunks of the grid that `info` describes. Everything else
// (another offset, another size of chunks, files that end in .br, a shard) would read as zeros
// without a word. Read are unsharded scales of one channel, raw and compressed_segmentation.
//
// VolumeInfo::offset is voxel_offset * resolution, in nm, both ways.
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
  Extent chunk;  ///< clipped to the size
  std::vector<Extent>
      more_chunks;  ///< the same voxels once more in chunks of other sizes, which lie in the same folder
  bool compressed = false;  ///< compressed_segmentation, else raw
  BlockSize block;
};

struct PrecomputedInfo {
  StoredType type{VoxelType::kU8};
  std::string data_type;  ///< as the file names it
  std::optional<VolumeKind> kind;
  PrecomputedScale scale;
};

/// Reads `info` and checks the scale of this key; an empty key means the first, which must be the
/// one with the most voxels. Throws InputError that names the JSON member.
PrecomputedInfo read_precomputed_info(const std::string& file, const std::string& key);

/// Whether a folder with an `info` file lies above this name.
bool lies_in_precomputed(const std::string& path);

/// All scales of `info` in one line with what they hold, and how to name one: for errors. Needs a
/// file that read_precomputed_info took.
std::string describe_precomputed_scales(const std::string& file);

/// "x0-x1_y0-y1_z0-z1" of a box inside the volume.
std::string precomputed_chunk_name(const PrecomputedScale& scale, const Box& box);

/// Why a file of this name cannot be a chunk of the scale; empty where it is one. The name may end
/// in .gz.
std::string chunk_name_fault(const PrecomputedScale& scale, std::string_view name);

/// Reads the listing of a scale's folder once. Throws InputError that names a file which is no
/// chunk of the scale, with what was expected, or says that there is none. Names that begin with a
/// dot and folders (of scales whose keys go on from this one's) are passed over.
void check_chunk_names(const std::string& folder, const PrecomputedScale& scale);

/// Throws OutputError where the folder of this name cannot be made, or holds anything but a volume
/// that write_precomputed wrote.
void check_output_folder(const std::string& path);

/// The `info` of a volume of one scale, as it is written, with the chunks that are written.
std::string precomputed_info_text(std::string_view data_type, bool labels,
                                  const PrecomputedScale& scale);

}  // namespace cvr::volumes
