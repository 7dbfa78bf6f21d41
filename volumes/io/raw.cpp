// Raw voxels, x fastest, beside a sidecar in YAML: FILE.raw and FILE.raw.yaml.
//
//   extent: [512, 256, 128]      x, y, z of a step; FILE.raw must have offset_bytes + steps * X * Y * Z * bytes a voxel, exactly
//   steps: 1                     optional: time steps of a series, one behind the other
//   type: u32                    u8, u16, u32, u64, i16, f32
//   kind: labels                 optional: labels or scalars
//   voxel_size: [8, 8, 40]       optional: along x, y, z
//   voxel_unit: nm               optional
//   byte_order: little           optional: little (default) or big
//   offset_bytes: 0              optional
//   name, source, licence        optional texts
//
// The file is mapped: data() of a little-endian file is the mapping itself.
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "volumes/io/array_source.hpp"
#include "volumes/io/format.hpp"

namespace cvr::volumes {

namespace {

constexpr std::size_t kMaximumSidecar = 1 << 20;
constexpr std::array<std::string_view, 11> kKeys{"extent",     "steps",      "type",         "kind", "voxel_size",
                                                 "voxel_unit", "byte_order", "offset_bytes", "name", "source",
                                                 "licence"};

std::string sidecar_name(const std::string& file) { return file + ".yaml"; }

class Sidecar {
 public:
  explicit Sidecar(std::string file) : file_(std::move(file)) {
    const MappedFile mapped(file_);
    if (mapped.bytes().size() > kMaximumSidecar)
      throw_input_error(file_, "", "at most 1 MiB", "a larger sidecar");
    try {
      root_ = YAML::Load(std::string(mapped.text()));
    } catch (const YAML::Exception& error) {
      throw_input_error(file_, position(error.mark), "YAML", error.msg);
    }
    if (!root_.IsMap()) throw_input_error(file_, "1:1", "a map of keys", "something else");
    for (const auto& entry : root_) check_key(entry.first);
  }

  std::array<std::uint64_t, 3> extent() const {
    return three<std::uint64_t>(required("extent"), "three sizes [x, y, z]");
  }

  /// 0 where the key is missing: a single volume.
  std::uint64_t steps() const {
    const YAML::Node node = root_["steps"];
    if (!node) return 0;
    const auto steps = value<std::uint64_t>(node, "a number of steps, at least 1");
    if (steps == 0) fail(node, "a number of steps, at least 1");
    return steps;
  }

  VoxelType type() const {
    const YAML::Node node = required("type");
    const auto type = voxel_type_from_name(text(node));
    if (!type) fail(node, "u8, u16, u32, u64, i16 or f32");
    return *type;
  }

  std::optional<VolumeKind> kind() const {
    if (!root_["kind"]) return std::nullopt;
    const auto kind = volume_kind_from_name(text("kind"));
    if (!kind) fail(root_["kind"], "labels or scalars");
    return kind;
  }

  std::array<double, 3> voxel_size() const {
    const YAML::Node node = root_["voxel_size"];
    if (!node) return {1, 1, 1};
    const auto size = three<double>(node, "three positive numbers [x, y, z]");
    if (!std::all_of(size.begin(), size.end(), [](double v) { return std::isfinite(v) && v > 0; })) {
      fail(node, "three positive numbers [x, y, z]");
    }
    return size;
  }

  bool big_endian() const {
    const std::string order = text("byte_order");
    if (!order.empty() && order != "little" && order != "big") fail(root_["byte_order"], "little or big");
    return order == "big";
  }

  std::uint64_t offset() const {
    const YAML::Node node = root_["offset_bytes"];
    return node ? value<std::uint64_t>(node, "a number of bytes") : 0;
  }

  /// The scalar of an optional key; empty where it is missing.
  std::string text(const std::string& key) const { return root_[key] ? text(root_[key]) : std::string(); }

 private:
  static std::string position(const YAML::Mark& mark) {
    return fmt::format("{}:{}", mark.line + 1, mark.column + 1);
  }

  [[noreturn]] void fail(const YAML::Node& node, std::string_view expected) const {
    throw_input_error(file_, position(node.Mark()), expected,
                      node.IsScalar() ? fmt::format("'{}'", node.Scalar()) : "another kind of value");
  }

  void check_key(const YAML::Node& key) const {
    const bool known = key.IsScalar() && std::find(kKeys.begin(), kKeys.end(), key.Scalar()) != kKeys.end();
    if (!known) fail(key, fmt::format("one of the keys {}", fmt::join(kKeys, ", ")));
  }

  YAML::Node required(const std::string& key) const {
    if (!root_[key])
      throw_input_error(file_, position(root_.Mark()), fmt::format("the key '{}'", key), "none");
    return root_[key];
  }

