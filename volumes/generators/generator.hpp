// Deterministic generators of volumes: the same kind, extent, seed and parameters give the same
// bytes on any machine, for any box and any number of threads. Any box can be generated without the
// rest.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "volumes/source.hpp"

namespace cvr::volumes {

struct GeneratorParameter {
  std::string_view name;
  double default_value;
  double minimum, maximum;
  std::string_view description;
  bool whole = false;  ///< takes whole numbers only
};

struct GeneratorInfo {
  std::string_view kind;  ///< "cells", "fibers", "neurites", "atlas", "worst-case", ...
  std::string_view summary;
  VolumeKind volume_kind;
  Extent default_extent;  ///< non-cubic
  Extent paper_extent;    ///< of the data set it stands in for; 0x0x0 if none
  std::span<const GeneratorParameter> parameters;
};

/// All generators of this build.
std::span<const GeneratorInfo> all_generators();

/// A source that makes voxels on demand, on `threads` threads a read. Throws InputError on an
/// unknown kind or parameter, or a value out of range, naming what is allowed.
std::unique_ptr<VolumeSource> make_generator(std::string_view kind, const Extent& extent,
                                             std::uint64_t seed,
                                             const std::map<std::string, double>& parameters,
                                             unsigned threads);

}  // namespace cvr::volumes
