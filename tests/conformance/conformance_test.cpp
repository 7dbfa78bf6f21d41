// What every codec of the registry must do with every sample volume, for its default parameters and
// the corners of their ranges. No codec is named here: a new line in the registry brings all of
// these tests with it.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <map>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "tests/samples/refusals.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::codecs {
namespace {

using samples::SampleVolume;

/// Codecs may refuse a combination of legal parameters (a block larger than its chunk, a table that
/// overflows); every such case is listed here.
constexpr const char* kRefusals = CVR_SOURCE_DIR "/tests/golden/refusals.txt";

struct Case {
  const Codec* codec;
  Parameters parameters;
  const SampleVolume* sample;
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const Codec* codec : all_codecs()) {
    const std::vector<Parameters> corners = samples::parameter_corners(*codec);
    for (const Parameters& parameters : corners) {
      for (const SampleVolume& sample : samples::sample_volumes()) {
        if (samples::accepts(*codec, sample) &&
            !samples::is_listed_refusal(kRefusals, *codec, parameters, sample)) {
          cases.push_back({codec, parameters, &sample});
        }
      }
    }
  }
  return cases;
}

/// A sample's levels of detail, made once.
const Volume& level_of(const SampleVolume& sample, unsigned lod) {
  static std::map<std::string, std::vector<Volume>> made;
  std::vector<Volume>& levels = made[sample.name];
  while (levels.size() <= lod)
    levels.push_back(levels.empty() ? sample.volume() : samples::label_pyramid(levels.back(), 1));
  return levels[lod];
}

/// Takes slabs into one volume and checks how they are handed over.
class SlabCheck final : public SlabSink {
 public:
  SlabCheck(const VolumeInfo& info, std::uint64_t depth) : volume_(info), depth_(depth) {
    std::memset(volume_.data(), 0xa5, volume_.info().bytes());
  }
  std::uint64_t preferred_depth() const override { return depth_; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    EXPECT_FALSE(open_);
    EXPECT_EQ(z0, next_);
    EXPECT_LT(z0, z1);
    EXPECT_LE(z1, volume_.extent().z);
    open_ = true;
    begun_ = z1;
    return volume_.data() +
           z0 * volume_.extent().x * volume_.extent().y * size_of(volume_.info().type);
  }
  void end(std::uint64_t z0, std::uint64_t z1) override {
    EXPECT_TRUE(open_);
    EXPECT_EQ(z0, next_);
    EXPECT_EQ(z1, begun_);
    next_ = z1;
    open_ = false;
  }
  const Volume& finished() const {
    EXPECT_FALSE(open_);
    EXPECT_EQ(next_, volume_.extent().z);
    return volume_;
  }

 private:
  Volume volume_;
  std::uint64_t depth_;
  std::uint64_t next_ = 0, begun_ = 0;
  bool open_ = false;
};

/// Whether two volumes hold the same bytes; names the first voxel that differs.
testing::AssertionResult same_voxels(const Volume& expected, const Volume& found) {
  if (expected.extent() != found.extent()) {
    return testing::AssertionFailure() << "extent " << to_string(found.extent()) << ", expected "
                                       << to_string(expected.extent());
  }
  const std::size_t voxel = size_of(expected.info().type);
  const Extent& e = expected.extent();
  if (std::memcmp(expected.data(), found.data(), expected.info().bytes()) == 0)
    return testing::AssertionSuccess();
  std::uint64_t i = 0;
  while (std::memcmp(expected.data() + i * voxel, found.data() + i * voxel, voxel) == 0) ++i;
  return testing::AssertionFailure()
         << "first differing voxel (" << i % e.x << ", " << i / e.x % e.y << ", " << i / (e.x * e.y)
         << ") of " << to_string(e);
}

