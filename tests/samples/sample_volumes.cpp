#include "tests/samples/sample_volumes.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

namespace cvr::samples {

using codecs::Codec;
using codecs::Parameters;
using codecs::ParameterSpec;
using codecs::ParameterType;
using volumes::Coordinate;
using volumes::Extent;
using volumes::Volume;
using volumes::VolumeInfo;
using volumes::VolumeKind;
using volumes::VoxelType;

namespace {

using Label = std::function<std::uint64_t(const Coordinate&)>;

VolumeInfo labels_info(const Extent& extent, VoxelType type) {
  return {.extent = extent,
          .type = type,
          .kind = VolumeKind::kLabels,
          .voxel_size = {4, 4, 40.5},
          .voxel_unit = "nm"};
}

SampleVolume labels(std::string name, const Extent& extent, VoxelType type, Label label) {
  const VolumeInfo info = labels_info(extent, type);
  return {std::move(name), info,
          [info, label = std::move(label)] { return make_labels(info, label); }};
}

template <class T>
SampleVolume scalars(std::string name, const Extent& extent, VoxelType type,
                     std::function<T(std::uint64_t index)> value, std::uint64_t time_steps = 1) {
  const VolumeInfo info{.extent = extent,
                        .type = type,
                        .kind = VolumeKind::kScalars,
                        .voxel_size = {0.5, 0.5, 1},
                        .voxel_unit = "mm",
                        .time_steps = time_steps};
  return {std::move(name), info, [info, value = std::move(value)] {
            Volume volume(info);
            const auto voxels = volume.voxels<T>();
            for (std::uint64_t i = 0; i < voxels.size(); ++i) voxels[i] = value(i);
            return volume;
          }};
}

void add_shapes(std::vector<SampleVolume>& all) {
  for (const VoxelType type : volumes::kLabelTypes) {
    all.push_back(labels("one_voxel_" + std::string(name_of(type)), {1, 1, 1}, type,
                         [](auto&) { return 200; }));
    const Extent blobs{24, 35, 29};
    all.push_back(
        labels("blobs_" + std::string(name_of(type)), blobs, type, voronoi(blobs, 90, 3)));
  }
  all.push_back(
      labels("line_of_130_u32", {1, 130, 1}, VoxelType::kU32, [](auto& c) { return c.y / 7; }));
  all.push_back(
      labels("plane_71x1x37_u16", {71, 1, 37}, VoxelType::kU16, voronoi({71, 1, 37}, 30, 5)));
  SampleVolume series =
      labels("series_of_3_u16", {9, 7, 15}, VoxelType::kU16, voronoi({9, 7, 15}, 20, 4));
  series.info.time_steps = 3;
  series.volume = [stack = series.volume, info = series.info] {
    Volume volume = stack();
    volume.info() = info;
    return volume;
  };
  all.push_back(std::move(series));
  all.push_back(labels("odd_sides_5x7x9_u16", {5, 7, 9}, VoxelType::kU16,
                       [](auto& c) { return c.x * c.y + c.z; }));
  all.push_back(labels("odd_sides_65x33x70_u32", {65, 33, 70}, VoxelType::kU32,
                       voronoi({65, 33, 70}, 200, 7)));
  all.push_back(labels("odd_sides_17x130x40_u16", {17, 130, 40}, VoxelType::kU16,
                       voronoi({17, 130, 40}, 900, 9)));
  // One voxel more than a brick on one axis, two bricks less one on another.
  all.push_back(
      labels("brick_part_outside_u8", {33, 63, 18}, VoxelType::kU8, voronoi({33, 63, 18}, 60, 11)));
}

void add_label_patterns(std::vector<SampleVolume>& all) {
  all.push_back(labels("one_label_u8", {40, 33, 35}, VoxelType::kU8, [](auto&) { return 255; }));
  all.push_back(labels("one_label_2pow64_minus_1_u64", {20, 33, 17}, VoxelType::kU64,
                       [](auto&) { return ~std::uint64_t{0}; }));
  all.push_back(labels("checkerboard_u8", {33, 20, 18}, VoxelType::kU8,
                       [](auto& c) { return (c.x + c.y + c.z) % 2; }));
  all.push_back(
      labels("checkerboard_of_large_labels_u64", {18, 20, 33}, VoxelType::kU64, [](auto& c) {
        return (c.x + c.y + c.z) % 2 == 0 ? std::uint64_t{1} << 32 : (std::uint64_t{1} << 63) + 1;
      }));
  all.push_back(
      labels("every_voxel_its_label_33x34x35_u32", {33, 34, 35}, VoxelType::kU32, [](auto& c) {
        return Extent{33, 34, 35}.index(c);
      }));
  // Holds a whole brick of 64^3 with 262,144 labels, and more than 65,536 labels in a brick of any
  // size but 16 and 32.
  all.push_back(
      labels("every_voxel_its_label_64x64x66_u32", {64, 64, 66}, VoxelType::kU32, [](auto& c) {
        return 0xffffffffu - Extent{64, 64, 66}.index(c);
      }));
  all.push_back(labels("least_and_largest_label_u32", {20, 17, 19}, VoxelType::kU32, [](auto& c) {
    return (c.x / 3 + c.y / 2 + c.z / 5) % 2 == 0 ? 0 : 0xffffffffu;
  }));
  all.push_back(labels("labels_above_2pow32_u64", {19, 34, 21}, VoxelType::kU64, [](auto& c) {
    const std::uint64_t cell = c.x / 4 + 9 * (c.y / 5) + 99 * (c.z / 3);
    return cell % 11 == 0  ? ~std::uint64_t{0} - cell / 11
           : cell % 7 == 0 ? cell
                           : random_at(13, cell);
  }));
  all.push_back(labels("every_voxel_its_label_u64", {13, 21, 17}, VoxelType::kU64, [](auto& c) {
    return random_at(17, Extent{13, 21, 17}.index(c));
  }));
  all.push_back(labels("diagonal_sheets_u16", {40, 37, 33}, VoxelType::kU16,
                       [](auto& c) { return (c.x + c.y + c.z) / 3; }));
  all.push_back(
      labels("planes_of_z_u8", {34, 18, 50}, VoxelType::kU8, [](auto& c) { return c.z; }));
  all.push_back(labels("salt_noise_u8", {33, 36, 31}, VoxelType::kU8, [](auto& c) {
    return random_at(19, Extent{33, 36, 31}.index(c)) % 50 == 0 ? 255 : 0;
  }));
  all.push_back(labels("noise_of_3_labels_u16", {21, 39, 22}, VoxelType::kU16, [](auto& c) {
    return 1000 * (random_at(23, Extent{21, 39, 22}.index(c)) % 3);
  }));
  all.push_back(labels("noise_of_700_labels_u16", {23, 19, 21}, VoxelType::kU16, [](auto& c) {
    return 60000 - random_at(27, Extent{23, 19, 21}.index(c)) % 700;
  }));
  all.push_back(labels("noise_of_any_label_u32", {21, 22, 23}, VoxelType::kU32, [](auto& c) {
    return random_at(29, Extent{21, 22, 23}.index(c));
  }));
}

void add_scalars(std::vector<SampleVolume>& all) {
  all.push_back(
      scalars<std::uint8_t>("ramp_of_scalars_u8", {30, 17, 21}, VoxelType::kU8,
                            [](std::uint64_t i) { return static_cast<std::uint8_t>(i / 3); }));
  all.push_back(scalars<std::uint16_t>(
      "wave_of_scalars_u16", {19, 27, 18}, VoxelType::kU16, [](std::uint64_t i) {
        return static_cast<std::uint16_t>((i % 4000) * (4000 - i % 4000) / 64);
      }));
  all.push_back(scalars<std::int16_t>(
      "extreme_scalars_i16", {11, 13, 7}, VoxelType::kI16, [](std::uint64_t i) {
        constexpr std::array<std::int16_t, 5> kValues{-32768, 32767, 0, -1, 1};
        return i % 3 == 0 ? kValues[i / 3 % 5] : static_cast<std::int16_t>(random_at(31, i));
      }));
  all.push_back(scalars<float>("nan_inf_zeros_denormals_f32", {11, 7, 13}, VoxelType::kF32,
                               [](std::uint64_t i) {
                                 using Limits = std::numeric_limits<float>;
                                 const std::array values{Limits::quiet_NaN(),
                                                         -0.0f,
                                                         0.0f,
                                                         Limits::infinity(),
                                                         -Limits::infinity(),
                                                         Limits::denorm_min(),
                                                         -Limits::denorm_min(),
                                                         Limits::max(),
                                                         Limits::lowest(),
                                                         std::bit_cast<float>(0x7f800001u),
                                                         1.0f + static_cast<float>(i)};
                                 return values[i % values.size()];
                               }));
  all.back().finite = false;
}

/// One volume of each type, from a value in 0..1 for each voxel: 0 is the least value of the type
/// and 1 the largest, of f32 -1 and 1.
void add_for_all_types(std::vector<SampleVolume>& all, const std::string& name,
                       const Extent& extent,
                       const std::function<double(const Coordinate&)>& value) {
  const auto at = [extent, value](std::uint64_t i) { return value(extent.coordinate(i)); };
  all.push_back(scalars<std::uint8_t>(name + "_u8", extent, VoxelType::kU8, [at](std::uint64_t i) {
    return static_cast<std::uint8_t>(std::lround(255 * at(i)));
  }));
  all.push_back(scalars<std::uint16_t>(
      name + "_u16", extent, VoxelType::kU16,
      [at](std::uint64_t i) { return static_cast<std::uint16_t>(std::lround(65535 * at(i))); }));
  all.push_back(
      scalars<std::int16_t>(name + "_i16", extent, VoxelType::kI16, [at](std::uint64_t i) {
        return static_cast<std::int16_t>(std::lround(65535 * at(i)) - 32768);
      }));
  all.push_back(scalars<float>(name + "_f32", extent, VoxelType::kF32, [at](std::uint64_t i) {
    return static_cast<float>(2 * at(i) - 1);
  }));
}

/// What codecs that work on values and not on labels get wrong.
void add_hard_scalars(std::vector<SampleVolume>& all) {
  add_for_all_types(all, "constant_scalars", {6, 5, 9}, [](auto&) { return 0.7; });
  add_for_all_types(all, "ramp_of_scalars_along_z", {3, 4, 50},
                    [](auto& c) { return static_cast<double>(c.z) / 49; });
  add_for_all_types(all, "checkerboard_of_extremes", {9, 8, 6},
                    [](auto& c) { return (c.x + c.y + c.z) % 2; });
  add_for_all_types(all, "noise_of_scalars", {10, 12, 7}, [](auto& c) {
    return static_cast<double>(random_at(61, Extent{10, 12, 7}.index(c)) >> 40) / 0xffffff;
  });
  add_for_all_types(all, "one_outlier", {12, 11, 10}, [](auto& c) {
    return c == Coordinate{5, 6, 7} ? 1 : 0.25;
  });
  add_for_all_types(all, "thin_scalars_1x37x23", {1, 37, 23},
                    [](auto& c) { return static_cast<double>(c.y * c.z % 41) / 40; });
  add_for_all_types(all, "scalars_5x7x9", {5, 7, 9},
                    [](auto& c) { return static_cast<double>(c.x * c.y + c.z) / 32; });
  // Time steps: of a depth that is no multiple of 4, of one plane, and one of them constant.
  all.push_back(scalars<std::uint8_t>(
      "series_of_4_u8", {11, 6, 28}, VoxelType::kU8,
      [](std::uint64_t i) { return static_cast<std::uint8_t>((i % 462 + i / 462 * 9) / 3); }, 4));
  all.push_back(scalars<float>(
      "series_of_planes_f32", {9, 10, 6}, VoxelType::kF32,
      [](std::uint64_t i) {
        return i / 90 == 3 ? 2.5f : static_cast<float>(i % 90 * (i / 90)) * 0.125f;
      },
      6));
  all.push_back(scalars<float>("one_scalar_f32", {1, 1, 1}, VoxelType::kF32,
                               [](std::uint64_t) { return -12.5f; }));
  all.push_back(
      scalars<float>("denormal_scalars_f32", {7, 9, 5}, VoxelType::kF32, [](std::uint64_t i) {
        return static_cast<float>(i % 23) * std::numeric_limits<float>::denorm_min() *
               (i % 2 == 0 ? 1000 : -1);
      }));
  all.push_back(
      scalars<float>("scalars_of_60_decades_f32", {9, 7, 8}, VoxelType::kF32, [](std::uint64_t i) {
        return (i % 2 == 0 ? 1.0f : -1.0f) *
               static_cast<float>(std::pow(10.0, static_cast<double>(i % 61) - 30));
      }));
  all.push_back(
      scalars<float>("scalars_of_any_float_f32", {8, 5, 6}, VoxelType::kF32, [](std::uint64_t i) {
        const float least = std::numeric_limits<float>::lowest(),
                    largest = std::numeric_limits<float>::max();
        return i % 5 == 0 ? least : i % 5 == 1 ? largest : static_cast<float>(i);
      }));
}

template <class T>
Volume pyramid_step(const Volume& fine) {
  Volume coarse(codecs::level_info(fine.info(), 1));
  const Extent from = fine.extent();
  const Extent to = coarse.extent();
  const auto source = fine.voxels<T>();
  for (std::uint64_t i = 0; i < to.voxels(); ++i) {
    const Coordinate at = to.coordinate(i);
    std::vector<std::pair<T, unsigned>> votes;  // in the order of first appearance
    for (unsigned child = 0; child < 8; ++child) {
      const Coordinate c{2 * at.x + child % 2, 2 * at.y + child / 2 % 2, 2 * at.z + child / 4};
      if (!from.contains(c)) continue;
      const T label = source[from.index(c)];
      const auto found = std::ranges::find(votes, label, &std::pair<T, unsigned>::first);
      found == votes.end() ? votes.emplace_back(label, 1), void() : void(++found->second);
    }
    coarse.voxels<T>()[i] =
        std::ranges::max_element(votes, {}, &std::pair<T, unsigned>::second)->first;
  }
  return coarse;
}

/// Values of one parameter, the default first.
std::vector<std::string> values_of(const ParameterSpec& spec) {
  std::vector<std::string> values{std::string(spec.default_value)};
  const auto triple = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    return std::to_string(x) + ',' + std::to_string(y) + ',' + std::to_string(z);
  };
  const std::int64_t inner =
      spec.minimum + std::min<std::int64_t>(3, (spec.maximum - spec.minimum) / 2);
  switch (spec.type) {
    case ParameterType::kText:
      values.insert(values.end(), spec.names.begin(), spec.names.end());
      break;
    case ParameterType::kTriple:
      values.push_back(triple(spec.minimum, spec.minimum, spec.minimum));
      values.push_back(triple(spec.minimum, inner, std::min(2 * inner + 1, spec.maximum)));
      values.push_back(triple(spec.maximum, spec.minimum, spec.minimum));
      values.push_back(triple(spec.minimum, spec.minimum, spec.maximum));
      values.push_back(triple(spec.maximum, spec.maximum, spec.maximum));
      break;
    case ParameterType::kInteger:
      for (const std::int64_t choice : spec.choices) values.push_back(std::to_string(choice));
      if (!spec.choices.empty()) break;
      for (const std::int64_t value : {spec.minimum, inner, spec.maximum})
        values.push_back(std::to_string(value));
      break;
  }
  return values;
}

/// Every corner once, the defaults first, those that no volume can be encoded with too.
std::vector<Parameters> every_corner(const Codec& codec) {
  std::vector<std::vector<std::string>> sets{{}};
  std::vector<std::string> least, largest;
  for (const ParameterSpec& spec : codec.parameters()) {
    const std::string name = std::string(spec.name) + '=';
    const std::vector<std::string> values = values_of(spec);
    for (const std::string& value : values) sets.push_back({name + value});
    least.push_back(name + values[1]);
    largest.push_back(name + values.back());
  }
  sets.push_back(least);
  sets.push_back(largest);
  std::vector<Parameters> corners;
  std::set<std::string> seen;
  for (const auto& assignments : sets) {
    const auto parsed = Parameters::parse(codec.parameters(), assignments);
    if (!parsed)
      throw std::logic_error(std::string(codec.traits().id) + ": " + parsed.error().message);
    if (seen.insert(parsed->canonical()).second) corners.push_back(*parsed);
  }
  return corners;
}

/// The code with which parameters are refused for a volume of one voxel.
std::optional<volumes::ErrorCode> refused_always(const Codec& codec, const Parameters& parameters) {
  Volume volume({.extent = {1, 1, 1}, .type = codec.traits().types.front(), .voxel_unit = {}});
  std::fill_n(volume.data(), volume.info().bytes(), std::byte{0});
  const auto encoded = codec.encode(volumes::MemorySource(volume), parameters, 1);
  if (encoded) return std::nullopt;
  return encoded.error().code;
}

}  // namespace

