// Encoding and decoding in tests of vq, hvq and tvq.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "codecs/tvq/tvq.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::codecs::tvq {

template <class T>
Volume make_scalars(const Extent& extent, VoxelType type,
                    const std::function<T(const Coordinate&)>& value) {
  Volume volume({.extent = extent, .type = type, .kind = VolumeKind::kScalars, .voxel_unit = {}});
  auto voxels = volume.voxels<T>();
  for (std::uint64_t i = 0; i < voxels.size(); ++i) voxels[i] = value(extent.coordinate(i));
  return volume;
}

/// Rings of different widths and a little noise: every class of block occurs.
inline double rings(const Coordinate& c) {
  const double x = static_cast<double>(c.x) - 17, y = static_cast<double>(c.y) - 9,
               z = static_cast<double>(c.z) - 12;
  const double r = std::sqrt(x * x + 1.5 * y * y + 0.7 * z * z);
  return 120 + 90 * std::sin(r * r / 60) +
         static_cast<double>(samples::random_at(5, c.x + 1000 * (c.y + 1000 * c.z)) % 9);
}
inline Volume rings_u8(const Extent& extent) {
  return make_scalars<std::uint8_t>(extent, VoxelType::kU8, [](const Coordinate& c) {
    return static_cast<std::uint8_t>(rings(c));
  });
}

struct Coded {
  Encoded file;
  OpenedFile opened;
  std::unique_ptr<Decoder> decoder;
  Volume decoded;
};

inline Expected<Encoded> try_encode(std::string_view id, const Volume& volume,
                                    const std::vector<std::string>& assignments,
                                    unsigned threads = 1) {
  const Codec& codec = *find_codec(id);
  return codecs::encode(codec, volumes::MemorySource(volume),
                        Parameters::parse(codec.parameters(), assignments).value(), threads);
}

inline Coded code(std::string_view id, const Volume& volume,
                  const std::vector<std::string>& assignments, unsigned threads = 1) {
  auto encoded = try_encode(id, volume, assignments, threads);
  if (!encoded) throw std::runtime_error(encoded.error().message);
  Coded coded{std::move(*encoded), {}, nullptr, {}};
  coded.opened = open_file(coded.file.bytes.bytes()).value();
  auto decoder = open_decoder(coded.opened);
  if (!decoder) throw std::runtime_error(decoder.error().message);
  coded.decoder = std::move(*decoder);
  coded.decoded = codecs::decode(coded.file.bytes.bytes(), 0, 2).value();
  return coded;
}

template <class T>
RecordedError error_of(const Volume& expected, const Volume& found) {
  RecordedError error{0, 0};
  const auto a = expected.voxels<T>(), b = found.voxels<T>();
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double difference = std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
    error.largest = std::max(error.largest, difference);
    error.mean_squared += difference * difference / static_cast<double>(a.size());
  }
  return error;
}

/// The whole-volume path against the text that a GPU runs, for every voxel.
template <class T>
void expect_single_voxels_agree(const Coded& coded) {
  const Extent& e = coded.decoded.extent();
  std::vector<Coordinate> points;
  for (std::uint64_t i = 0; i < e.voxels(); ++i) points.push_back(e.coordinate(i));
  std::vector<std::uint64_t> found(points.size());
  ASSERT_TRUE(coded.decoder->voxel_access()->at(points, 0, found));
  const auto voxels = coded.decoded.voxels<T>();
  for (std::size_t i = 0; i < found.size(); ++i) ASSERT_EQ(found[i], voxels[i]) << i;
}

inline bool same_voxels(const Volume& a, const Volume& b) {
  return a.extent() == b.extent() && std::memcmp(a.data(), b.data(), a.info().bytes()) == 0;
}

inline constexpr std::array<std::string_view, 3> kIds{"vq", "hvq", "tvq"};

}  // namespace cvr::codecs::tvq
