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

double length(const gpu::Vector3& a) { return std::hypot(a[0], a[1], a[2]); }

Shape<gpu::Vector3> vector_shape() {
  return exactly<3>(real_number(-kFarthest, kFarthest), "three numbers [x, y, z]");
}

Shape<gpu::Vector3> direction_shape() {
  auto shape = vector_shape();
  shape.read = [read = shape.read](const YamlValue& value) {
    const gpu::Vector3 vector = read(value);
    if (length(vector) == 0)
      value.reject("expected a vector other than [0, 0, 0], found [0, 0, 0]");
    return vector;
  };
  shape.values += " of any length but 0";
  return shape;
}

Shape<std::array<std::uint8_t, 3>> colour_shape() {
  const auto channels = exactly<3>(whole_number(0, 255), "three channels [r, g, b]");
  return {[read = channels.read](const YamlValue& value) {
            const auto read_channels = read(value);
            std::array<std::uint8_t, 3> colour;
            for (std::size_t i = 0; i < 3; ++i)
              colour[i] = static_cast<std::uint8_t>(read_channels[i]);
            return colour;
          },
          channels.values + ", each 0 to 255", channels.schema};
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

gpu::Camera read_camera(const YamlValue& value) {
  gpu::Camera camera;
  read_keys(value, camera_keys(), camera);
  if (const auto fault = fault_of(camera)) value.reject(*fault);
  return camera;
}

struct LabelRange {
  std::uint64_t first = 0, last = UINT64_MAX;
};

Shape<LabelRange> labels_shape() {
  const char* const words = "all, a label, or [FIRST, LAST]";
  return {
      [words](const YamlValue& value) -> LabelRange {
        if (value.is_list()) {
          const auto ends = value.list("the first and the last label");
          if (ends.size() != 2) value.expected("[FIRST, LAST]");
          const std::uint64_t first = ends[0].integer(0, UINT64_MAX);
          return {first, ends[1].integer(first, UINT64_MAX)};
        }
        const std::string text = value.text(words);
        if (text == "all") return {};
        if (text.empty() || !std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; }))
          value.expected(words);
        const std::uint64_t label = value.integer(0, UINT64_MAX);
        return {label, label};
      },
      words,
      schema_of_either(R"({"const": "all"})",
                       schema_of_either(R"({"type": "integer", "minimum": 0})",
                                        schema_of_list(R"({"type": "integer"})", 2, 2)))};
}

gpu::MaterialRule read_material(const YamlValue& value) {
  gpu::MaterialRule rule;
  read_keys(value, material_keys(), rule);
  if (rule.remainder >= rule.modulus) {
    value.reject(fmt::format("expected a remainder below the modulus {}, found {}", rule.modulus,
                             rule.remainder));
  }
  return rule;
}

std::vector<gpu::TransferPoint> read_transfer(const YamlValue& value) {
  std::vector<gpu::TransferPoint> points;
  for (const YamlValue& one : value.list("points")) {
    gpu::TransferPoint point;
    read_keys(one, transfer_keys(), point);
    if (!points.empty() && point.value <= points.back().value)
      one.reject(fmt::format("expected a value above that of the point before, {}, found {}",
                             points.back().value, point.value));
    points.push_back(point);
  }
  return points;
}