/// Points to ask for: every voxel of small volumes, a sample of others (single-voxel access may
/// cost a walk over a brick).
std::vector<Coordinate> query_points(const Extent& e) {
  constexpr std::uint64_t kAllBelow = 3000;
  constexpr std::uint64_t kSampled = 400;
  const std::uint64_t voxels = e.voxels();
  std::vector<Coordinate> points{{0, 0, 0}, {e.x - 1, e.y - 1, e.z - 1}};
  const std::uint64_t count = voxels < kAllBelow ? voxels : kSampled;
  for (std::uint64_t k = 0; k < count; ++k) {
    const std::uint64_t i = voxels < kAllBelow ? k : samples::random_at(43, k) % voxels;
    points.push_back({i % e.x, i / e.x % e.y, i / (e.x * e.y)});
  }
  return points;
}

class Conformance : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    const volumes::MemorySource source(original());
    encoded_ = codecs::encode(*GetParam().codec, source, GetParam().parameters, 1);
    ASSERT_TRUE(encoded_) << encoded_.error().message << "; " << kRefusals << " does not list it";
  }
  const Volume& original() const { return level_of(*GetParam().sample, 0); }
  bool lossless() const { return GetParam().codec->traits().lossless; }
  std::span<const std::byte> bytes() const { return encoded_->bytes.bytes(); }

  void check_voxels(const VoxelAccess& access, const Volume& level, unsigned lod) const {
    const std::vector<Coordinate> points = query_points(original().extent());
    std::vector<std::uint64_t> labels(points.size(), 77);
    const auto ok = access.at(points, lod, labels);
    ASSERT_TRUE(ok) << ok.error().message;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Coordinate& p = points[i];
      ASSERT_EQ(labels[i], samples::bits_at(level, {p.x >> lod, p.y >> lod, p.z >> lod}))
          << p.x << ' ' << p.y << ' ' << p.z;
    }
    EXPECT_TRUE(access.at({}, lod, {}));
  }

  /// Steps take more and more of the payload, the last all of it; each decodes for any number of
  /// threads.
  void check_steps(const ProgressiveAccess& access, const Volume& whole,
                   std::uint64_t payload_bytes) const {
    ASSERT_GE(access.steps(), 2u);
    for (unsigned step = 0; step < access.steps(); ++step) {
      EXPECT_FALSE(access.step_name(step).empty());
      if (step > 0) {
        EXPECT_GE(access.step_bytes(step), access.step_bytes(step - 1))
            << "a step without a book costs nothing";
      }
      SlabCheck one(original().info(), 64);
      const auto ok = access.decode_step(step, 1, one);
      ASSERT_TRUE(ok) << ok.error().message;
      SlabCheck many(original().info(), 5);
      ASSERT_TRUE(access.decode_step(step, 3, many));
      EXPECT_TRUE(same_voxels(one.finished(), many.finished())) << "step " << step;
      if (step + 1 == access.steps()) {
        EXPECT_TRUE(same_voxels(whole, one.finished()));
      }
    }
    EXPECT_EQ(access.step_bytes(access.steps() - 1), payload_bytes);
  }

  void check_bricks(const BrickAccess& access, const Volume& level, unsigned lod) const {
    const Extent size = access.brick_size();
    const Extent grid = access.brick_grid();
    ASSERT_GE(grid.x * size.x, original().extent().x);
    ASSERT_GE(grid.y * size.y, original().extent().y);
    ASSERT_GE(grid.z * size.z, original().extent().z);
    const Extent step = level_extent(size, lod);
    const std::size_t voxel = size_of(level.info().type);
    for (std::uint64_t i = 0; i < grid.voxels(); ++i) {
      const Coordinate brick{i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y)};
      volumes::Box box{{brick.x * step.x, brick.y * step.y, brick.z * step.z}, {}};
      box.size = {std::min(step.x, level.extent().x - box.origin.x),
                  std::min(step.y, level.extent().y - box.origin.y),
                  std::min(step.z, level.extent().z - box.origin.z)};
      // Allocated to the byte, so that a sanitizer sees a write beyond it.
      std::vector<std::byte> expected(box.size.voxels() * voxel);
      std::vector<std::byte> found(box.size.voxels() * voxel, std::byte{0x5a});
      volumes::MemorySource(level).read(box, expected.data());
      const auto ok = access.decode_brick(brick, lod, found.data());
      ASSERT_TRUE(ok) << ok.error().message;
      ASSERT_TRUE(expected == found) << "brick " << brick.x << ' ' << brick.y << ' ' << brick.z;
    }
    const auto outside = access.decode_brick({grid.x, 0, 0}, lod, nullptr);
    ASSERT_FALSE(outside);
    EXPECT_EQ(outside.error().code, ErrorCode::kBadArgument);
  }

  Expected<Encoded> encoded_{tl::unexpect, Error{ErrorCode::kBadArgument, "not encoded"}};
};