  std::string text(const YAML::Node& node) const {
    if (!node.IsScalar()) fail(node, "a text");
    return node.Scalar();
  }

  template <class T>
  T value(const YAML::Node& node, std::string_view expected) const {
    // yaml-cpp reads "-1" into unsigned types as a large number.
    T result{};
    const bool negative = std::is_unsigned_v<T> && node.IsScalar() && node.Scalar().starts_with('-');
    if (negative || !YAML::convert<T>::decode(node, result)) fail(node, expected);
    return result;
  }

  template <class T>
  std::array<T, 3> three(const YAML::Node& node, std::string_view expected) const {
    if (!node.IsSequence() || node.size() != 3) fail(node, expected);
    return {value<T>(node[0], expected), value<T>(node[1], expected), value<T>(node[2], expected)};
  }

  std::string file_;
  YAML::Node root_;
};

}  // namespace

std::unique_ptr<VolumeSource> open_raw(const VolumePath& path, const OpenOptions& options) {
  MappedFile file(path.file, MappedFile::Least::kBegin);
  const Sidecar sidecar(sidecar_name(path.file));
  const VoxelType stored = sidecar.type();
  const Interpretation meaning =
      interpret(path.file, {stored, stored == VoxelType::kI16}, options.kind, sidecar.kind());
  const std::uint64_t stored_steps = sidecar.steps();
  const Steps steps = check_steps(path, "steps", stored_steps);
  const Extent whole = check_extent(sidecar_name(path.file), "extent", sidecar.extent(),
                                    std::max<std::uint64_t>(stored_steps, 1), meaning.type);
  const std::uint64_t step_depth = whole.z / std::max<std::uint64_t>(stored_steps, 1);
  const VolumeInfo info{.extent = {whole.x, whole.y, step_depth * steps.count},
                        .type = meaning.type,
                        .kind = meaning.kind,
                        .voxel_size = sidecar.voxel_size(),
                        .voxel_unit = sidecar.text("voxel_unit"),
                        .time_steps = steps.count};
  const std::uint64_t size = file.size(), offset = sidecar.offset();
  const std::uint64_t voxels = whole.voxels() * size_of(meaning.type);
  if (offset > size || size - offset != voxels) {
    throw_input_error(path.file, "",
                      fmt::format("{} + {} bytes as {} says", offset, voxels, sidecar_name(path.file)),
                      fmt::format("{} bytes", size));
  }
  const ArrayLayout layout{.offset = offset + steps.first * (info.bytes() / steps.count),
                           .big_endian = sidecar.big_endian(),
                           .reject_negative = meaning.reject_negative};
  return open_array(std::move(file), info, layout,
                    {sidecar.text("name"), sidecar.text("source"), sidecar.text("licence")});
}

void write_raw(const VolumePath& path, const VolumeSource& source) {
  const VolumeInfo& info = source.info();
  const Provenance provenance = source.provenance();
  YAML::Emitter yaml;
  yaml << YAML::BeginMap;
  const Extent step = info.step_extent();
  yaml << YAML::Key << "extent" << YAML::Value << YAML::Flow << YAML::BeginSeq << step.x << step.y << step.z
       << YAML::EndSeq;
  if (info.time_steps > 1) yaml << YAML::Key << "steps" << YAML::Value << info.time_steps;
  yaml << YAML::Key << "type" << YAML::Value << std::string(name_of(info.type));
  yaml << YAML::Key << "kind" << YAML::Value << std::string(name_of(info.kind));
  yaml << YAML::Key << "voxel_size" << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const double size : info.voxel_size) yaml << fmt::format("{}", size);
  yaml << YAML::EndSeq;
  const std::array texts{std::pair{"voxel_unit", info.voxel_unit}, std::pair{"name", provenance.name},
                         std::pair{"source", provenance.source}, std::pair{"licence", provenance.licence}};
  for (const auto& [key, text] : texts) {
    if (!text.empty()) yaml << YAML::Key << key << YAML::Value << text;
  }
  yaml << YAML::EndMap;

  OutputFile voxels(path.file);
  OutputFile sidecar(sidecar_name(path.file));
  for_each_slab(source, [&voxels](std::span<const std::byte> slab) { voxels.write(slab); });
  voxels.close();
  sidecar.write(std::string_view(yaml.c_str(), yaml.size()));
  sidecar.write("\n");
  sidecar.close();
  // Both are complete. Without a sidecar the new voxels cannot be read with the old one's extent.
  std::filesystem::remove(sidecar.path());
  voxels.commit();
  sidecar.commit();
}

}  // namespace cvr::volumes
