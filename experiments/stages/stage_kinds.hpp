// The stages of this build; make_stage_run chooses among them.
#pragma once

#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

std::unique_ptr<StageRun> make_encode_run(const WorkerSpec& spec,
                                          const volumes::VolumeSource& truth);
std::unique_ptr<StageRun> make_decode_run(const WorkerSpec& spec,
                                          const volumes::VolumeSource& truth);
std::unique_ptr<StageRun> make_random_access_run(const WorkerSpec& spec,
                                                 const volumes::VolumeSource& truth);
std::unique_ptr<StageRun> make_render_run(const WorkerSpec& spec,
                                          const volumes::VolumeSource& truth);
std::unique_ptr<StageRun> make_scalar_render_run(const WorkerSpec& spec,
                                                 const volumes::VolumeSource& truth);
std::unique_ptr<StageRun> make_memcpy_run(const WorkerSpec& spec,
                                          const volumes::VolumeSource& truth);

}  // namespace cvr::experiments