TEST_P(Conformance, SectionsCoverTheFile) {
  const auto file = open_file(bytes());
  ASSERT_TRUE(file) << file.error().message;
  const auto decoder = open_decoder(*file);
  ASSERT_TRUE(decoder) << decoder.error().message;
  const std::vector<Section> sections = sections_of(*file, **decoder);
  std::uint64_t at = 0;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    EXPECT_EQ(sections[i].begin, at) << sections[i].name;
    EXPECT_GT(sections[i].end, at) << sections[i].name;
    at = sections[i].end;
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(sections[j].name, sections[i].name);
  }
  EXPECT_EQ(at, bytes().size());
}

TEST_P(Conformance, RoundTripsAndDescribesItself) {
  const auto file = open_file(bytes());
  ASSERT_TRUE(file) << file.error().message;
  const VolumeInfo& info = original().info();
  EXPECT_EQ(file->codec, GetParam().codec);
  EXPECT_EQ(file->stream.parameters.canonical(), GetParam().parameters.canonical());
  EXPECT_EQ(file->stream.info.extent, info.extent);
  EXPECT_EQ(file->stream.info.type, info.type);
  EXPECT_EQ(file->stream.info.kind, info.kind);
  EXPECT_EQ(file->stream.info.voxel_size, info.voxel_size);
  EXPECT_EQ(file->stream.info.voxel_unit, info.voxel_unit);
  EXPECT_EQ(file->stream.info.time_steps, info.time_steps);
  EXPECT_EQ(file->published_bytes, encoded_->published_bytes);

  EXPECT_EQ(encoded_->breakdown.total(), bytes().size());
  for (std::size_t i = 0; i < kByteClasses; ++i) {
    EXPECT_EQ(encoded_->breakdown[ByteClass(i)], file->breakdown[ByteClass(i)])
        << name_of(ByteClass(i));
  }
  if (lossless()) {  // publications of lossy codecs count what a device holds, which may be nothing, or more than a file
    EXPECT_LE(encoded_->published_bytes, bytes().size());
    EXPECT_GT(encoded_->published_bytes, 0u);
  }

  const auto decoded = codecs::decode(bytes(), 0, 1);
  ASSERT_TRUE(decoded) << decoded.error().message;
  if (lossless()) {
    EXPECT_TRUE(same_voxels(original(), *decoded));
  }
  const auto decoder = open_decoder(*file);
  ASSERT_TRUE(decoder) << decoder.error().message;
  const auto recorded = (*decoder)->recorded_error();
  ASSERT_EQ(recorded.has_value(), !lossless());
  if (recorded) {
    const RecordedError found = samples::error_of(original(), *decoded);
    EXPECT_TRUE(samples::keeps(*recorded, original(), *decoded))
        << "largest error " << recorded->largest << " recorded, " << found.largest
        << " found; mean squared error " << recorded->mean_squared << " recorded, "
        << found.mean_squared << " found";
  }
  const auto valid = validate(bytes(), 2);
  EXPECT_TRUE(valid) << valid.error().message;
}

TEST_P(Conformance, EncodesTheSameBytesForAnyThreadsAndSource) {
  const samples::StreamedSource streamed(original());
  const volumes::MemorySource memory(original());
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    const VolumeSource& source =
        threads % 2 == 1 ? static_cast<const VolumeSource&>(streamed) : memory;
    const auto again = codecs::encode(*GetParam().codec, source, GetParam().parameters, threads);
    ASSERT_TRUE(again) << again.error().message;
    ASSERT_EQ(again->bytes.size(), bytes().size()) << threads << " threads";
    ASSERT_EQ(std::memcmp(again->bytes.data(), bytes().data(), bytes().size()), 0)
        << threads << " threads";
    EXPECT_EQ(again->published_bytes, encoded_->published_bytes);
  }
}

