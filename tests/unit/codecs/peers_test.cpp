// What holds for every peer codec, whatever its format: round trips, damage, truncation, threads.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "tests/samples/small_labels.hpp"

namespace cvr::codecs {
namespace {

using test::Content;
using test::kContents;
using test::kExtents;
using test::sample_volume;

struct Case {
  std::string codec;
  std::vector<std::string> parameters;
};

class Peers : public testing::TestWithParam<Case> {
 protected:
  const Codec& codec() const { return *find_codec(GetParam().codec); }
  Parameters parameters() const {
    return Parameters::parse(codec().parameters(), GetParam().parameters).value();
  }
  Payload encode(const VolumeSource& source, unsigned threads = 1) const {
    auto payload = codec().encode(source, parameters(), threads);
    if (!payload) throw std::runtime_error(payload.error().message);
    return std::move(*payload);
  }
  Stream stream(const VolumeInfo& info, std::span<const std::byte> payload) const {
    return {info, parameters(), payload};
  }
  /// Opens and decodes everything; the result only has to be an answer.
  Expected<Volume> try_decode(const VolumeInfo& info, std::span<const std::byte> payload,
                              unsigned threads = 1) const {
    auto decoder = codec().open(stream(info, payload));
    if (!decoder) return tl::unexpected(decoder.error());
    volumes::VolumeSink sink(info);
    if (auto ok = (*decoder)->decode(0, threads, sink); !ok) return tl::unexpected(ok.error());
    if (const VoxelAccess* access = (*decoder)->voxel_access()) {
      const Coordinate last{info.extent.x - 1, info.extent.y - 1, info.extent.z - 1};
      std::uint64_t label = 0;
      if (auto ok = access->at({&last, 1}, 0, {&label, 1}); !ok) return tl::unexpected(ok.error());
    }
    return sink.take();
  }
};

/// Gives boxes only, no pointer: what a file does.
class BoxSource final : public VolumeSource {
 public:
  explicit BoxSource(const Volume& volume) : memory_(volume) {}
  const VolumeInfo& info() const override { return memory_.info(); }
  void read(const volumes::Box& box, std::byte* out) const override { memory_.read(box, out); }

 private:
  volumes::MemorySource memory_;
};

/// Takes slabs of a few planes and puts them together.
class ThinSink final : public SlabSink {
 public:
  ThinSink(const VolumeInfo& info, std::uint64_t depth) : volume_(info), depth_(depth) {}
  std::uint64_t preferred_depth() const override { return depth_; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    EXPECT_EQ(z0, next_);
    EXPECT_LT(z0, z1);
    EXPECT_LE(z1, volume_.extent().z);
    slab_.resize((z1 - z0) * plane());
    return slab_.data();
  }
  void end(std::uint64_t z0, std::uint64_t z1) override {
    std::memcpy(volume_.data() + z0 * plane(), slab_.data(), slab_.size());
    next_ = z1;
  }
  bool complete() const { return next_ == volume_.extent().z; }
  const Volume& volume() const { return volume_; }

