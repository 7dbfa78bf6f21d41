#include "experiments/config/render_choice.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <fstream>
#include <iterator>

#include "experiments/config/scene_file.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {

namespace {

std::string step_text(const RenderChoice& choice) {
  return choice.step ? std::to_string(*choice.step) : "";
}

std::string cache_text(const RenderChoice& choice) {
  return choice.cache_mib == 0 ? "" : std::to_string(choice.cache_mib);
}

}  // namespace

std::string RenderChoice::key() const {
  return fmt::format(
      "{}|{}|{}|cache={}|{}x{}|frames={}|lod_bias={}|ao_samples={}|brick={}|jump={}|held={}|error={"
      "}{}{}{}{}",
      scene, access, gpu::name_of(shading), cache_text(*this), width, height, frames, lod_bias,
      ao_samples, brick, jump_frames, held_frames, picture_error ? 1 : 0,
      step ? fmt::format("|step={}", *step) : "", keep_pictures ? "|pictures=1" : "",
      path_parts > 0 ? fmt::format("|parts={}", path_parts) : "", count_path ? "" : "|count=0");
}

std::string RenderChoice::identity() const {
  return fmt::format("{}|scene={}|device={}", key(), scene_hash, device);
}

std::string RenderChoice::describe() const {
  std::string text = fmt::format("scene {}, {}{}, {}, {}x{}", scene, access,
                                 cache_mib == 0 ? "" : fmt::format(" {} MiB", cache_mib),
                                 gpu::name_of(shading), width, height);
  if (lod_bias != 0) text += fmt::format(", lod bias {}", lod_bias);
  if (ao_samples > 1) text += fmt::format(", {} samples", ao_samples);
  if (step) text += fmt::format(", step {}", *step);
  return text;
}

std::optional<std::string> RenderChoice::label(std::string_view name) const {
  if (name == "scene") return scene;
  if (name == "cache") return access;
  if (name == "shading") return std::string(gpu::name_of(shading));
  if (name == "cache_mib") return cache_text(*this);
  if (name == "lod_bias") return fmt::format("{}", lod_bias);
  if (name == "ao_samples") return std::to_string(ao_samples);
  if (name == "size") return fmt::format("{}x{}", width, height);
  if (name == "frames") return std::to_string(frames);
  if (name == "step") return step_text(*this);
  return std::nullopt;
}

Row to_row(const RenderChoice& choice) {
  Row row;
  row["scene"] = choice.scene;
  row["scene_path"] = choice.scene_path;
  row["scene_hash"] = choice.scene_hash;
  row["cache"] = choice.access;
  row["shading"] = gpu::name_of(choice.shading);
  row["cache_mib"] = choice.cache_mib;
  row["size"] = {choice.width, choice.height};
  row["frames"] = choice.frames;
  if (choice.path_parts > 0) row["path_parts"] = choice.path_parts;
  if (!choice.count_path) row["count_path"] = false;
  row["lod_bias"] = choice.lod_bias;
  row["ao_samples"] = choice.ao_samples;
  row["brick"] = choice.brick;
  row["jump_frames"] = choice.jump_frames;
  row["held_frames"] = choice.held_frames;
  if (choice.step) row["step"] = *choice.step;
  row["picture_error"] = choice.picture_error;
  row["keep_pictures"] = choice.keep_pictures;
  row["device"] = choice.device;
  return row;
}

RenderChoice render_choice_from_row(const Row& row) {
  RenderChoice choice;
  choice.scene = row.at("scene").get<std::string>();
  choice.scene_path = row.at("scene_path").get<std::string>();
  choice.scene_hash = row.at("scene_hash").get<std::string>();
  choice.access = row.at("cache").get<std::string>();
  choice.shading = gpu::shading_from_name(row.at("shading").get<std::string>()).value();
  choice.cache_mib = row.at("cache_mib").get<std::uint64_t>();
  choice.width = row.at("size").at(0).get<std::uint32_t>();
  choice.height = row.at("size").at(1).get<std::uint32_t>();
  choice.frames = row.at("frames").get<std::uint32_t>();
  choice.lod_bias = row.at("lod_bias").get<double>();
  choice.ao_samples = row.at("ao_samples").get<std::uint32_t>();
  choice.brick = row.at("brick").get<std::uint32_t>();
  choice.jump_frames = row.at("jump_frames").get<std::uint32_t>();
  choice.held_frames = row.at("held_frames").get<std::uint32_t>();
  if (row.contains("step")) choice.step = row["step"].get<std::uint32_t>();
  choice.path_parts = row.value("path_parts", 0u);
  choice.count_path = row.value("count_path", true);
  choice.picture_error = row.at("picture_error").get<bool>();
  choice.keep_pictures = row.at("keep_pictures").get<bool>();
  choice.device = row.at("device").get<std::string>();
  return choice;
}

gpu::Scene scene_of(const RenderChoice& choice) {
  gpu::Scene scene = load_scene(choice.scene_path);
  scene.shading = choice.shading;
  scene.width = choice.width;
  scene.height = choice.height;
  scene.frames = choice.frames;
  scene.path_parts = choice.path_parts;
  scene.lod_bias = choice.lod_bias;
  scene.accumulate = choice.ao_samples;
  return scene;
}

std::string hash_of_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw volumes::InputError(fmt::format("{}: expected a readable file, found none", path));
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  return fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()));
}

}  // namespace cvr::experiments