TEST_P(Conformance, AllWaysOfDecodingAgree) {
  const auto file = open_file(bytes());
  ASSERT_TRUE(file) << file.error().message;
  const auto decoder = open_decoder(*file);
  ASSERT_TRUE(decoder) << decoder.error().message;
  const unsigned levels = (*decoder)->levels();
  ASSERT_GE(levels, 1u);
  EXPECT_TRUE(levels == 1 || GetParam().codec->traits().levels_of_detail);

  for (unsigned lod = 0; lod < levels; ++lod) {
    SCOPED_TRACE("level of detail " + std::to_string(lod));
    const VolumeInfo info = level_info(original().info(), lod);
    const auto whole = codecs::decode(bytes(), lod, 1);
    ASSERT_TRUE(whole) << whole.error().message;
    ASSERT_EQ(whole->extent(), info.extent);
    if (lossless() && (lod == 0 || info.kind == VolumeKind::kLabels)) {
      ASSERT_TRUE(same_voxels(level_of(*GetParam().sample, lod), *whole));
    }
    for (const auto& [threads, depth] : {std::pair{2u, 1u}, {3u, 5u}, {7u, 64u}}) {
      SlabCheck sink(info, depth);
      const auto ok = (*decoder)->decode(lod, threads, sink);
      ASSERT_TRUE(ok) << ok.error().message;
      EXPECT_TRUE(same_voxels(*whole, sink.finished()))
          << threads << " threads, slabs of " << depth;
    }
    if (const VoxelAccess* access = (*decoder)->voxel_access()) check_voxels(*access, *whole, lod);
    if (const BrickAccess* access = (*decoder)->brick_access()) check_bricks(*access, *whole, lod);
  }
  if (const ProgressiveAccess* access = (*decoder)->progressive_access())
    check_steps(*access, codecs::decode(bytes(), 0, 1).value(), file->stream.payload.size());
  const auto beyond = codecs::decode(bytes(), levels, 1);
  ASSERT_FALSE(beyond);
  EXPECT_EQ(beyond.error().code, ErrorCode::kBadArgument);
}

TEST_P(Conformance, RefusesTruncatedAndChangedFiles) {
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{40}, bytes().size() / 2, bytes().size() - 1}) {
    EXPECT_FALSE(open_file(bytes().first(size))) << size;
  }
  Buffer changed;
  changed.append(bytes());
  for (std::uint64_t i = 0; i < 16; ++i) {
    std::byte& byte = changed.data()[samples::random_at(41, i) % changed.size()];
    byte ^= std::byte{0x10};
    EXPECT_FALSE(open_file(changed.bytes()));
    byte ^= std::byte{0x10};
  }
  EXPECT_TRUE(open_file(changed.bytes()));
}

std::string case_name(const testing::TestParamInfo<Case>& info) {
  return samples::test_name(*info.param.codec, info.param.parameters) + "_of_" +
         info.param.sample->name;
}

INSTANTIATE_TEST_SUITE_P(Registry, Conformance, testing::ValuesIn(all_cases()), case_name);

class Refusals : public testing::TestWithParam<const Codec*> {
 protected:
  static VolumeKind accepted_kind() {
    return GetParam()->traits().lossless ? VolumeKind::kLabels : VolumeKind::kScalars;
  }
};

