// The generators behind the table in generator.cpp: each file of a kind declares its description
// and makes its source.
#pragma once

#include <memory>

#include "volumes/generators/tiled_source.hpp"

namespace cvr::volumes {

extern const GeneratorInfo kCellsInfo, kFibersInfo, kNeuritesInfo, kAtlasInfo, kWorstCaseInfo;
extern const GeneratorInfo kTurbulenceInfo, kShellsInfo, kMarschnerLobbInfo, kMovingInfo;

std::unique_ptr<VolumeSource> make_cells(const GeneratorRequest& request);
std::unique_ptr<VolumeSource> make_fibers(const GeneratorRequest& request);
std::unique_ptr<VolumeSource> make_neurites(const GeneratorRequest& request);
std::unique_ptr<VolumeSource> make_atlas(const GeneratorRequest& request);
std::unique_ptr<VolumeSource> make_worst_case(const GeneratorRequest& request);
std::unique_ptr<VolumeSource> make_turbulence(const GeneratorRequest& request);
std::unique_ptr<VolumeSource> make_shells(const GeneratorRequest& request);
std::unique_ptr<VolumeSource> make_marschner_lobb(const GeneratorRequest& request);
std::unique_ptr<VolumeSource> make_moving(const GeneratorRequest& request);

}  // namespace cvr::volumes
