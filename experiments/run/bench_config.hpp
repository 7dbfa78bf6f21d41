// The configuration that `cvrbench bench` measures volume files by: every codec that takes a volume,
// one thread, then images of one codec by every access mode. It is written as a file, so that what
// was measured can be read, changed and measured again.
#pragma once

#include <string>
#include <vector>

#include "experiments/results/result.hpp"
#include "volumes/io/io.hpp"

namespace cvr::experiments {

struct BenchVolume {
  std::string file;  ///< as the readers take it; absolute
  std::string name;  ///< in tables
  volumes::OpenOptions options;
  volumes::VolumeInfo info;
  std::string drawn_codec;  ///< whose images are measured; empty: none
};

/// Opens a file for what it holds. Throws InputError.
BenchVolume open_for_bench(const std::string& file, const volumes::OpenOptions& options);

/// The codec whose images tell most: of a label volume the smallest file with access to single
/// voxels; of scalars the smallest of the lossy ones that keep 40 dB, else the one with the highest
/// PSNR. "" where no row that is ok has one.
std::string codec_to_draw(const BenchVolume& volume, const std::vector<Result>& rows);

/// How many cells the configuration of such volumes has without images.
std::size_t bench_cells(const std::vector<BenchVolume>& volumes);

/// The text of the configuration. `timeout`: seconds of a cell.
std::string bench_config(const std::vector<BenchVolume>& volumes, double timeout);

}  // namespace cvr::experiments