/// A key of the scene itself.
template <class T, class M>
Key<SceneDraft> scene_key(std::string name, M gpu::Scene::*member, const Shape<T>& shape,
                          std::string fallback, std::string sentence) {
  return key<SceneDraft>(
      std::move(name), shape,
      [member](SceneDraft& d, T value) { d.scene.*member = static_cast<M>(std::move(value)); },
      std::move(fallback), std::move(sentence));
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

Shape<gpu::Shading> shading_shape(std::string words) {
  std::vector<std::string> names;
  for (const gpu::Shading known : gpu::kShadings) names.emplace_back(gpu::name_of(known));
  return named(gpu::shading_from_name, std::move(names), std::move(words));
}

std::vector<Key<gpu::Camera>> camera_keys() {
  using C = gpu::Camera;
  return {required(key("eye", &C::eye, vector_shape(), "", "In scene space (gpu/IMAGE.md).")),
          key("target", &C::target, vector_shape(), "[0, 0, 0]", "What the camera looks at."),
          key("up", &C::up, direction_shape(), "[0, 1, 0]", "Not parallel to the view."),
          key("fov", &C::vertical_fov_degrees, real_number(0.01, 179), "45",
              "Vertical field of view in degrees.")};
}

std::vector<Key<gpu::MaterialRule>> material_keys() {
  using M = gpu::MaterialRule;
  return {
      key<M>(
          "labels", labels_shape(),
          [](M& rule, LabelRange range) {
            rule.first = range.first;
            rule.last = range.last;
          },
          "all", "The labels that the rule is about, both ends included."),
      key("modulus", &M::modulus, whole_number(1, UINT64_MAX), "1",
          "Only labels with label % modulus == remainder."),
      key("remainder", &M::remainder, whole_number(0, UINT64_MAX - 1), "0", "Below the modulus."),
      key("opacity", &M::opacity, real_number(0, 1), "1", "0 invisible; above 0.978 a surface."),
      key("colour", &M::colour, colour_shape(), "a bright colour derived from the label", "")};
}

std::vector<Key<gpu::TransferPoint>> transfer_keys() {
  using P = gpu::TransferPoint;
  return {required(key("value", &P::value, real_number(0, 1), "",
                       "Part of the volume's range (of 0 to 255 for u8), ascending.")),
          required(key("colour", &P::colour, colour_shape(), "", "")),
          required(key("density", &P::density, real_number(0, kFarthest), "",
                       "Extinction per world unit."))};
}

std::vector<Key<SceneDraft>> scene_keys() {
  using D = SceneDraft;
  using S = gpu::Scene;
  const auto cameras = list_of(
      Shape<gpu::Camera>{read_camera, "a map", schema_of_map(infos_of(camera_keys()))}, "cameras");
  const auto materials = list_of(
      Shape<gpu::MaterialRule>{read_material, "a map", schema_of_map(infos_of(material_keys()))},
      "materials");
  const Shape<std::vector<gpu::TransferPoint>> transfer{
      read_transfer, "a list of points", schema_of_list(schema_of_map(infos_of(transfer_keys())))};
  const Shape<YamlValue> camera_number{[](const YamlValue& value) { return value; },
                                       "a number from 0", R"({"type": "integer", "minimum": 0})"};
  return {
      required(scene_key("title", &S::title, one_text("a title"), "", "")),
      required(key("keys", &D::cameras, cameras, "",
                   "Cameras on the path, with a smooth way between them; one stands still.")),
      key<D>(
          "frames", whole_number(1, 1000000),
          [](D& d, std::uint64_t frames) {
            d.scene.frames = d.scene.path_frames = static_cast<std::uint32_t>(frames);
          },
          "64", "Frames of the path."),
      key("fixed_view", &D::fixed, camera_number, "0",
          "Number of the camera, from 0, that is the fixed view of warm frames."),
      key<D>(
          "size", exactly<2>(whole_number(1, kMaxSide), "two sides [WIDTH, HEIGHT]"),
          [](D& d, std::array<std::uint64_t, 2> sides) {
            d.scene.width = static_cast<std::uint32_t>(sides[0]);
            d.scene.height = static_cast<std::uint32_t>(sides[1]);
          },
          "[640, 360]", "Of the image, in pixels."),
      scene_key("materials", &S::materials, materials, "",
                "Of labels: the first rule that fits counts; a label that none fits is invisible. "
                "A scene has materials, a transfer function or both."),
      scene_key("transfer", &S::transfer, transfer, "",
                "Of scalars: points of a transfer function, linear between them."),
      scene_key("slice_samples", &S::slice_samples, whole_number(1, kMostSliceSamples), "1",
                "Sample planes between two slices of a scalar volume."),
      scene_key("shading", &S::shading, shading_shape("local, shadow or ao"), "local",
                "How labels are shaded."),
      scene_key("light", &S::light, direction_shape(), "[0.4, 0.8, 0.45]", "Towards the light."),
      scene_key("ambient", &S::ambient, real_number(0, 1), "0.35", "Light from everywhere."),
      scene_key("ao_distance", &S::ao_distance, real_number(1e-6, kFarthest), "0.1",
                "Length of ambient occlusion rays in parts of the volume's longest side."),
      scene_key("ao_roulette", &S::ao_roulette, zero_or_one(), "0",
                "1 casts rays of ambient occlusion by Russian roulette: with the probability of "
                "the surface's largest colour component, and each counts for as many more."),
      scene_key("lod_bias", &S::lod_bias, real_number(-32, 32), "0",
                "Added to each level of detail; positive is coarser."),
      scene_key("accumulate", &S::accumulate, whole_number(1, 1000000), "1",
                "Frames drawn of each camera and averaged."),
      scene_key("background", &S::background, colour_shape(), "[255, 255, 255]", ""),
  };
}

gpu::Scene load_scene(const std::string& path) {
  SceneDraft draft;
  const YamlValue root = YamlValue::from_file(path);
  read_keys(root, scene_keys(), draft);
  gpu::Scene scene = std::move(draft.scene);
  scene.name = fs::path(path).stem().string();
  if (draft.fixed)
    scene.held = static_cast<std::uint32_t>(draft.fixed->integer(0, draft.cameras.size() - 1));
  if (scene.materials.empty() && scene.transfer.empty())
    root.reject("expected the key materials (of labels) or transfer (of scalars), found neither");
  scene.path = gpu::CameraPath(std::move(draft.cameras));
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
