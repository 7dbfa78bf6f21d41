// Scene files: what is drawn, from where, with which light.
//
//   title: TEXT
//   keys:                      camera on its way; one key stands still
//     - {eye: [x, y, z], target: [0, 0, 0], up: [0, 1, 0], fov: 45}       eye is required; scene space (gpu/IMAGE.md);
//                                                                        fov is vertical, in
//                                                                        degrees
//   frames: 64                 of the path
//   held: 0                    number of the key, from 0, where the camera stands still for held frames
//   size: [640, 360]           of the picture in pixels
//   materials:                 the first rule that fits a label counts; a label that none fits is invisible
//     - labels: all | N | [FIRST, LAST]        both included; default all
//       modulus: 1   remainder: 0              only labels with label % modulus == remainder
//       opacity: 1                             0 invisible .. 1; above 0.978 a surface
//       colour: [r, g, b]                      0 .. 255; default: a bright colour derived from the label
//   transfer:                  of scalar volumes: points of ascending value, linear between them
//     - {value: 0.3, colour: [r, g, b], density: 0}     value: 0 .. 1 of the volume's range (of 0 .. 255 for u8); density: extinction a
//                                                        world unit, from 0
//   slice_samples: 1           sample planes between two slices of a scalar volume
//   shading: local | shadow | ao               default local
//   light: [0.4, 0.8, 0.45]    towards the light; of any length but 0
//   ambient: 0.35              0 .. 1
//   ao_distance: 0.1           in parts of the volume's longest edge
//   lod_bias: 0                levels; positive is coarser
//   accumulate: 1              frames drawn of each camera and averaged
//   background: [255, 255, 255]
//
// title, keys and materials or transfer are required. Anything else is an error with its line and
// column.
#pragma once

#include <string>

#include "gpu/scene.hpp"

namespace cvr::experiments {

/// Reads a scene; its name is that of the file without the ending. Throws InputError.
gpu::Scene load_scene(const std::string& path);

/// The path of a scene: `name_or_path` if it names a file (a relative one from `folder`, "" being
/// the current one), else configs/scenes/NAME.yaml below the first of project_folders() that has
/// it. Throws InputError, naming the scenes that there are.
std::string find_scene(const std::string& name_or_path, const std::string& folder = "");

}  // namespace cvr::experiments
