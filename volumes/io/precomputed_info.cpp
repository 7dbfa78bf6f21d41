// The `info` file of a precomputed folder: parsed, and every number checked before anything is computed from
// it.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "volumes/io/file.hpp"
#include "volumes/io/precomputed.hpp"

namespace cvr::volumes {

namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaximumInfo = 16 << 20;
constexpr std::uint64_t kMaximumChunkBytes = std::uint64_t{1} << 30;
constexpr std::int64_t kMaximumOffset = std::int64_t{1} << 60;

/// A value of the document and the way to it, for error texts.
class Member {
 public:
  Member(const std::string& file, const Json& value, std::string path)
      : file_(file), value_(value), path_(std::move(path)) {}

  const Json& json() const { return value_; }

  [[noreturn]] void fail(std::string_view expected) const { fail(expected, value_.dump().substr(0, 200)); }
  [[noreturn]] void fail(std::string_view expected, std::string_view found) const {
    throw_input_error(file_, path_.empty() ? "top level" : path_, expected, found);
  }

  bool has(const char* name) const { return value_.is_object() && value_.contains(name); }

  Member at(const char* name) const {
    if (!value_.is_object()) fail("an object");
    if (!value_.contains(name)) fail(fmt::format("the member '{}'", name), "none");
    return {file_, value_[name], path_.empty() ? name : path_ + "." + name};
  }

  Member at(std::size_t index) const {
    if (!value_.is_array() || value_.size() <= index)
      fail(fmt::format("an array of more than {} values", index));
    return {file_, value_[index], fmt::format("{}[{}]", path_, index)};
  }

  std::string text() const {
    if (!value_.is_string()) fail("a text");
    return value_.get<std::string>();
  }

  std::uint64_t positive() const {
    if (!value_.is_number_unsigned() || value_.get<std::uint64_t>() == 0) fail("a positive integer");
    return value_.get<std::uint64_t>();
  }

  template <class T, class Get>
  std::array<T, 3> three(Get get) const {
    if (!value_.is_array() || value_.size() != 3) fail("three values [x, y, z]");
    return {get(at(std::size_t{0})), get(at(std::size_t{1})), get(at(std::size_t{2}))};
  }
  std::array<std::uint64_t, 3> three_positive() const {
    return three<std::uint64_t>([](const Member& m) { return m.positive(); });
  }

