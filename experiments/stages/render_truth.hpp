// What the images of the render stage must be: those of the CPU reference, and those of the codec
// `raw` on the same device.
//
// The cells of one run share most of these images, so each is left in the run's scratch folder
// and made once, and so is what the comparison of raw's image with the reference has found.
// Reference and raw renderer are built when something is asked for that is not there.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "experiments/stages/render_errors.hpp"
#include "experiments/stages/render_parts.hpp"
#include "experiments/stages/stage.hpp"
#include "gpu/reference/reference.hpp"
#include "gpu/renderer.hpp"

namespace cvr::experiments {

class RenderTruth {
 public:
  /// All of them outlive this.
  RenderTruth(const WorkerSpec& spec, const volumes::VolumeSource& truth, const gpu::Scene& scene,
              gpu::Device& device);

  gpu::Image reference(const Shot& shot);
  gpu::NeededWork needed(const Shot& shot);
  /// Of `raw` with access `none`, settled; nothing where the device has no room for all voxels.
  std::optional<gpu::Image> raw(const Shot& shot);
  /// Of raw's image, which must be there, against the reference.
  ImageErrors errors_of_raw(const Shot& shot);
  /// Of another image against the reference.
  ImageErrors errors_of_image(const Shot& shot, const gpu::Image& found);

 private:
  gpu::Scene scene_at(const Shot& shot) const;
  const gpu::ReferenceRenderer& renderer();
  std::string file_of(const Shot& shot, const std::string& kind) const;
  void make_reference(const Shot& shot);
  bool has_room_for_raw() const;
  void make_raw_renderer();

  struct Drawn {
    gpu::Image image;
    gpu::NeededWork needed;
  };
  std::optional<Drawn> load(const std::string& file) const;
  void save(const std::string& file, const Drawn& drawn) const;

  const WorkerSpec& spec_;
  const volumes::VolumeSource& truth_;
  const gpu::Scene& scene_;
  gpu::Device& device_;
  std::optional<volumes::Volume> volume_;
  std::unique_ptr<gpu::ReferenceRenderer> reference_;
  std::unique_ptr<gpu::Renderer> raw_;
  std::string last_file_;  ///< of `last_`
  Drawn last_;
};

}  // namespace cvr::experiments