std::uint64_t random_at(std::uint64_t seed, std::uint64_t index) {
  std::uint64_t v = seed * 0x9e3779b97f4a7c15u + (index + 1) * 0xbf58476d1ce4e5b9u;
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
  return v ^ (v >> 31);
}

Volume make_labels(const VolumeInfo& info, const Label& label) {
  Volume volume(info);
  volumes::with_label_type(info.type, [&]<class T>() {
    const auto voxels = volume.voxels<T>();
    const Extent& e = info.extent;
    for (std::uint64_t i = 0; i < voxels.size(); ++i) {
      voxels[i] = static_cast<T>(label(e.coordinate(i)));
    }
  });
  return volume;
}

Label voronoi(const Extent& extent, unsigned seeds, std::uint64_t seed) {
  std::vector<Coordinate> points;
  for (unsigned i = 0; i < seeds; ++i) {
    points.push_back({random_at(seed, 3 * i) % extent.x, random_at(seed, 3 * i + 1) % extent.y,
                      random_at(seed, 3 * i + 2) % extent.z});
  }
  return [points = std::move(points)](const Coordinate& c) -> std::uint64_t {
    const auto squared = [](std::uint64_t a, std::uint64_t b) {
      return a > b ? (a - b) * (a - b) : (b - a) * (b - a);
    };
    std::uint64_t best = 0;
    std::uint64_t least = ~std::uint64_t{0};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::uint64_t d =
          squared(c.x, points[i].x) + squared(c.y, points[i].y) + squared(c.z, points[i].z);
      if (d < least) {
        least = d;
        best = i;
      }
    }
    return best + 1;
  };
}

