// The table of all generators and the check of what is asked of them. A further generator, of
// labels or of scalars, is one file and one line in kTable.
#include "volumes/generators/generator.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/generators/kinds.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::volumes {

namespace {

struct Kind {
  const GeneratorInfo* info;
  std::unique_ptr<VolumeSource> (*make)(const GeneratorRequest&);
};

constexpr std::array kTable{
    Kind{&kCellsInfo, make_cells},          Kind{&kFibersInfo, make_fibers},
    Kind{&kNeuritesInfo, make_neurites},    Kind{&kAtlasInfo, make_atlas},
    Kind{&kWorstCaseInfo, make_worst_case}, Kind{&kTurbulenceInfo, make_turbulence},
    Kind{&kShellsInfo, make_shells},        Kind{&kMarschnerLobbInfo, make_marschner_lobb},
    Kind{&kMovingInfo, make_moving}};

constexpr std::uint64_t kLargestAxis = std::uint64_t{1} << 24;

void check_extent(std::string_view kind, const Extent& extent) {
  for (const std::uint64_t axis : {extent.x, extent.y, extent.z}) {
    if (axis < 1 || axis > kLargestAxis) {
      throw InputError(
          fmt::format("generator {}: extent: expected 1 to {} voxels per axis, found {}", kind,
                      kLargestAxis, to_string(extent)));
    }
  }
}

std::map<std::string, double, std::less<>> complete(
    const GeneratorInfo& info, const std::map<std::string, double>& parameters) {
  std::map<std::string, double, std::less<>> values;
  std::vector<std::string> names;
  for (const GeneratorParameter& declared : info.parameters) {
    values.emplace(declared.name, declared.default_value);
    names.emplace_back(declared.name);
  }
  for (const auto& [name, value] : parameters) {
    if (!values.contains(name)) {
      throw InputError(fmt::format("generator {}: parameter: expected one of {}, found {}{}",
                                   info.kind, fmt::join(names, ", "), name,
                                   did_you_mean(name, names)));
    }
    values[name] = value;
  }
  for (const GeneratorParameter& declared : info.parameters) {
    const double value = values.find(declared.name)->second;
    const bool in_range = value >= declared.minimum && value <= declared.maximum;  // false for NaN
    if (!in_range || (declared.whole && value != std::floor(value))) {
      throw InputError(fmt::format("generator {}: {}: expected {} from {} to {}, found {}",
                                   info.kind, declared.name,
                                   declared.whole ? "a whole number" : "a number", declared.minimum,
                                   declared.maximum, value));
    }
  }
  return values;
}

}  // namespace

std::span<const GeneratorInfo> all_generators() {
  static const auto infos = [] {
    std::vector<GeneratorInfo> list;
    for (const Kind& kind : kTable) list.push_back(*kind.info);
    return list;
  }();
  return infos;
}

std::unique_ptr<VolumeSource> make_generator(std::string_view kind, const Extent& extent,
                                             std::uint64_t seed,
                                             const std::map<std::string, double>& parameters,
                                             unsigned threads) {
  std::vector<std::string> kinds;
  for (const Kind& known : kTable) {
    kinds.emplace_back(known.info->kind);
    if (known.info->kind != kind) continue;
    check_extent(kind, extent);
    return known.make({extent, seed, complete(*known.info, parameters), threads});
  }
  throw InputError(fmt::format("generator: kind: expected one of {}, found {}{}",
                               fmt::join(kinds, ", "), kind, did_you_mean(kind, kinds)));
}

}  // namespace cvr::volumes
