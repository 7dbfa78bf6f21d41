#include "tests/golden/golden.hpp"

#include <algorithm>
#include <bit>

namespace cvr::golden {

using volumes::Coordinate;
using volumes::Extent;
using volumes::Volume;
using volumes::VolumeInfo;
using volumes::VolumeKind;
using volumes::VoxelType;

namespace {

samples::SampleVolume labels(std::string name, const Extent& extent, VoxelType type,
                             std::function<std::uint64_t(const Coordinate&)> label) {
  const VolumeInfo info{
      .extent = extent, .type = type, .voxel_size = {8, 8, 30}, .voxel_unit = "nm"};
  return {std::move(name), info,
          [info, label = std::move(label)] { return samples::make_labels(info, label); }};
}

/// A smooth bump with a step.
samples::SampleVolume bump(const Extent& extent) {
  const VolumeInfo info{
      .extent = extent, .type = VoxelType::kU8, .kind = VolumeKind::kScalars, .voxel_unit = {}};
  return {"bump_u8", info, [info] {
            return samples::make_labels(info, [](const Coordinate& c) {
              return c.x * (12 - c.x) + 5 * c.y + (c.z > 6 ? 90 : 0);
            });
          }};
}

/// The bump moves on by a voxel each step, and the last step is of one value.
samples::SampleVolume moving_bump(const Extent& step, std::uint64_t steps) {
  const VolumeInfo info{.extent = {step.x, step.y, step.z * steps},
                        .type = VoxelType::kU8,
                        .kind = VolumeKind::kScalars,
                        .voxel_unit = {},
                        .time_steps = steps};
  return {"moving_bump_u8", info, [info] {
            return samples::make_labels(
                info, [depth = info.step_extent().z, steps = info.time_steps](const Coordinate& c) {
                  const std::uint64_t t = c.z / depth, x = c.x + t;
                  return t + 1 == steps ? 200 : x * (14 - x) + 5 * c.y + (c.z % depth > 3 ? 90 : 0);
                });
          }};
}

/// Exact in float: no rounding that a compiler could do otherwise.
samples::SampleVolume scalars(const Extent& extent) {
  const VolumeInfo info{
      .extent = extent, .type = VoxelType::kF32, .kind = VolumeKind::kScalars, .voxel_unit = {}};
  return {"ramp_f32", info, [info] {
            Volume volume(info);
            std::uint32_t i = 0;
            for (float& value : volume.voxels<float>())
              value = static_cast<float>(i++ % 97) * 0.25f - 3.0f;
            return volume;
          }};
}

}  // namespace

const std::vector<GoldenVolume>& golden_volumes() {
  static const std::vector<GoldenVolume> kVolumes{
      {labels("cells_u16", {9, 7, 11}, VoxelType::kU16, samples::voronoi({9, 7, 11}, 12, 51)),
       12456754666963158427u},
      {labels("large_ids_u64", {5, 7, 6}, VoxelType::kU64,
              [](const Coordinate& c) {
                return samples::random_at(53, c.x / 2 + 3 * (c.y / 3) + 9 * (c.z / 4));
              }),
       11167188199133396875u},
      {labels("salted_sheets_u8", {15, 5, 13}, VoxelType::kU8,
              [](const Coordinate& c) {
                const std::uint64_t noise = samples::random_at(55, Extent{15, 5, 13}.index(c));
                return noise % 31 == 0 ? noise >> 32 : (c.x + c.y + c.z) / 4;
              }),
       8435225709312139446u},
      {scalars({6, 5, 7}), 17332617138253809566u},
      {bump({13, 9, 10}), 12330613574921646765u},
  };
  return kVolumes;
}

const GoldenVolume& golden_series() {
  static const GoldenVolume kSeries{moving_bump({9, 6, 5}, 4), 625177176782887204u};
  return kSeries;
}

bool knows_time(const codecs::Codec& codec) {
  return std::ranges::any_of(
      codec.parameters(), [](const codecs::ParameterSpec& spec) { return spec.name == "books"; });
}

codecs::Parameters golden_parameters(const codecs::Codec& codec,
                                     const std::vector<std::string>& given) {
  std::vector<std::string> assignments;
  for (const codecs::ParameterSpec& spec : codec.parameters()) {
    if (!spec.choices.empty())
      assignments.push_back(std::string(spec.name) + '=' + std::to_string(spec.choices[0]));
  }
  assignments.insert(assignments.end(), given.begin(), given.end());
  return codecs::Parameters::parse(codec.parameters(), assignments).value();
}

std::string golden_path(const codecs::Codec& codec, const GoldenVolume& volume,
                        const codecs::Parameters& parameters) {
  return std::string(CVR_SOURCE_DIR "/tests/golden/data/") + samples::test_name(codec, parameters) +
         '.' + volume.sample.name + ".cvr";
}

}  // namespace cvr::golden
