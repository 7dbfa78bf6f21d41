// The `info` file of a precomputed folder: every number checked before anything is computed from
// it.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "volumes/io/file.hpp"
#include "volumes/io/precomputed.hpp"
#include "volumes/json_text.hpp"

namespace cvr::volumes {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaximumInfo = 16 << 20;
constexpr std::uint64_t kMaximumChunkBytes = std::uint64_t{1} << 30;
constexpr std::int64_t kMaximumOffset = std::int64_t{1} << 60;

/// A value of the document and the way to it, for error texts.
class Member {
 public:
  Member(const std::string& file, const Json& value, std::string path)
      : file_(file), value_(value), path_(std::move(path)) {}

  const Json& json() const { return value_; }

  [[noreturn]] void fail(std::string_view expected) const {
    fail(expected, value_.dump().substr(0, 200));
  }
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
    const std::optional<std::int64_t> number = whole();
    if (!number || *number <= 0) fail("a positive integer");
    return static_cast<std::uint64_t>(*number);
  }

  /// A whole number, also one written as 40.0; none where it is anything else or does not fit.
  std::optional<std::int64_t> whole() const {
    constexpr double kLimit = 9007199254740992.0;  // 2^53: up to it every whole number is a double
    if (value_.is_number_unsigned()) {
      const auto number = value_.get<std::uint64_t>();
      if (number > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
        return std::nullopt;
      return static_cast<std::int64_t>(number);
    }
    if (value_.is_number_integer()) return value_.get<std::int64_t>();
    if (!value_.is_number_float()) return std::nullopt;
    const double number = value_.get<double>();
    if (!(std::fabs(number) <= kLimit) || std::trunc(number) != number) return std::nullopt;
    return static_cast<std::int64_t>(number);
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

std::string shape_of(const Member& scale, const char* name) {
  if (!scale.has(name)) return "?";
  std::string text;
  for (const Json& value : scale.at(name).json())
    text += (text.empty() ? "" : " x ") + value.dump().substr(0, 40);
  return text;
}

std::string describe_scales(const Member& scales) {
  std::string text;
  for (std::size_t i = 0; i < scales.json().size(); ++i) {
    const Member scale = scales.at(i);
    text += fmt::format("{}{} ({} voxels of {} nm)", i == 0 ? "" : ", ", scale.at("key").text(),
                        shape_of(scale, "size"), shape_of(scale, "resolution"));
  }
  return text;
}

constexpr std::string_view kNameAScale = "(FOLDER/KEY names a scale)";

/// Voxels of a scale, 0 where its size is no size: only to compare scales.
double voxels_of(const Member& scale) {
  double voxels = 1;
  for (const Json& value : scale.at("size").json())
    voxels *= value.is_number() ? value.get<double>() : 0;
  return voxels;
}

/// The scales, each with a key of its own.
Member checked_scales(const Member& root) {
  const Member scales = root.at("scales");
  if (!scales.json().is_array() || scales.json().empty())
    scales.fail("an array of at least one scale");
  std::set<std::string> keys;
  for (std::size_t i = 0; i < scales.json().size(); ++i) {
    const Member key = scales.at(i).at("key");
    if (!keys.insert(key.text()).second) key.fail("a key that no other scale has");
  }
  return scales;
}

/// Without a key the first scale is meant, which the format wants to be the finest. Where another
/// has more voxels the first one is a placeholder or the order another, and which one is meant has
/// to be said.
Member find_scale(const Member& root, const std::string& key) {
  const Member scales = checked_scales(root);
  for (std::size_t i = 0; i < scales.json().size(); ++i) {
    const Member scale = scales.at(i);
    if (key.empty() && voxels_of(scales.at(std::size_t{0})) < voxels_of(scale)) {
      scales.fail(
          "a first scale that is the largest, or the key of a scale behind the folder's name",
          fmt::format("the scales {} {}", describe_scales(scales), kNameAScale));
    }
    if (scale.at("key").text() == key) return scale;
  }
  if (key.empty()) return scales.at(std::size_t{0});
  scales.fail(fmt::format("a scale with the key '{}'", key),
              fmt::format("the scales {} {}", describe_scales(scales), kNameAScale));
}

void read_chunk_sizes(const Member& member, StoredType type, PrecomputedScale& scale) {
  const Member chunk_sizes = member.at("chunk_sizes");
  const std::size_t count = chunk_sizes.json().is_array() ? chunk_sizes.json().size() : 1;
  for (std::size_t i = 0; i < std::max<std::size_t>(count, 1); ++i) {
    const auto edges = chunk_sizes.at(i).three_positive();
    const Extent chunk{std::min(edges[0], scale.size.x), std::min(edges[1], scale.size.y),
                       std::min(edges[2], scale.size.z)};
    if (chunk.voxels() * size_of(type.type) > kMaximumChunkBytes)
      chunk_sizes.at(i).fail("chunks of at most 1 GiB");
    i == 0 ? scale.chunk = chunk : scale.more_chunks.emplace_back(chunk);
  }
}

void read_encoding(const Member& root, const Member& member, StoredType type,
                   PrecomputedScale& scale) {
  const Member encoding = member.at("encoding");
  const std::string name = encoding.text();
  scale.compressed = name == "compressed_segmentation";
  if (name != "raw" && !scale.compressed)
    encoding.fail("raw or compressed_segmentation, which are read");
  if (!scale.compressed) return;
  if (type.type != VoxelType::kU32 && type.type != VoxelType::kU64) {
    encoding.fail("compressed_segmentation with data_type uint32 or uint64 only",
                  fmt::format("data_type {}", root.at("data_type").text()));
  }
  const Member blocks = member.at("compressed_segmentation_block_size");
  const auto block = blocks.three_positive();
  for (const std::uint64_t edge : block) {
    if (edge > kMaxBlockEdge) blocks.fail(fmt::format("block edges of at most {}", kMaxBlockEdge));
  }
  scale.block = {static_cast<std::uint32_t>(block[0]), static_cast<std::uint32_t>(block[1]),
                 static_cast<std::uint32_t>(block[2])};
}

PrecomputedScale read_scale(const std::string& file, const Member& root, const Member& member,
                            StoredType type) {
  if (member.has("sharding") && !member.at("sharding").json().is_null()) {
    member.at("sharding").fail("an unsharded scale, the only kind that is read", "a sharded one");
  }
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
      const std::int64_t value = m.whole().value_or(kMaximumOffset + 1);
      if (value < -kMaximumOffset || value > kMaximumOffset) m.fail("an integer of at most 2^60");
      return value;
    });
  }
  read_chunk_sizes(member, type, scale);
  read_encoding(root, member, type, scale);
  return scale;
}

