// Writes precomputed folders of one scale: chunks of 64^3, labels as compressed_segmentation with
// blocks of 8^3, scalars raw.
//
// compressed_segmentation knows u32 and u64 only: u8 and u16 labels are written as u32, and come
// back as u32. The leading channel-offset word of each stream is written by
// encode_compressed_segmentation. Voxel sizes become nanometres; a size of unknown unit is written
// as it is, since the format cannot say "unknown".
//
// The folder grows beside its final name and replaces only an empty folder or one that holds
// nothing but a precomputed volume that was written here.
//
// voxel_offset is offset / resolution, which must be a whole number of voxels within a millionth of
// it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "volumes/io/file.hpp"
#include "volumes/io/output_folder.hpp"
#include "volumes/io/precomputed.hpp"

namespace cvr::volumes {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kChunk = 64;
constexpr std::uint32_t kBlock = 8;
constexpr double kWholeWithin = 1e-6;  // of the number itself, or of one voxel
constexpr double kFarthestOffset =
    1125899906842624.0;  // 2^50 voxels: every whole number up to it is a double

/// Labels are uint32 at least: compressed_segmentation holds nothing narrower.
std::string_view data_type(const VolumeInfo& info) {
  const bool widened =
      info.kind == VolumeKind::kLabels && size_of(info.type) < size_of(VoxelType::kU32);
  return long_name_of(widened ? VoxelType::kU32 : info.type);
}

/// Where the volume starts, in voxels of this axis.
std::int64_t voxel_offset_of(const std::string& path, const VolumeInfo& info, std::size_t axis) {
  const double voxels = info.offset[axis] / info.voxel_size[axis];
  const double whole = std::round(voxels);
  const bool representable =
      std::isfinite(voxels) && std::fabs(whole) <= kFarthestOffset &&
      std::fabs(voxels - whole) <= kWholeWithin * std::max(1.0, std::fabs(whole));
  if (!representable) {
    throw_input_error(path, fmt::format("offset along {}", "xyz"[axis]),
                      "a whole number of voxels, since the precomputed format holds no other "
                      "(HDF5, NRRD and raw do)",
                      fmt::format("{} {} = {} voxels of {}", info.offset[axis], info.voxel_unit,
                                  voxels, info.voxel_size[axis]));
  }
  return static_cast<std::int64_t>(whole);
}

PrecomputedScale scale_of(const std::string& path, const VolumeInfo& info) {
  PrecomputedScale scale;
  scale.size = info.extent;
  scale.chunk = {kChunk, kChunk, kChunk};
  scale.compressed = info.kind == VolumeKind::kLabels;
  scale.block = {kBlock, kBlock, kBlock};
  scale.resolution = info.voxel_size;
  if (!info.voxel_unit.empty() && info.voxel_unit != "nm") {
    const auto metres = metres_of(info.voxel_unit);
    if (!metres)
      throw_input_error(path, "", "a voxel size in a unit of length",
                        fmt::format("the unit '{}'", info.voxel_unit));
    for (double& resolution : scale.resolution) resolution *= *metres * 1e9;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    scale.voxel_offset[axis] = voxel_offset_of(path, info, axis);
  scale.key =
      fmt::format("{}_{}_{}", scale.resolution[0], scale.resolution[1], scale.resolution[2]);
  return scale;
}

/// The voxels of a chunk, cut from a row of chunks that starts at the same y and z.
Buffer raw_chunk(const Box& box, const Buffer& row, std::uint64_t row_length, std::size_t voxel) {
  Buffer bytes;
  bytes.reserve(box.size.voxels() * voxel);
  for (std::uint64_t line = 0; line < box.size.y * box.size.z; ++line) {
    bytes.append(row.data() + (line * row_length + box.origin.x) * voxel, box.size.x * voxel);
  }
  return bytes;
}

Buffer compressed_chunk(const std::string& path, const Box& box, const Buffer& row,
                        std::uint64_t row_length, const VolumeInfo& info, const BlockSize& block) {
  const auto words = with_label_type(info.type, [&]<class T>() {
    const T* labels = reinterpret_cast<const T*>(row.data()) + box.origin.x;
    return encode_compressed_segmentation(
        LabelBox<const T>{labels, box.size, row_length, row_length * box.size.y}, block);
  });
  if (!words)
    throw_input_error(path, "", "a chunk that compressed_segmentation can hold",
                      words.error().message);
  Buffer bytes;
  bytes.append(words->data(), words->size() * sizeof(std::uint32_t));
  return bytes;
}

void write_chunks(const std::string& path, const fs::path& folder, const VolumeSource& source,
                  const PrecomputedScale& scale) {
  const VolumeInfo& info = source.info();
  const Extent& extent = info.extent;
  const std::size_t voxel = size_of(info.type);
  Buffer row;
  for (std::uint64_t z = 0; z < extent.z; z += kChunk) {
    for (std::uint64_t y = 0; y < extent.y; y += kChunk) {
      const Box row_box{{0, y, z},
                        {extent.x, std::min(kChunk, extent.y - y), std::min(kChunk, extent.z - z)}};
      row.resize(row_box.size.voxels() * voxel);
      source.read(row_box, row.data());
      for (std::uint64_t x = 0; x < extent.x; x += kChunk) {
        const Box box{{x, y, z}, {std::min(kChunk, extent.x - x), row_box.size.y, row_box.size.z}};
        const Buffer bytes = scale.compressed
                                 ? compressed_chunk(path, box, row, extent.x, info, scale.block)
                                 : raw_chunk(box, row, extent.x, voxel);
        OutputFile file((folder / precomputed_chunk_name(scale, box)).string());
        file.write(bytes.bytes());
        file.commit();
      }
    }
  }
}

}  // namespace

std::string precomputed_info_text(std::string_view data_type, bool labels,
                                  const PrecomputedScale& scale) {
  nlohmann::ordered_json entry{{"key", scale.key},
                               {"size", {scale.size.x, scale.size.y, scale.size.z}},
                               {"resolution", scale.resolution},
                               {"voxel_offset", scale.voxel_offset},
                               {"chunk_sizes", {{kChunk, kChunk, kChunk}}},
                               {"encoding", scale.compressed ? "compressed_segmentation" : "raw"}};
  if (scale.compressed) {
    entry["compressed_segmentation_block_size"] = {scale.block.x, scale.block.y, scale.block.z};
  }
  const nlohmann::ordered_json document{{"@type", "neuroglancer_multiscale_volume"},
                                        {"type", labels ? "segmentation" : "image"},
                                        {"data_type", data_type},
                                        {"num_channels", 1},
                                        {"scales", nlohmann::ordered_json::array({entry})}};
  return document.dump(2) + "\n";
}

void write_precomputed(const VolumePath& path, const VolumeSource& source) {
  const VolumeInfo& info = source.info();
  const PrecomputedScale scale = scale_of(path.file, info);
  OutputFolder folder(path.file);
  fs::create_directory(folder.partial() / scale.key);
  write_chunks(path.file, folder.partial() / scale.key, source, scale);
  OutputFile info_file((folder.partial() / "info").string());
  info_file.write(precomputed_info_text(data_type(info), scale.compressed, scale));
  info_file.commit();
  folder.commit();
}

}  // namespace cvr::volumes
