// Writes precomputed folders of one scale: chunks of 64^3, labels as compressed_segmentation with blocks of
// 8^3, scalars raw.
//
// compressed_segmentation knows u32 and u64 only: u8 and u16 labels are written as u32, and come back as u32.
// The leading channel-offset word of each stream is written by encode_compressed_segmentation. Voxel sizes
// become nanometres; a size of unknown unit is written as it is, since the format cannot say "unknown".
//
// The folder grows beside its final name and replaces only an empty folder or one that holds nothing but a
// precomputed volume.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "volumes/io/file.hpp"
#include "volumes/io/precomputed.hpp"

namespace cvr::volumes {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kChunk = 64;
constexpr std::uint32_t kBlock = 8;
constexpr int kPartialNames = 1000;

/// A name "PATH.SUFFIX0" or the next number that nothing has.
fs::path free_name(const fs::path& path, const char* suffix) {
  for (int number = 0; number < kPartialNames; ++number) {
    fs::path candidate = fmt::format("{}.{}{}", path.string(), suffix, number);
    if (!fs::exists(candidate)) return candidate;
  }
  throw_input_error(path.string(), "", "a free temporary name beside it", "a thousand of them in use");
}

/// A folder in the making, as OutputFile is for files.
class OutputFolder {
 public:
  explicit OutputFolder(fs::path path) : path_(std::move(path)) {
    check_replaceable();
    partial_ = free_name(path_, "part");
    std::error_code error;
    if (!fs::create_directory(partial_, error)) {
      throw_input_error(path_.string(), "", "a name that can be written", error.message());
    }
  }
  ~OutputFolder() {
    std::error_code ignored;
    if (!committed_) fs::remove_all(partial_, ignored);
  }
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const fs::path& partial() const { return partial_; }

  void commit() {
    std::error_code error;
    std::optional<fs::path> old;
    if (fs::exists(path_)) {
      old = free_name(path_, "old");
      fs::rename(path_, *old, error);
    }
    if (!error) fs::rename(partial_, path_, error);
    if (error) {
      std::error_code ignored;
      if (old && !fs::exists(path_)) fs::rename(*old, path_, ignored);
      throw_input_error(path_.string(), "", "a folder that can be replaced", error.message());
    }
    committed_ = true;
    std::error_code ignored;
    if (old) fs::remove_all(*old, ignored);
  }

 private:
  void check_replaceable() const {
    if (!fs::exists(path_)) return;
    if (!fs::is_directory(path_))
      throw_input_error(path_.string(), "", "a folder or a free name", "a file of this name");
    std::set<fs::path> allowed;
    if (fs::is_regular_file(path_ / "info")) {
      const auto info = nlohmann::json::parse(MappedFile((path_ / "info").string()).text(), nullptr, false);
      allowed.insert("info");
      for (const auto& scale :
           info.is_object() ? info.value("scales", nlohmann::json::array()) : nlohmann::json::array()) {
        if (scale.is_object() && scale.contains("key") && scale["key"].is_string()) {
          allowed.insert(*fs::path(scale["key"].get<std::string>()).begin());
        }
      }
    }
    for (const auto& entry : fs::directory_iterator(path_)) {
      if (!allowed.contains(entry.path().filename())) {
        throw_input_error(path_.string(), "", "a folder that holds nothing but a precomputed volume",
                          fmt::format("'{}' in it", entry.path().filename().string()));
      }
    }
  }

  fs::path path_;
  fs::path partial_;
  bool committed_ = false;
};

const char* data_type(const VolumeInfo& info) {
  switch (info.type) {
    case VoxelType::kU8:
      return info.kind == VolumeKind::kLabels ? "uint32" : "uint8";
    case VoxelType::kU16:
      return info.kind == VolumeKind::kLabels ? "uint32" : "uint16";
    case VoxelType::kU32:
      return "uint32";
    case VoxelType::kU64:
      return "uint64";
    case VoxelType::kI16:
      return "int16";
    case VoxelType::kF32:
      return "float32";
  }
  return "?";
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
  scale.key = fmt::format("{}_{}_{}", scale.resolution[0], scale.resolution[1], scale.resolution[2]);
  return scale;
}

std::string info_text(const VolumeInfo& info, const PrecomputedScale& scale) {
  nlohmann::ordered_json entry{{"key", scale.key},
                               {"size", {scale.size.x, scale.size.y, scale.size.z}},
                               {"resolution", scale.resolution},
                               {"voxel_offset", scale.voxel_offset},
                               {"chunk_sizes", {{scale.chunk.x, scale.chunk.y, scale.chunk.z}}},
                               {"encoding", scale.compressed ? "compressed_segmentation" : "raw"}};
  if (scale.compressed) {
    entry["compressed_segmentation_block_size"] = {scale.block.x, scale.block.y, scale.block.z};
  }
  const nlohmann::ordered_json document{{"@type", "neuroglancer_multiscale_volume"},
                                        {"type", scale.compressed ? "segmentation" : "image"},
                                        {"data_type", data_type(info)},
                                        {"num_channels", 1},
                                        {"scales", nlohmann::ordered_json::array({entry})}};
  return document.dump(2) + "\n";
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

Buffer compressed_chunk(const std::string& path, const Box& box, const Buffer& row, std::uint64_t row_length,
                        const VolumeInfo& info, const BlockSize& block) {
  const auto words = with_label_type(info.type, [&]<class T>() {
    const T* labels = reinterpret_cast<const T*>(row.data()) + box.origin.x;
    return encode_compressed_segmentation(
        LabelBox<const T>{labels, box.size, row_length, row_length * box.size.y}, block);
  });
  if (!words)
    throw_input_error(path, "", "a chunk that compressed_segmentation can hold", words.error().message);
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
        const Buffer bytes = scale.compressed ? compressed_chunk(path, box, row, extent.x, info, scale.block)
                                              : raw_chunk(box, row, extent.x, voxel);
        OutputFile file((folder / precomputed_chunk_name(scale, box)).string());
        file.write(bytes.bytes());
        file.commit();
      }
    }
  }
}

}  // namespace

void write_precomputed(const VolumePath& path, const VolumeSource& source) {
  fs::path target(path.file);
  if (!target.has_filename()) target = target.parent_path();
  const PrecomputedScale scale = scale_of(path.file, source.info());
  OutputFolder folder(target);
  fs::create_directory(folder.partial() / scale.key);
  write_chunks(path.file, folder.partial() / scale.key, source, scale);
  OutputFile info((folder.partial() / "info").string());
  info.write(info_text(source.info(), scale));
  info.commit();
  folder.commit();
}

}  // namespace cvr::volumes