Json parse_info(const std::string& file) {
  const MappedFile mapped(file);
  if (mapped.bytes().size() > kMaximumInfo)
    throw_input_error(file, "", "at most 16 MiB", "a larger file");
  return parse_json(mapped.text(), file);
}

}  // namespace

PrecomputedInfo read_precomputed_info(const std::string& file, const std::string& key) {
  const Json document = parse_info(file);
  const Member root(file, document, "");
  if (root.has("@type") && root.at("@type").text() != "neuroglancer_multiscale_volume") {
    root.at("@type").fail("neuroglancer_multiscale_volume");
  }
  PrecomputedInfo info;
  const std::string type = root.at("type").text();
  if (type != "image" && type != "segmentation") root.at("type").fail("image or segmentation");
  info.kind = type == "image" ? VolumeKind::kScalars : VolumeKind::kLabels;
  info.type = stored_type(root.at("data_type"));
  info.data_type = root.at("data_type").text();
  if (root.at("num_channels").positive() != 1)
    root.at("num_channels").fail("1, since volumes of several channels are not read");
  info.scale = read_scale(file, root, find_scale(root, key), info.type);
  return info;
}

std::string describe_precomputed_scales(const std::string& file) {
  const Json document = parse_info(file);
  const Member root(file, document, "");
  return fmt::format("{} {}", describe_scales(checked_scales(root)), kNameAScale);
}

}  // namespace cvr::volumes
