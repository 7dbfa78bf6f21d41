#include "experiments/config/render_choice.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <fstream>
#include <iterator>

#include "experiments/config/render_options.hpp"
#include "experiments/config/scene_file.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {

std::string RenderChoice::key() const {
  std::string text;
  for (const RenderOption& option : render_options()) text += option.in_cell_key(*this);
  return text;
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
  for (const RenderOption& option : render_options()) {
    if (!option.label.empty() && option.label == name) return option.text(*this);
  }
  return std::nullopt;
}

Row to_row(const RenderChoice& choice) {
  Row row;
  for (const RenderOption& option : render_options()) option.to_row(choice, row);
  return row;
}

RenderChoice render_choice_from_row(const Row& row) {
  RenderChoice choice;
  for (const RenderOption& option : render_options()) option.from_row(row, choice);
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
  scene.ao_roulette = choice.ao_roulette;
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
