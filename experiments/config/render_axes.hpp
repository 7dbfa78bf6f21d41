// The keys of a matrix block that concern the render stage, and the choices that they multiply to.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "codecs/parameters.hpp"
#include "experiments/config/render_choice.hpp"
#include "experiments/config/yaml_reader.hpp"
#include "gpu/scene.hpp"
#include "volumes/volume.hpp"

namespace cvr::experiments {

class RenderAxes {
 public:
  /// Readers of the keys; this object outlives them. `config_path`: what paths of scenes are
  /// relative to.
  std::vector<YamlValue::Field> fields(const std::string& config_path);
  /// After all fields: with the render stage scenes and caches must be there, without it no key may
  /// be. Throws InputError.
  void check(const YamlValue& block, bool renders) const;
  /// Scenes first, caches last. `parameters`: where the codec's own edge of a brick stands, if it
  /// has one. `kind`: of the volume, whose access modes "all" means.
  std::vector<RenderChoice> choices(const codecs::Parameters& parameters, volumes::VolumeKind kind,
                                    const std::string& device) const;

 private:
  struct SceneChoice {
    std::string name, path, hash;
    gpu::Scene scene;
  };
  RenderChoice make(const SceneChoice& scene, const std::string& access, gpu::Shading shading,
                    std::uint64_t cache_mib, double lod_bias, std::uint32_t samples) const;

  std::vector<std::string> given_;  ///< keys that the block has
  std::vector<SceneChoice> scenes_;
  std::vector<std::string> caches_;
  bool every_cache_ = false;
  std::vector<gpu::Shading> shadings_;  ///< empty: the scene's own
  std::vector<std::uint64_t> cache_mib_{256};
  std::vector<double> lod_bias_;  ///< empty: the scene's own
  std::vector<std::uint32_t> ao_samples_{1};
  std::vector<std::optional<std::uint32_t>> steps_;  ///< empty: whole encodings
  std::optional<std::pair<std::uint32_t, std::uint32_t>> size_;
  std::optional<std::uint32_t> frames_;
  std::uint32_t brick_ = 32, jump_frames_ = 0, held_frames_ = 0;
  std::uint32_t path_parts_ = 0;
  bool count_path_ = true, picture_error_ = false, keep_pictures_ = false;
};

}  // namespace cvr::experiments