 private:
  const std::string& file_;
  const Json& value_;
  std::string path_;
};

StoredType stored_type(const Member& member) {
  struct Name {
    std::string_view name;
    StoredType type;
  };
  static constexpr std::array kNames{
      Name{"uint8", {VoxelType::kU8, false}},   Name{"uint16", {VoxelType::kU16, false}},
      Name{"uint32", {VoxelType::kU32, false}}, Name{"uint64", {VoxelType::kU64, false}},
      Name{"int8", {VoxelType::kU8, true}},     Name{"int16", {VoxelType::kI16, true}},
      Name{"int32", {VoxelType::kU32, true}},   Name{"float32", {VoxelType::kF32, false}},
  };
  const std::string name = member.text();
  for (const Name& known : kNames) {
    if (known.name == name) return known.type;
  }
  member.fail("uint8, uint16, uint32, uint64, int8, int16, int32 or float32");
}

/// Keys become folder names below the volume: nothing may lead out of it.
std::string checked_key(const Member& member) {
  const std::string key = member.text();
  const std::filesystem::path path(key);
  bool inside = !key.empty() && path.is_relative();
  for (const auto& part : path) inside = inside && part != "..";
  if (!inside) member.fail("the name of a folder below this one");
  return key;
}

Member find_scale(const Member& root, const std::string& key) {
  const Member scales = root.at("scales");
  if (!scales.json().is_array() || scales.json().empty()) scales.fail("an array of at least one scale");
  std::string known;
  for (std::size_t i = 0; i < scales.json().size(); ++i) {
    const Member scale = scales.at(i);
    const std::string name = scale.at("key").text();
    if (key.empty() || name == key) return scale;
    known += (known.empty() ? "" : ", ") + name;
  }
  scales.fail(fmt::format("a scale with the key '{}'", key), fmt::format("the keys {}", known));
}

PrecomputedScale read_scale(const std::string& file, const Member& member, StoredType type) {
  if (member.has("sharding")) member.at("sharding").fail("an unsharded scale", "a sharded one");
  PrecomputedScale scale;
  scale.key = checked_key(member.at("key"));
  scale.size = check_extent(file, "size", member.at("size").three_positive(), type.type);
  scale.resolution = member.at("resolution").three<double>([](const Member& m) {
    const double value = m.json().is_number() ? m.json().get<double>() : 0;
    if (!std::isfinite(value) || value <= 0) m.fail("a positive number of nanometres");
    return value;
  });
  if (member.has("voxel_offset")) {
    scale.voxel_offset = member.at("voxel_offset").three<std::int64_t>([](const Member& m) {
      const std::int64_t value =
          m.json().is_number_integer() ? m.json().get<std::int64_t>() : kMaximumOffset + 1;
      if (value < -kMaximumOffset || value > kMaximumOffset) m.fail("an integer of at most 2^60");
      return value;
    });
  }
  const Member chunk_sizes = member.at("chunk_sizes").at(std::size_t{0});
  const auto chunk = chunk_sizes.three_positive();
  scale.chunk = {std::min(chunk[0], scale.size.x), std::min(chunk[1], scale.size.y),
                 std::min(chunk[2], scale.size.z)};
  if (scale.chunk.voxels() * size_of(type.type) > kMaximumChunkBytes)
    chunk_sizes.fail("chunks of at most 1 GiB");

  const std::string encoding = member.at("encoding").text();
  scale.compressed = encoding == "compressed_segmentation";
  if (encoding != "raw" && !scale.compressed) member.at("encoding").fail("raw or compressed_segmentation");
  if (!scale.compressed) return scale;
  if (type.type != VoxelType::kU32 && type.type != VoxelType::kU64) {
    member.at("encoding")
        .fail("compressed_segmentation with data_type uint32 or uint64 only", "another data_type");
  }
  const Member blocks = member.at("compressed_segmentation_block_size");
  const auto block = blocks.three_positive();
  for (const std::uint64_t edge : block) {
    if (edge > kMaxBlockEdge) blocks.fail(fmt::format("block edges of at most {}", kMaxBlockEdge));
  }
  scale.block = {static_cast<std::uint32_t>(block[0]), static_cast<std::uint32_t>(block[1]),
                 static_cast<std::uint32_t>(block[2])};
  return scale;
}

}  // namespace

PrecomputedInfo read_precomputed_info(const std::string& file, const std::string& key) {
  const MappedFile mapped(file);
  if (mapped.bytes().size() > kMaximumInfo) throw_input_error(file, "", "at most 16 MiB", "a larger file");
  Json document;
  try {
    document = Json::parse(mapped.text());
  } catch (const Json::exception& error) {
    throw_input_error(file, "", "JSON", error.what());
  }
  const Member root(file, document, "");
  PrecomputedInfo info;
  info.type = stored_type(root.at("data_type"));
  const std::string type = root.at("type").text();
  if (type != "image" && type != "segmentation") root.at("type").fail("image or segmentation");
  info.kind = type == "image" ? VolumeKind::kScalars : VolumeKind::kLabels;
  if (root.at("num_channels").positive() != 1) root.at("num_channels").fail("1");
  info.scale = read_scale(file, find_scale(root, key), info.type);
  return info;
}

std::string precomputed_chunk_name(const PrecomputedScale& scale, const Box& box) {
  const auto range = [](std::uint64_t origin, std::uint64_t size, std::int64_t offset) {
    const std::int64_t start = static_cast<std::int64_t>(origin) + offset;
    return fmt::format("{}-{}", start, start + static_cast<std::int64_t>(size));
  };
  return fmt::format("{}_{}_{}", range(box.origin.x, box.size.x, scale.voxel_offset[0]),
                     range(box.origin.y, box.size.y, scale.voxel_offset[1]),
                     range(box.origin.z, box.size.z, scale.voxel_offset[2]));
}

}  // namespace cvr::volumes
