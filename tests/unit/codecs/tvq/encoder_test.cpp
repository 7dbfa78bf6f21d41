// Inside of the encoder: what must not depend on the sign of eigenvectors, and real volumes.
#include "codecs/tvq/encoder.hpp"

#include <cstdlib>
#include <filesystem>

#include "codecs/tvq/sub_volume.hpp"
#include "tests/samples/real_data.hpp"
#include "tests/unit/codecs/tvq/coded.hpp"
#include "volumes/io/io.hpp"

namespace cvr::codecs::tvq {
namespace {

/// With every second vector turned around.
Basis flipped(const Basis& basis) {
  std::vector<std::int16_t> stored(basis.stored().begin(), basis.stored().end());
  const std::size_t row = basis.kind() == TransformKind::kKltFull ? kBlockVoxels : 4;
  for (std::size_t i = 0; i < stored.size(); ++i) {
    if (i / row % 2 == 1) stored[i] = static_cast<std::int16_t>(-stored[i]);
  }
  return Basis(basis.kind(), stored);
}

TEST(Encoder, SignsOfEigenvectorsChangeNoVoxel) {
  const Volume volume = rings_u8({40, 36, 32});
  const volumes::MemorySource source(volume);
  const Survey facts = survey(source, ZeroValue::kZero, false).value();
  for (const TransformKind kind : {TransformKind::kKltSeparable, TransformKind::kKltFull}) {
    std::array<Volume, 2> decoded;
    for (const bool flip : {false, true}) {
      Options options;
      options.transform = kind;
      options.bits = {7, 7, 6};
      Encoding encoding;
      encoding.domain = facts.domain;
      const volumes::Box whole{{0, 0, 0}, volume.extent()};
      Blocks blocks(read_blocks(source, facts.domain, whole));
      const Basis other = flipped(Basis::fit(kind, blocks.samples, 2));
      if (flip) options.basis = &other;
      const Trained trained = train(kTvq, facts.domain, blocks, 720, 0, options, 2);
      encoding.parts.push_back(
          tvq::code(kTvq, facts.domain, trained, {10, 9, 8}, blocks, options, 2));
      encoding.books.push_back(trained.set);
      volumes::VolumeSink sink(volume.info());
      ASSERT_TRUE(make_decoder(kTvq, volume.info(), encoding, {}).value()->decode(0, 1, sink));
      decoded[flip ? 1 : 0] = sink.take();
    }
    EXPECT_TRUE(same_voxels(decoded[0], decoded[1]));
  }
}

TEST(Encoder, EdgesRepeatAndSamplesAreExact) {
  const Volume volume = rings_u8({5, 6, 7});
  const volumes::MemorySource source(volume);
  const Survey facts = survey(source, ZeroValue::kZero, false).value();
  const std::vector<float> blocks = read_blocks(source, facts.domain, {{0, 0, 0}, volume.extent()});
  ASSERT_EQ(blocks.size(), 2u * 2 * 2 * kBlockVoxels);
  for (unsigned b = 0; b < 8; ++b) {
    for (unsigned i = 0; i < kBlockVoxels; ++i) {
      const Coordinate c{std::min(4u, (b & 1) * 4 + (i & 3)),
                         std::min(5u, (b >> 1 & 1) * 4 + (i >> 2 & 3)),
                         std::min(6u, (b >> 2) * 4 + (i >> 4))};
      ASSERT_EQ(blocks[b * kBlockVoxels + i],
                static_cast<float>(volume.voxels<std::uint8_t>()[volume.extent().index(c)] -
                                   facts.domain.zero));
    }
  }
}

class RealVolume : public testing::TestWithParam<const char*> {};

TEST_P(RealVolume, TvqIsAtLeastAsGoodAsHvqAndVqAtItsRate) {
  const char* folder = std::getenv("CVRBENCH_DATA");
  const std::string path = std::string(folder == nullptr ? "" : folder) + '/' + GetParam() + ".h5";
  CVR_SKIP_UNLESS(folder != nullptr && std::filesystem::exists(path),
                  "no " << GetParam() << ".h5: CVRBENCH_DATA names no folder that holds it");
  Volume volume = volumes::read_all(*volumes::open_volume(path, VolumeKind::kScalars));
  const Coded tvq = code("tvq", volume, {}, 2);
  for (const std::string_view id : {"hvq", "vq"}) {
    const Coded other = code(id, volume, {"rate=570"}, 2);
    RecordProperty(std::string(id), std::to_string(other.decoder->recorded_error()->mean_squared));
    EXPECT_LE(tvq.decoder->recorded_error()->mean_squared,
              other.decoder->recorded_error()->mean_squared)
        << id;
  }
}

INSTANTIATE_TEST_SUITE_P(Scans, RealVolume,
                         testing::Values("bonsai", "engine", "head_mr_t1", "cranium_ct"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace cvr::codecs::tvq
