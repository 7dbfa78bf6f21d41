// More voxels than 2^31, from a source that makes them.
#include <algorithm>
#include <array>

#include "tests/unit/codecs/tvq/coded.hpp"

namespace cvr::codecs::tvq {
namespace {

/// A series of steps of one layer of blocks, which come in two kinds: all 0 or all 200. Nothing is
/// in memory.
class ProceduralSource final : public volumes::VolumeSource {
 public:
  static constexpr Extent kExtent{4096, 4096, 132};
  static constexpr std::uint64_t kSteps = 33, kRun = 512;  // blocks of a kind come in runs along x
  static std::uint8_t value(const Coordinate& c) {
    return samples::random_at(c.z / 4, c.x / kRun + 8 * (c.y / 4)) % 2 == 0 ? std::uint8_t{0}
                                                                            : std::uint8_t{200};
  }
  const VolumeInfo& info() const override { return info_; }
  void read(const volumes::Box& box, std::byte* out) const override {
    for (std::uint64_t z = box.origin.z; z < box.origin.z + box.size.z; ++z) {
      for (std::uint64_t y = box.origin.y; y < box.origin.y + box.size.y; ++y) {
        for (std::uint64_t x = box.origin.x; x < box.origin.x + box.size.x;) {
          const std::uint64_t end = std::min(box.origin.x + box.size.x, (x / kRun + 1) * kRun);
          std::fill_n(out, end - x, static_cast<std::byte>(value({x, y, z})));
          out += end - x;
          x = end;
        }
      }
    }
  }

 private:
  VolumeInfo info_{.extent = kExtent,
                   .type = VoxelType::kU8,
                   .kind = VolumeKind::kScalars,
                   .voxel_unit = {},
                   .time_steps = kSteps};
};

/// Two code vectors are exact, so every voxel is known, those beyond 2^31 too.
TEST(Large, VoxelsBeyondTwoToThe31AreReached) {
  const ProceduralSource source;
  ASSERT_GT(source.info().extent.voxels(), std::uint64_t{1} << 31);
  const Codec& codec = *find_codec("vq");
  const auto parameters =
      Parameters::parse(codec.parameters(), std::vector<std::string>{"books=shared", "bits=1"});
  const auto file = codecs::encode(codec, source, parameters.value(), 2);
  ASSERT_TRUE(file) << file.error().message;
  const OpenedFile opened = open_file(file->bytes.bytes()).value();
  const auto decoder = open_decoder(opened).value();
  EXPECT_EQ(decoder->recorded_error()->largest, 0.0);
  std::vector<Coordinate> points;
  for (const std::uint64_t z : {0u, 3u, 63u, 127u, 128u, 129u, 131u}) {
    for (const std::uint64_t y : {0u, 63u, 2047u, 2048u, 4095u}) {
      for (const std::uint64_t x : {0u, 1023u, 1024u, 4095u}) points.push_back({x, y, z});
    }
  }
  std::vector<std::uint64_t> found(points.size());
  ASSERT_TRUE(decoder->voxel_access()->at(points, 0, found));
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_EQ(found[i], ProceduralSource::value(points[i]))
        << points[i].x << ' ' << points[i].y << ' ' << points[i].z;
  EXPECT_GT(ProceduralSource::kExtent.index(points.back()), std::uint64_t{1} << 31);
}

}  // namespace
}  // namespace cvr::codecs::tvq
