// Scene files: what is drawn, from where, with which light. docs/config.md lists the keys.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/config/keys.hpp"
#include "gpu/scene.hpp"

namespace cvr::experiments {

/// A scene as it is read.
struct SceneDraft {
  gpu::Scene scene;
  std::vector<gpu::Camera> cameras;
  std::optional<YamlValue> fixed;  ///< number of the camera of the fixed view, from 0
};
std::vector<Key<SceneDraft>> scene_keys();
std::vector<Key<gpu::Camera>> camera_keys();
std::vector<Key<gpu::MaterialRule>> material_keys();
std::vector<Key<gpu::TransferPoint>> transfer_keys();

/// "local", "shadow" or "ao"; `words` stand in errors.
Shape<gpu::Shading> shading_shape(std::string words);

/// Reads a scene; its name is that of the file without the ending. Throws InputError.
gpu::Scene load_scene(const std::string& path);

/// The path of a scene: `name_or_path` if it names a file (a relative one from `folder`, "" being
/// the current one), else configs/scenes/NAME.yaml below the first of project_folders() that has
/// it. Throws InputError, naming the scenes that there are.
std::string find_scene(const std::string& name_or_path, const std::string& folder = "");

}  // namespace cvr::experiments
