// A configuration: what is measured, how long, and which tables are made of it.
//
//   title: text
//   scale: edge factor of all generated volumes (overrides the data sets' own)
//   rounds: 9                  least number
//   max_rounds: 3 x rounds
//   target_interval: 0.05      width of the 95 % interval of the median / median at which a cell is done
//   timeout_s: 120             of a cell: its check, and all its rounds; a single step that takes longer is killed
//   together: N                most cells whose rounds are interleaved; default: as many as the memory holds. 1: each cell alone, and its row
//                              is there before the next begins
//   memory_limit_gib: 16       of a worker process, beyond the mapped input
//   seed: 1                    of the order of the rounds and of the points of random access
//   lods: all | [0, 1]         levels of detail of random access
//   device: TEXT               that draws: an index or a part of a name or type ('list devices'); default: the renderer's choice
//   matrix:                    a list of blocks; the cells are the union of their products
//     - datasets: [NAME, {name: NAME, scale: 0.3, extent: [x, y, z], bytes_per_voxel: 4,
//       exchange_axes: 1,
//                   axes: zyx, allow_external: true},      the last two of files, in place of what the catalogue says of them
//                  {generator: KIND, extent: [x, y, z], seed: 1, parameters: {..}, name: NAME}]
//       codecs: all | lossless | lossy | [ID, {id: ID, parameters: {NAME: VALUE or [VALUES]}}]      a list of values multiplies the cells
//       stages: [encode, decode, random-access, render]
//       threads: [1, all]      default [1]; not of the stage render
//       of the stage render:
//       steps: [0, 1, 2, 3]    progressive steps of lossy codecs that are drawn, the last of them the whole; default: the whole
//       scenes: [NAME]         files of configs/scenes, or paths from here      caches: all | [none, voxel, ...]   'list caches'
//       shadings: [local, shadow, ao]      default: the scene's own             cache_mib: 256 or a list
//       lod_bias: 0 or a list  default: the scene's own                         ao_samples: 1 or a list; frames a camera, averaged
//       size: [W, H]   frames: N           default: the scene's own             brick: 32, of codecs without bricks of their own
//       path_parts: 4          of the scene's own path so many evenly spaced parts of consecutive frames, `frames` together, so that a short
//                              run moves as slowly as a long one; default 0: `frames` spread over
//                              the whole path
//       count_path: 0          do not draw the path once more by kernels that count; default 1
//       jump_frames: 8         frames compared with the truth after a camera jump; default none
//       held_frames: 5         0 .. 1000 frames of the scene's held view, timed in each round after the path once the picture is exact and
//                              the cache filled; each is drawn anew as a first frame is; default 0,
//                              none
//       picture_error: 1       compare pictures with those of level bias 0 and 256 samples; default 0
//       keep_pictures: 1       leave the picture of the held view, and eight times its difference to that of the original volume by the
//                              reference renderer, as PNG in OUT/pictures; default 0
//   tables:
//     - name: NAME   title: TEXT   rows: [dataset, codec, ...]   columns: [METRIC, ...]
//       where: {LABEL: GLOB or [GLOBS]}          published: {file: PATH beside this file, table: NAME}
//       A table that names scene, cache, shading, cache_mib, lod_bias, ao_samples, size or frames
//       is about cells of the stage
//       render, any other about the rest.
//       bd_psnr: "zfp rate"    in place of `columns`: lines that agree in `rows` are a curve of PSNR over bits a voxel, and each curve
//                              is compared with the one whose labels but the data set are these
//       pivot: {columns: [LABEL, ...], metric: METRIC}      in place of `columns`: one column for each combination of the labels,
//                                                           each cell "measured (published)"
//   claims:                    what papers say of these cells, each to be confirmed or refuted: claim_spec.hpp
//   test_fault: {fault: crash|hang|oom|mismatch|device-lost, codec: GLOB, stage: GLOB}      breaks workers on purpose, for tests
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/config/cells.hpp"
#include "experiments/config/claim_spec.hpp"
#include "experiments/config/datasets.hpp"
#include "experiments/config/metric_names.hpp"

namespace cvr::experiments {

/// Spreads one metric over columns.
struct Pivot {
  std::vector<std::string> columns;  ///< labels whose combinations become columns
  std::string metric;
};

struct TableSpec {
  std::string name, title;
  std::vector<std::string>
      rows;  ///< what labels a line: dataset, extent, type, codec, parameters, threads, or a parameter of a codec
  std::vector<std::string> columns;  ///< names of metrics
  Conditions where;
  std::optional<PublishedPlace> published;
  std::optional<Pivot> pivot;
  std::string
      bd_reference;  ///< labels of the curve that others are compared with; empty: no table of curves

  /// Whether it is about cells of the render stage.
  bool renders() const;
};

struct TestFault {
  std::string fault, codec = "*", stage = "*";
};

struct Config {
  std::string path, hash, title;
  std::optional<double> scale;
  std::uint64_t rounds = 9, max_rounds = 0;
  double target_interval = 0.05;
  double timeout_s = 120;
  double memory_limit_gib = 16;
  std::uint64_t together = UINT64_MAX;
  std::uint64_t seed = 1;
  std::vector<unsigned> lods;  ///< empty: all
  std::string device;          ///< of the render stage; empty: the renderer's choice
  std::vector<Cell>
      cells;  ///< memcpy first for each data set, stage and number of threads; each cell once
  std::vector<TableSpec> tables;
  std::vector<ClaimSpec> claims;
  std::optional<TestFault> test_fault;
};

/// Reads a configuration; `settings` are "key=value" for its top-level keys with simple values and
/// win over the file. `metrics`: what its tables and claims may name. Throws InputError.
Config read_config(const std::string& path, const Catalogue& catalogue,
                   const std::vector<std::string>& settings, MetricNames metrics);

/// Another device in place of the one that the configuration names.
void choose_device(Config& config, const std::string& device);

}  // namespace cvr::experiments