TEST_P(Refusals, TypesThatAreNotAccepted) {
  for (const VoxelType type : volumes::kVoxelTypes) {
    const VolumeInfo info{
        .extent = {3, 2, 1}, .type = type, .kind = accepted_kind(), .voxel_unit = {}};
    if (samples::accepts(*GetParam(), info)) continue;
    Volume volume(info);
    std::memset(volume.data(), 0, info.bytes());
    const auto encoded = codecs::encode(*GetParam(), volumes::MemorySource(volume),
                                        samples::parameter_corners(*GetParam())[0], 1);
    ASSERT_FALSE(encoded) << name_of(type);
    EXPECT_EQ(encoded.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(encoded.error().message.find(name_of(type)), std::string::npos)
        << encoded.error().message;
  }
}

TEST_P(Refusals, LabelsByLossyCodecs) {
  if (GetParam()->traits().lossless) return;
  for (const SampleVolume& sample : samples::sample_volumes()) {
    if (sample.info.kind != VolumeKind::kLabels) continue;
    const Volume volume = sample.volume();
    const auto encoded = codecs::encode(*GetParam(), volumes::MemorySource(volume),
                                        samples::parameter_corners(*GetParam())[0], 1);
    ASSERT_FALSE(encoded) << sample.name;
    EXPECT_EQ(encoded.error().code, ErrorCode::kUnsupported);
  }
}

TEST_P(Refusals, NonFiniteVoxelsByLossyCodecs) {
  const VolumeInfo info{
      .extent = {7, 6, 5}, .type = VoxelType::kF32, .kind = VolumeKind::kScalars, .voxel_unit = {}};
  if (GetParam()->traits().lossless || !samples::accepts(*GetParam(), info)) return;
  Volume volume(info);
  for (float& voxel : volume.voxels<float>()) voxel = 0.5f;
  volume.voxels<float>()[info.extent.index({3, 4, 2})] = std::numeric_limits<float>::quiet_NaN();
  volume.voxels<float>()[info.extent.index({0, 0, 4})] = -std::numeric_limits<float>::infinity();
  for (const unsigned threads : {1u, 3u}) {
    const auto encoded = codecs::encode(*GetParam(), samples::StreamedSource(volume),
                                        samples::parameter_corners(*GetParam())[0], threads);
    ASSERT_FALSE(encoded);
    EXPECT_EQ(encoded.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(encoded.error().message.find("found 2 "), std::string::npos)
        << encoded.error().message;
    EXPECT_NE(encoded.error().message.find("(3, 4, 2)"), std::string::npos)
        << encoded.error().message;
  }
}

TEST_P(Refusals, EmptyExtents) {
  for (const Extent& extent : {Extent{0, 0, 0}, {0, 3, 2}, {3, 0, 2}, {3, 2, 0}}) {
    const Volume volume({.extent = extent,
                         .type = GetParam()->traits().types.front(),
                         .kind = accepted_kind(),
                         .voxel_unit = {}});
    const auto encoded = codecs::encode(*GetParam(), volumes::MemorySource(volume),
                                        samples::parameter_corners(*GetParam())[0], 1);
    ASSERT_FALSE(encoded) << to_string(extent);
    EXPECT_EQ(encoded.error().code, ErrorCode::kBadArgument);
  }
}

TEST_P(Refusals, UnknownAndMalformedParameters) {
  const auto parse = [&](std::vector<std::string> texts) {
    return Parameters::parse(GetParam()->parameters(), texts);
  };
  EXPECT_FALSE(parse({"no-such-parameter=1"}));
  for (const ParameterSpec& spec : GetParam()->parameters()) {
    const std::string name(spec.name);
    const std::string value(spec.default_value);
    EXPECT_TRUE(parse({name + '=' + value}));
    for (const std::string& bad :
         {name, name + '=', name + "=x", name + "=1,", name + "=99999999999999999999",
          name + '=' + value + ' ', name + '=' + value + ",0"}) {
      EXPECT_FALSE(parse({bad})) << bad;
    }
    EXPECT_FALSE(parse({name + '=' + value, name + '=' + value})) << "given twice";
  }
}

INSTANTIATE_TEST_SUITE_P(Registry, Refusals,
                         testing::ValuesIn(all_codecs().begin(), all_codecs().end()),
                         [](const auto& info) { return samples::test_name(*info.param, {}); });

TEST(Registry, IdentifiersAreUniqueAndFound) {
  for (const Codec* codec : all_codecs()) EXPECT_EQ(find_codec(codec->traits().id), codec);
  EXPECT_EQ(find_codec("no-such-codec"), nullptr);
}

}  // namespace
}  // namespace cvr::codecs
