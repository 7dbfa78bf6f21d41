// What a cell of the stage render adds to a cell: the scene, how labels are reached, how they are
// shaded. Each of these options is described once, in render_options.cpp.
//
// All values that an image or its time depends on stand here once the configuration is read: those
// that the configuration leaves out are taken from the scene. What does not matter for a cell (the
// cache size of a mode without a cache, the number of samples of a shading without random rays) has
// one value, so that no cell is measured twice.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "experiments/results/rows.hpp"
#include "gpu/scene.hpp"

namespace cvr::experiments {

struct RenderChoice {
  std::string scene;       ///< as the configuration names it
  std::string scene_path;  ///< of its file
  std::string scene_hash;  ///< XXH3-64 of the file, 16 hexadecimal digits
  std::string access;      ///< id of an access mode
  gpu::Shading shading = gpu::Shading::kLocal;
  std::uint64_t cache_mib = 256;  ///< 0 where the mode has no cache
  std::uint32_t width = 0, height = 0;
  std::uint32_t frames = 0;  ///< of the camera path
  double lod_bias = 0;
  std::uint32_t ao_samples = 1;       ///< frames drawn of each camera and averaged
  std::uint32_t brick = 32;           ///< brick size that the codec has, or is given
  std::uint32_t jump_frames = 0;      ///< frames compared after a camera jump; 0: none
  std::uint32_t warm_frames = 0;      ///< timed of the scene's fixed view; 0: none
  bool image_error = false;           ///< compare with the image of level bias 0 and many samples
  std::optional<std::uint32_t> step;  ///< progressive step that is drawn; none: the whole encoding
  bool keep_images = false;           ///< leave the image of the fixed view in the results
  bool ao_roulette = false;           ///< see gpu::Scene
  std::uint32_t path_parts = 0;       ///< see gpu::Scene
  bool count_path = true;             ///< draw the path once more by kernels that count
  std::string device;                 ///< as the user names it; empty: the renderer's own choice
  bool operator==(const RenderChoice&) const = default;

  /// All but the device and the scene's contents: names the cell in tables.
  std::string key() const;
  /// key(), device and scene contents: what else makes a measurement another one.
  std::string identity() const;
  /// "scene fiber, voxel 256 MiB, shadow, 480x270".
  std::string describe() const;
  /// The value under one of the names that tables, filters and conditions know; nothing for others.
  std::optional<std::string> label(std::string_view name) const;
};

Row to_row(const RenderChoice& choice);
/// Throws std::exception on anything malformed.
RenderChoice render_choice_from_row(const Row& row);

/// Reads the scene's file and puts the choice's values in place of its own. Throws InputError.
gpu::Scene scene_of(const RenderChoice& choice);
/// XXH3-64 of a file's bytes. Throws InputError.
std::string hash_of_file(const std::string& path);

}  // namespace cvr::experiments