 private:
  std::uint64_t plane() const {
    return volume_.extent().x * volume_.extent().y * size_of(volume_.info().type);
  }
  Volume volume_;
  Buffer slab_;
  std::uint64_t depth_, next_ = 0;
};

bool equal(const Volume& a, const Volume& b) {
  return a.bytes().size() == b.bytes().size() &&
         std::memcmp(a.data(), b.data(), a.bytes().size()) == 0;
}

TEST_P(Peers, RoundTripsEveryTypeExtentAndContent) {
  for (const VoxelType type : codec().traits().types) {
    for (const Extent& extent : kExtents) {
      for (const Content content : kContents) {
        // i16 and f32 volumes hold the bit patterns of labels.
        const VoxelType as = type == VoxelType::kI16   ? VoxelType::kU16
                             : type == VoxelType::kF32 ? VoxelType::kU32
                                                       : type;
        Volume volume = sample_volume(content, extent, as);
        volume.info().type = type;
        if (type != as) volume.info().kind = VolumeKind::kScalars;
        SCOPED_TRACE(test::describe(content, volume.info()));
        const Payload payload = encode(volumes::MemorySource(volume));
        EXPECT_EQ(payload.breakdown.total(), payload.bytes.size());
        EXPECT_LE(payload.published_bytes, payload.bytes.size());
        const auto decoded = try_decode(volume.info(), payload.bytes.bytes());
        ASSERT_TRUE(decoded) << decoded.error().message;
        ASSERT_TRUE(equal(*decoded, volume));
      }
    }
  }
}

TEST_P(Peers, BytesDependNeitherOnThreadsNorOnTheSource) {
  for (const Content content : {Content::kCells, Content::kNoise}) {
    const Volume volume = sample_volume(content, {75, 50, 61}, VoxelType::kU32);
    const Payload one = encode(volumes::MemorySource(volume));
    for (const unsigned threads : {2u, 5u}) {
      const Payload more = encode(volumes::MemorySource(volume), threads);
      ASSERT_EQ(one.bytes.size(), more.bytes.size());
      EXPECT_EQ(std::memcmp(one.bytes.data(), more.bytes.data(), one.bytes.size()), 0);
      const Payload boxes = encode(BoxSource(volume), threads);
      ASSERT_EQ(one.bytes.size(), boxes.bytes.size());
      EXPECT_EQ(std::memcmp(one.bytes.data(), boxes.bytes.data(), one.bytes.size()), 0);
      const auto decoded = try_decode(volume.info(), one.bytes.bytes(), threads);
      ASSERT_TRUE(decoded) << decoded.error().message;
      EXPECT_TRUE(equal(*decoded, volume));
    }
  }
}

TEST_P(Peers, DecodesIntoThinSlabs) {
  const Volume volume = sample_volume(Content::kCells, {33, 20, 29}, VoxelType::kU16);
  const Payload payload = encode(volumes::MemorySource(volume));
  const auto decoder = codec().open(stream(volume.info(), payload.bytes.bytes()));
  ASSERT_TRUE(decoder) << decoder.error().message;
  for (const std::uint64_t depth : {1u, 3u, 16u}) {
    ThinSink sink(volume.info(), depth);
    ASSERT_TRUE((*decoder)->decode(0, 2, sink));
    EXPECT_TRUE(sink.complete());
    EXPECT_TRUE(equal(sink.volume(), volume));
  }
}

TEST_P(Peers, EveryTruncationIsAnError) {
  const Volume volume = sample_volume(Content::kCells, {7, 6, 5}, VoxelType::kU16);
  const Payload payload = encode(volumes::MemorySource(volume));
  for (std::size_t size = 0; size < payload.bytes.size(); ++size) {
    // A copy of its own, so that a sanitizer sees any read behind it.
    Buffer part;
    part.append(payload.bytes.data(), size);
    EXPECT_FALSE(try_decode(volume.info(), part.bytes())) << size << " of " << payload.bytes.size();
  }
  Buffer longer = payload.bytes;
  longer.append("surplus!", 8);
  EXPECT_FALSE(try_decode(volume.info(), longer.bytes()));
}

TEST_P(Peers, DamagedBytesNeverCrash) {
  const Volume volume = sample_volume(Content::kCells, {13, 9, 11}, VoxelType::kU32);
  const Payload payload = encode(volumes::MemorySource(volume));
  for (std::uint64_t trial = 0; trial < 3000; ++trial) {
    Buffer damaged = payload.bytes;
    const unsigned edits = 1 + test::mix(trial) % 3;
    for (unsigned i = 0; i < edits; ++i) {
      const std::uint64_t random = test::mix(trial * 8 + i);
      damaged.data()[random % damaged.size()] =
          static_cast<std::byte>(trial % 4 == 0 ? 0xff : random >> 40);
    }
    const auto decoded = try_decode(volume.info(), damaged.bytes());
    if (decoded) {
      EXPECT_EQ(decoded->bytes().size(), volume.bytes().size());
    }
  }
}

TEST_P(Peers, AnnouncedExtentsAreRefusedBeforeMemoryIsTaken) {
  const Volume volume = sample_volume(Content::kZero, {8, 8, 8}, VoxelType::kU8);
  const Payload payload = encode(volumes::MemorySource(volume));
  const std::uint64_t edge = std::uint64_t{1} << 40;
  for (const Extent& extent :
       {Extent{edge, 1024, 1}, Extent{1, edge, 1024}, Extent{1024, 1, edge}}) {
    VolumeInfo info = volume.info();
    info.extent = extent;
    EXPECT_FALSE(codec().open(stream(info, payload.bytes.bytes())));
  }
}

TEST_P(Peers, AnotherExtentIsAnErrorOrAnAnswer) {
  const Volume volume = sample_volume(Content::kCells, {13, 9, 11}, VoxelType::kU16);
  const Payload payload = encode(volumes::MemorySource(volume));
  for (const Extent& extent :
       {Extent{1, 1, 1}, Extent{9, 13, 11}, Extent{130, 9, 11}, Extent{13, 90, 1}}) {
    VolumeInfo info = volume.info();
    info.extent = extent;
    const auto decoded = try_decode(info, payload.bytes.bytes());
    if (decoded) {
      EXPECT_EQ(decoded->extent(), extent);
    }
  }
}

TEST_P(Peers, FilesPassThroughTheContainer) {
  const Volume volume = sample_volume(Content::kExtremes, {19, 8, 6}, VoxelType::kU64);
  const auto file = codecs::encode(codec(), volumes::MemorySource(volume), parameters(), 2);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->breakdown.total(), file->bytes.size());
  const auto decoded = codecs::decode(file->bytes.bytes(), 0, 2);
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_TRUE(equal(*decoded, volume));
  EXPECT_TRUE(validate(file->bytes.bytes(), 1));
}

std::string case_name(const testing::TestParamInfo<Case>& info) {
  std::string name = info.param.codec;
  for (const std::string& parameter : info.param.parameters) name += "_" + parameter;
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
}

INSTANTIATE_TEST_SUITE_P(
    All, Peers,
    testing::Values(Case{"zstd", {}}, Case{"zstd", {"level=9"}}, Case{"lzma", {"level=1"}},
                    Case{"hdf5-gzip", {}},
                    Case{"hdf5-gzip", {"chunk=16,5,4", "level=1", "shuffle=1"}},
                    Case{"neuroglancer", {}}, Case{"compresso", {}},
                    Case{"compresso", {"window=4,4,4"}}, Case{"compresso", {"window=5,3,2"}},
                    Case{"compresso", {"window=64,1,1"}}, Case{"compresso-lzma", {}},
                    Case{"neuroglancer", {"block=8,4,2", "chunk=24"}},
                    Case{"neuroglancer", {"block=3,5,7", "chunk=20", "levels=3"}}),
    case_name);

}  // namespace
}  // namespace cvr::codecs