const std::vector<SampleVolume>& sample_volumes() {
  static const std::vector<SampleVolume> kZoo = [] {
    std::vector<SampleVolume> all;
    add_shapes(all);
    add_label_patterns(all);
    add_scalars(all);
    add_hard_scalars(all);
    return all;
  }();
  return kZoo;
}

const SampleVolume& sample(const std::string& name) {
  const auto found = std::ranges::find(sample_volumes(), name, &SampleVolume::name);
  if (found == sample_volumes().end()) throw std::out_of_range("no sample " + name);
  return *found;
}

bool accepts(const Codec& codec, const VolumeInfo& info) {
  return codecs::accepts(codec.traits(), info).has_value();
}

bool accepts(const Codec& codec, const SampleVolume& sample) {
  return accepts(codec, sample.info) && (codec.traits().lossless || sample.finite);
}

std::uint64_t bits_at(const Volume& volume, const Coordinate& c) {
  const std::size_t voxel = size_of(volume.info().type);
  std::uint64_t bits = 0;
  std::memcpy(&bits, volume.data() + volume.extent().index(c) * voxel, voxel);
  return bits;
}

codecs::RecordedError error_of(const Volume& original, const Volume& decoded) {
  return volumes::with_voxel_type(original.info().type, [&]<class T>() {
    codecs::RecordedError error{};
    for (std::uint64_t i = 0; i < original.extent().voxels(); ++i) {
      const double difference = static_cast<double>(original.voxels<T>()[i]) -
                                static_cast<double>(decoded.voxels<T>()[i]);
      error.largest = std::max(error.largest, std::abs(difference));
      error.mean_squared +=
          difference * difference / static_cast<double>(original.extent().voxels());
    }
    return error;
  });
}

