#include "experiments/config/scene_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <vector>

#include "experiments/config/project_folders.hpp"
#include "experiments/config/yaml_reader.hpp"

namespace cvr::experiments {

namespace fs = std::filesystem;

namespace {

constexpr double kFarthest = 1e6;          ///< coordinate in scene space
constexpr std::uint64_t kMaxSide = 32768;  ///< pixels
constexpr std::uint64_t kMostSliceSamples = 64;
constexpr double kLeastSine = 1e-6;  ///< of the angle between view and up

gpu::Vector3 read_vector(const YamlValue& value) {
  const auto axes = value.list("three numbers [x, y, z]");
  if (axes.size() != 3) value.expected("three numbers [x, y, z]");
  gpu::Vector3 vector;
  for (std::size_t axis = 0; axis < 3; ++axis)
    vector[axis] = axes[axis].number(-kFarthest, kFarthest);
  return vector;
}

double length(const gpu::Vector3& a) { return std::hypot(a[0], a[1], a[2]); }

gpu::Vector3 read_direction(const YamlValue& value) {
  const gpu::Vector3 vector = read_vector(value);
  if (length(vector) == 0) value.reject("expected a vector other than [0, 0, 0], found [0, 0, 0]");
  return vector;
}

std::array<std::uint8_t, 3> read_colour(const YamlValue& value) {
  const auto channels = value.list("three channels [r, g, b]");
  if (channels.size() != 3) value.expected("three channels [r, g, b]");
  std::array<std::uint8_t, 3> colour;
  for (std::size_t i = 0; i < 3; ++i)
    colour[i] = static_cast<std::uint8_t>(channels[i].integer(0, 255));
  return colour;
}

/// What is wrong with a camera, if anything: it must look somewhere, and not along its own up.
std::optional<std::string> fault_of(const gpu::Camera& camera) {
  gpu::Vector3 view;
  for (std::size_t axis = 0; axis < 3; ++axis) view[axis] = camera.target[axis] - camera.eye[axis];
  if (length(view) == 0) return "expected an eye away from its target, found both at one place";
  const gpu::Vector3& up = camera.up;
  const gpu::Vector3 across{view[1] * up[2] - view[2] * up[1], view[2] * up[0] - view[0] * up[2],
                            view[0] * up[1] - view[1] * up[0]};
  if (length(across) <= kLeastSine * length(view) * length(up))
    return "expected an up that is not parallel to the view, found a parallel one";
  return std::nullopt;
}

gpu::Camera read_key(const YamlValue& value) {
  gpu::Camera camera;
  value.fields(
      {{"eye", [&](const YamlValue& v) { camera.eye = read_vector(v); }, true},
       {"target", [&](const YamlValue& v) { camera.target = read_vector(v); }},
       {"up", [&](const YamlValue& v) { camera.up = read_direction(v); }},
       {"fov", [&](const YamlValue& v) { camera.vertical_fov_degrees = v.number(0.01, 179); }}});
  if (const auto fault = fault_of(camera)) value.reject(*fault);
  return camera;
}

void read_labels(const YamlValue& value, gpu::MaterialRule& rule) {
  if (value.is_list()) {
    const auto ends = value.list("the first and the last label");
    if (ends.size() != 2) value.expected("[FIRST, LAST]");
    rule.first = ends[0].integer(0, UINT64_MAX);
    rule.last = ends[1].integer(rule.first, UINT64_MAX);
  } else if (value.text("all, a label, or [FIRST, LAST]") != "all") {
    if (value.text().empty() ||
        !std::ranges::all_of(value.text(), [](char c) { return c >= '0' && c <= '9'; }))
      value.expected("all, a label, or [FIRST, LAST]");
    rule.first = rule.last = value.integer(0, UINT64_MAX);
  }
}

gpu::MaterialRule read_material(const YamlValue& value) {
  gpu::MaterialRule rule;
  value.fields(
      {{"labels", [&](const YamlValue& v) { read_labels(v, rule); }},
       {"modulus", [&](const YamlValue& v) { rule.modulus = v.integer(1, UINT64_MAX); }},
       {"remainder", [&](const YamlValue& v) { rule.remainder = v.integer(0, UINT64_MAX - 1); }},
       {"opacity", [&](const YamlValue& v) { rule.opacity = v.number(0, 1); }},
       {"colour", [&](const YamlValue& v) { rule.colour = read_colour(v); }}});
  if (rule.remainder >= rule.modulus) {
    value.reject(fmt::format("expected a remainder below the modulus {}, found {}", rule.modulus,
                             rule.remainder));
  }
  return rule;
}

void read_transfer_point(const YamlValue& value, std::vector<gpu::TransferPoint>& points) {
  gpu::TransferPoint point;
  value.fields(
      {{"value", [&](const YamlValue& v) { point.value = v.number(0, 1); }, true},
       {"colour", [&](const YamlValue& v) { point.colour = read_colour(v); }, true},
       {"density", [&](const YamlValue& v) { point.density = v.number(0, kFarthest); }, true}});
  if (!points.empty() && point.value <= points.back().value)
    value.reject(fmt::format("expected a value above that of the point before, {}, found {}",
                             points.back().value, point.value));
  points.push_back(point);
}

gpu::Shading read_shading(const YamlValue& value) {
  const std::string name = value.text("local, shadow or ao");
  const auto shading = gpu::shading_from_name(name);
  if (!shading) {
    std::vector<std::string> names;
    for (const gpu::Shading known : gpu::kShadings) names.emplace_back(gpu::name_of(known));
    value.expected("local, shadow or ao" + did_you_mean(name, names));
  }
  return *shading;
}

void read_size(const YamlValue& value, gpu::Scene& scene) {
  const auto sides = value.list("two sides [WIDTH, HEIGHT]");
  if (sides.size() != 2) value.expected("two sides [WIDTH, HEIGHT]");
  scene.width = static_cast<std::uint32_t>(sides[0].integer(1, kMaxSide));
  scene.height = static_cast<std::uint32_t>(sides[1].integer(1, kMaxSide));
}

/// Keys that are sound one by one may still swing through a bad view between them.
void check_path(const gpu::Scene& scene, const YamlValue& root) {
  for (std::uint32_t frame = 0; frame < scene.frames; ++frame) {
    if (const auto fault = fault_of(scene.camera(frame)))
      root.reject(fmt::format("frame {} of the path: {}", frame, *fault));
  }
}

std::vector<fs::path> scene_folders() {
  std::vector<fs::path> folders = project_folders();
  for (fs::path& folder : folders) folder = (folder / "configs" / "scenes").lexically_normal();
  return folders;
}

}  // namespace

gpu::Scene load_scene(const std::string& path) {
  gpu::Scene scene;
  scene.name = fs::path(path).stem().string();
  std::vector<gpu::Camera> keys;
  std::optional<YamlValue> held;
  const YamlValue root = YamlValue::from_file(path);
  root.fields({
      {"title", [&](const YamlValue& v) { scene.title = v.text("a title"); }, true},
      {"keys",
       [&](const YamlValue& v) {
         for (const YamlValue& one : v.list("cameras")) keys.push_back(read_key(one));
       },
       true},
      {"frames",
       [&](const YamlValue& v) {
         scene.frames = scene.path_frames = static_cast<std::uint32_t>(v.integer(1, 1000000));
       }},
      {"held", [&](const YamlValue& v) { held = v; }},
      {"size", [&](const YamlValue& v) { read_size(v, scene); }},
      {"materials",
       [&](const YamlValue& v) {
         for (const YamlValue& one : v.list("materials"))
           scene.materials.push_back(read_material(one));
       }},
      {"transfer",
       [&](const YamlValue& v) {
         for (const YamlValue& one : v.list("points")) read_transfer_point(one, scene.transfer);
       }},
      {"slice_samples",
       [&](const YamlValue& v) {
         scene.slice_samples = static_cast<std::uint32_t>(v.integer(1, kMostSliceSamples));
       }},
      {"shading", [&](const YamlValue& v) { scene.shading = read_shading(v); }},
      {"light", [&](const YamlValue& v) { scene.light = read_direction(v); }},
      {"ambient", [&](const YamlValue& v) { scene.ambient = v.number(0, 1); }},
      {"ao_distance", [&](const YamlValue& v) { scene.ao_distance = v.number(1e-6, kFarthest); }},
      {"lod_bias", [&](const YamlValue& v) { scene.lod_bias = v.number(-32, 32); }},
      {"accumulate",
       [&](const YamlValue& v) {
         scene.accumulate = static_cast<std::uint32_t>(v.integer(1, 1000000));
       }},
      {"background", [&](const YamlValue& v) { scene.background = read_colour(v); }},
  });
  if (held) scene.held = static_cast<std::uint32_t>(held->integer(0, keys.size() - 1));
  if (scene.materials.empty() && scene.transfer.empty())
    root.reject("expected the key materials (of labels) or transfer (of scalars), found neither");
  scene.path = gpu::CameraPath(std::move(keys));
  check_path(scene, root);
  return scene;
}

std::string find_scene(const std::string& name_or_path, const std::string& folder) {
  std::error_code error;
  const fs::path file = fs::path(folder) / name_or_path;
  if (!name_or_path.empty() && fs::is_regular_file(file, error)) return file.string();
  if (fs::is_directory(file, error) && !name_or_path.empty())
    throw InputError(fmt::format("{}: expected a scene file, found a folder", file.string()));
  std::vector<std::string> names;
  for (const fs::path& known : scene_folders()) {
    const fs::path path = known / (name_or_path + ".yaml");
    if (fs::is_regular_file(path, error)) return path.string();
    for (const auto& entry : fs::directory_iterator(known, error)) {
      if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
    }
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  throw InputError(fmt::format("{}: expected a scene file or one of the scenes {}, found none{}",
                               name_or_path, fmt::join(names, ", "),
                               did_you_mean(name_or_path, names)));
}

}  // namespace cvr::experiments
