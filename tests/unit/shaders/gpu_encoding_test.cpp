// What the decoder texts compute from the buffers of a GpuEncoding equals what the decoder gives,
// for all sample volumes.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "shaders/shared/shared.hpp"
#include "tests/samples/sample_volumes.hpp"
#include "tests/samples/shared_decoders.hpp"

namespace cvr {
namespace {

using codecs::Codec;
using codecs::Decoder;
using codecs::GpuEncoding;
using codecs::Parameters;
using volumes::Coordinate;
using volumes::Extent;
using volumes::Volume;

/// Cells of a level that are asked for one by one, at most; the corners are always among them.
constexpr std::uint64_t kCells = 3000;

/// A stream of a codec, opened, and all that its levels should be.
struct Opened {
  Opened(const Codec& codec, const Parameters& parameters, const Volume& original)
      : volume(original) {
    auto encoded = codecs::encode(codec, volumes::MemorySource(original), parameters, 1);
    if (!encoded) throw std::runtime_error(encoded.error().message);
    bytes = std::move(encoded->bytes);
    const auto file = codecs::open_file(bytes.bytes());
    if (!file) throw std::runtime_error(file.error().message);
    decoder = std::move(*codecs::open_decoder(*file));
  }
  /// A level as the decoder gives it, or by the pyramid's definition where the stream has fewer
  /// levels.
  Volume level(unsigned lod) const {
    if (lod >= decoder->levels()) return samples::label_pyramid(volume, lod);
    volumes::VolumeSink sink(codecs::level_info(volume.info(), lod));
    const auto ok = decoder->decode(lod, 1, sink);
    if (!ok) throw std::runtime_error(ok.error().message);
    return sink.take();
  }
  const Volume& volume;
  volumes::Buffer bytes;
  std::unique_ptr<Decoder> decoder;
};

void expect_cells(const samples::DecodeText& text, const Volume& truth, unsigned lod) {
  const Extent& e = truth.extent();
  const std::uint64_t stride = std::max<std::uint64_t>(1, e.voxels() / kCells);
  std::uint64_t wrong = 0;
  for (std::uint64_t i = 0; i < e.voxels();
       i = i + stride < e.voxels() || i + 1 == e.voxels() ? i + stride : e.voxels() - 1) {
    const Coordinate c = e.coordinate(i);
    if (text.label(text.cell(c, lod)) != truth.label(c)) ++wrong;
  }
  EXPECT_EQ(wrong, 0u) << "cells of level " << lod;
}

void expect_bricks(const samples::DecodeText& text, const Volume& truth, unsigned lod,
                   std::uint32_t brick) {
  const std::uint32_t side = brick >> lod;
  const Extent& grid = text.grid();
  for (std::uint64_t i = 0; i < grid.voxels(); ++i) {
    const Coordinate at = grid.coordinate(i);
    const std::vector<std::uint32_t> codes = text.brick(at, lod);
    std::uint64_t wrong = 0;
    for (std::uint32_t n = 0; n < codes.size(); ++n) {
      const Coordinate c{at.x * side + shaders::cvr_morton_gather(n),
                         at.y * side + shaders::cvr_morton_gather(n >> 1),
                         at.z * side + shaders::cvr_morton_gather(n >> 2)};
      if (truth.extent().contains(c) && text.label(codes[n]) != truth.label(c)) ++wrong;
    }
    EXPECT_EQ(wrong, 0u) << "nodes of brick " << i << " at level " << lod;
  }
}

/// Roots, and which bricks hold a label: for each brick every label of the volume that it holds,
/// and one that it does not.
void expect_visibility(const samples::DecodeText& text, const GpuEncoding& encoding,
                       const Volume& finest) {
  const Extent& grid = text.grid();
  for (std::uint64_t i = 0; i < grid.voxels(); ++i) {
    const Coordinate at = grid.coordinate(i);
    std::set<std::uint64_t> held;
    const std::uint32_t b = encoding.brick;
    for (std::uint64_t z = at.z * b; z < std::min(finest.extent().z, (at.z + 1) * b); ++z) {
      for (std::uint64_t y = at.y * b; y < std::min(finest.extent().y, (at.y + 1) * b); ++y) {
        for (std::uint64_t x = at.x * b; x < std::min(finest.extent().x, (at.x + 1) * b); ++x)
          held.insert(finest.label({x, y, z}));
      }
    }
    std::size_t asked = 0;
    for (const std::uint32_t code : encoding.codes) {
      if (++asked > 20) break;
      const bool shown = text.visible(at, [&](std::uint32_t c) { return c == code; });
      EXPECT_EQ(shown, held.contains(text.label(code))) << "brick " << i << ", code " << code;
    }
    EXPECT_TRUE(text.visible(at, [&](std::uint32_t c) { return text.label(c) == *held.rbegin(); }))
        << "brick " << i;
    EXPECT_TRUE(held.contains(text.label(text.root(at)))) << "brick " << i;
  }
}

void expect_codes(const samples::DecodeText& text, const GpuEncoding& encoding,
                  const Volume& finest) {
  std::set<std::uint64_t> labels;
  for (std::uint64_t i = 0; i < finest.extent().voxels(); ++i) {
    labels.insert(finest.label(finest.extent().coordinate(i)));
  }
  std::vector<std::uint64_t> coded;
  for (const std::uint32_t code : encoding.codes) coded.push_back(text.label(code));
  EXPECT_TRUE(std::ranges::equal(coded, labels));
}

void expect_all(const Codec& codec, const Parameters& parameters, const Volume& volume,
                std::uint32_t brick) {
  const Opened opened(codec, parameters, volume);
  const auto encoding = opened.decoder->gpu_encoding(brick, 2);
  ASSERT_TRUE(encoding) << encoding.error().message;
  EXPECT_EQ(1u << (encoding->levels - 1), encoding->brick);
  EXPECT_LE(encoding->buffers.size(), 6u);
  EXPECT_TRUE(encoding->voxel_access || encoding->serial);
  const samples::DecodeText text(*encoding, volume.info());
  expect_codes(text, *encoding, volume);
  expect_visibility(text, *encoding, volume);
  for (unsigned lod = 0; lod < encoding->levels; ++lod) {
    const Volume truth = opened.level(lod);
    if (encoding->voxel_access) expect_cells(text, truth, lod);
    if (encoding->serial) expect_bricks(text, truth, lod, encoding->brick);
  }
}

bool has_bricks(const Codec& codec) {
  return std::ranges::any_of(codec.parameters(),
                             [](const auto& spec) { return spec.name == "brick"; });
}

struct Case {
  const Codec* codec;
  Parameters parameters;
  std::uint32_t brick;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Codec* codec : codecs::all_codecs()) {
    if (!codec->traits().gpu_decodable) continue;
    for (const Parameters& parameters : samples::parameter_corners(*codec)) {
      if (has_bricks(*codec)) {
        all.push_back({codec, parameters, 0});
      } else {
        for (const std::uint32_t brick : {16u, 64u}) all.push_back({codec, parameters, brick});
      }
    }
  }
  // Many chunks; edges of chunks and blocks that are no powers of two; as many levels as a brick
  // needs, and more.
  const codecs::Codec& neuroglancer = *codecs::find_codec("neuroglancer");
  for (const std::vector<std::string>& set : {std::vector<std::string>{"chunk=16", "levels=2"},
                                              {"chunk=20", "block=7,4,3", "levels=3"},
                                              {"chunk=64", "levels=6"},
                                              {"chunk=128", "levels=8"}}) {
    all.push_back({&neuroglancer, *Parameters::parse(neuroglancer.parameters(), set), 0});
  }
  return all;
}

class EveryGpuEncoding : public testing::TestWithParam<Case> {};

TEST_P(EveryGpuEncoding, EqualsTheDecoderOnTheZoo) {
  const auto& [codec, parameters, brick] = GetParam();
  unsigned done = 0;
  for (const samples::SampleVolume& sample : samples::sample_volumes()) {
    if (sample.info.kind != volumes::VolumeKind::kLabels || !samples::accepts(*codec, sample.info))
      continue;
    SCOPED_TRACE(sample.name);
    expect_all(*codec, parameters, sample.volume(), brick);
    ++done;
    if (HasFailure()) break;
  }
  EXPECT_GT(done, 10u);
}

INSTANTIATE_TEST_SUITE_P(Codecs, EveryGpuEncoding, testing::ValuesIn(cases()), [](const auto& p) {
  return samples::test_name(*p.param.codec, p.param.parameters) + "_edge_" +
         std::to_string(p.param.brick);
});

Opened opened(const std::string& codec, const Volume& volume) {
  const Codec& found = *codecs::find_codec(codec);
  return Opened(found, *Parameters::parse(found.parameters(), {}), volume);
}

TEST(GpuEncoding, IsRefusedByCodecsWithoutText) {
  const Volume volume = samples::sample("blobs_u8").volume();
  for (const Codec* codec : codecs::all_codecs()) {
    if (!codecs::accepts(codec->traits(), volume.info())) continue;
    const auto encoding =
        opened(std::string(codec->traits().id), volume).decoder->gpu_encoding(0, 1);
    EXPECT_EQ(encoding.has_value(), codec->traits().gpu_decodable) << codec->traits().id;
    if (!encoding) {
      EXPECT_EQ(encoding.error().code, codecs::ErrorCode::kUnsupported) << codec->traits().id;
    }
  }
}

TEST(GpuEncoding, IsRefusedForScalars) {
  const Volume volume = samples::sample("extreme_scalars_i16").volume();
  const auto encoding = opened("raw", volume).decoder->gpu_encoding(0, 1);
  ASSERT_FALSE(encoding);
  EXPECT_EQ(encoding.error().code, codecs::ErrorCode::kUnsupported);
}

TEST(GpuEncoding, ServesTheBrickEdgesThatItSays) {
  const Volume volume = samples::sample("blobs_u8").volume();
  for (const std::string codec :
       {"csgv-nibble", "csgv-rans", "csgvr-nibble", "csgvr", "csgvr-sb"}) {
    const Opened stream = opened(codec, volume);
    EXPECT_EQ(stream.decoder->gpu_encoding(0, 1)->brick, 32u);
    EXPECT_TRUE(stream.decoder->gpu_encoding(32, 1));
    for (const std::uint32_t edge : {16u, 64u}) {
      EXPECT_EQ(stream.decoder->gpu_encoding(edge, 1).error().code, codecs::ErrorCode::kBadArgument)
          << codec;
    }
  }
  for (const std::string codec : {"raw", "neuroglancer"}) {
    const Opened stream = opened(codec, volume);
    EXPECT_EQ(stream.decoder->gpu_encoding(0, 1)->brick, 32u);
    EXPECT_EQ(stream.decoder->gpu_encoding(8, 1)->levels, 4u);
    for (const std::uint32_t edge : {1u, 24u, 128u}) {
      EXPECT_EQ(stream.decoder->gpu_encoding(edge, 1).error().code, codecs::ErrorCode::kBadArgument)
          << codec;
    }
  }
}

TEST(GpuEncoding, IsTheSameForAnyNumberOfThreads) {
  const Volume volume = samples::sample("odd_sides_17x130x40_u16").volume();
  for (const Codec* codec : codecs::all_codecs()) {
    if (!codec->traits().gpu_decodable) continue;
    const Opened stream = opened(std::string(codec->traits().id), volume);
    const auto one = stream.decoder->gpu_encoding(0, 1), many = stream.decoder->gpu_encoding(0, 5);
    ASSERT_TRUE(one && many);
    EXPECT_EQ(one->codes, many->codes);
    EXPECT_EQ(one->constants, many->constants);
    EXPECT_EQ(one->shared_words, many->shared_words);
    ASSERT_EQ(one->buffers.size(), many->buffers.size());
    for (std::size_t i = 0; i < one->buffers.size(); ++i) {
      EXPECT_TRUE(std::ranges::equal(one->buffers[i].bytes, many->buffers[i].bytes))
          << codec->traits().id << ' ' << i;
    }
  }
}

TEST(GpuEncoding, StoresNarrowLabelsNarrow) {
  // u64 labels that fit in 32 bits take 32 bits in raw, and need no remap anywhere; others are
  // remapped.
  const Volume narrow = samples::sample("blobs_u64").volume(),
               wide = samples::sample("labels_above_2pow32_u64").volume();
  for (const std::string codec : {"raw", "neuroglancer", "csgvr"}) {
    const Opened small = opened(codec, narrow), large = opened(codec, wide);
    EXPECT_TRUE(small.decoder->gpu_encoding(0, 1)->remap.empty()) << codec;
    const auto encoding = large.decoder->gpu_encoding(0, 1);
    EXPECT_FALSE(encoding->remap.empty()) << codec;
    EXPECT_TRUE(std::ranges::is_sorted(encoding->remap)) << codec;
    EXPECT_LT(encoding->codes.back(), encoding->remap.size()) << codec;
  }
  EXPECT_EQ(opened("raw", narrow).decoder->gpu_encoding(0, 1)->constants.front().second, 32u);
}

}  // namespace
}  // namespace cvr