bool keeps(const codecs::RecordedError& recorded, const Volume& original, const Volume& decoded) {
  const codecs::RecordedError found = error_of(original, decoded);
  const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-6 * b; };
  return near(found.largest, recorded.largest) && near(found.mean_squared, recorded.mean_squared);
}

std::vector<Parameters> parameter_corners(const Codec& codec) {
  std::vector<Parameters> corners = every_corner(codec);
  std::erase_if(corners, [&](const Parameters& p) { return refused_always(codec, p).has_value(); });
  return corners;
}

std::vector<std::pair<Parameters, volumes::ErrorCode>> impossible_corners(const Codec& codec) {
  std::vector<std::pair<Parameters, volumes::ErrorCode>> impossible;
  for (const Parameters& parameters : every_corner(codec)) {
    if (const auto code = refused_always(codec, parameters))
      impossible.emplace_back(parameters, *code);
  }
  return impossible;
}

std::string test_name(const Codec& codec, const Parameters& parameters) {
  std::string name(codec.traits().id);
  if (const std::string canonical = parameters.canonical(); !canonical.empty())
    name += '_' + canonical;
  std::ranges::replace_if(
      name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}

Volume label_pyramid(const Volume& volume, unsigned lod) {
  Volume level = volume;
  for (unsigned l = 0; l < lod; ++l) {
    level = volumes::with_label_type(level.info().type,
                                     [&]<class T>() { return pyramid_step<T>(level); });
  }
  return level;
}

}  // namespace cvr::samples
