// What holds for any volume of labels (of scalars, where a codec is lossy), any codec of the
// registry and any of its parameters.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstring>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "tests/property/arbitrary.hpp"

namespace cvr::property {
namespace {

using codecs::Codec;
using codecs::Parameters;
using codecs::ParameterSpec;
using codecs::ParameterType;
using volumes::Coordinate;
using volumes::Volume;

std::string arbitrary_value(const ParameterSpec& spec) {
  const auto number = [&] {
    return *rc::gen::inRange<std::int64_t>(spec.minimum, spec.maximum + 1);
  };
  if (spec.type == ParameterType::kText) return std::string(*rc::gen::elementOf(spec.names));
  if (spec.type == ParameterType::kInteger) {
    return std::to_string(spec.choices.empty() ? number() : *rc::gen::elementOf(spec.choices));
  }
  return std::to_string(number()) + ',' + std::to_string(number()) + ',' + std::to_string(number());
}

/// Random parameters; the defaults half of the time.
Parameters arbitrary_parameters(const Codec& codec) {
  std::vector<std::string> assignments;
  for (const ParameterSpec& spec : codec.parameters()) {
    if (*rc::gen::arbitrary<bool>())
      assignments.push_back(std::string(spec.name) + '=' + arbitrary_value(spec));
  }
  return Parameters::parse(codec.parameters(), assignments).value();
}

Coordinate arbitrary_voxel(const volumes::Extent& e) {
  return {*rc::gen::inRange<std::uint64_t>(0, e.x), *rc::gen::inRange<std::uint64_t>(0, e.y),
          *rc::gen::inRange<std::uint64_t>(0, e.z)};
}

/// Runs a property 200 times.
template <class Property>
void check(const Codec& codec, const std::string& description, const Property& property) {
  rc::detail::TestParams params = rc::detail::configuration().testParams;
  params.maxSuccess = 200;
  rc::detail::TestMetadata metadata;
  metadata.id = std::string(codec.traits().id);
  metadata.description = description;
  const rc::detail::TestResult result = rc::detail::checkTestable(property, metadata, params);
  std::ostringstream message;
  rc::detail::printResultMessage(result, message);
  EXPECT_TRUE(result.is<rc::detail::SuccessResult>()) << message.str();
}

class CodecProperty : public testing::TestWithParam<const Codec*> {};

TEST_P(CodecProperty, EveryLevelAndEveryVoxelOfEveryVolume) {
  const Codec& codec = *GetParam();
  const auto property = [&] {
    const auto type = *rc::gen::elementOf(codec.traits().types);
    RC_PRE(type != volumes::VoxelType::kI16 && type != volumes::VoxelType::kF32);
    const Volume volume =
        arbitrary_labels(type, arbitrary_extent(*rc::gen::element<std::uint64_t>(3, 12, 20, 35)));
    const Parameters parameters = arbitrary_parameters(codec);
    const auto threads = *rc::gen::inRange(1u, 4u);
    const auto encoded = codecs::encode(codec, volumes::MemorySource(volume), parameters, threads);
    if (!encoded) {  // random parameters may not go together; the defaults always do
      RC_ASSERT(encoded.error().code != codecs::ErrorCode::kMalformed &&
                !parameters.values().empty());
      RC_DISCARD("refused");
    }
    RC_ASSERT(encoded->breakdown.total() == encoded->bytes.size());
    const auto file = codecs::open_file(encoded->bytes.bytes()).value();
    const auto decoder = codecs::open_decoder(file).value();
    const unsigned lod = *rc::gen::inRange(0u, decoder->levels());
    const Volume expected = samples::label_pyramid(volume, lod);
    const Volume found = codecs::decode(encoded->bytes.bytes(), lod, threads).value();
    RC_ASSERT(found.extent() == expected.extent());
    RC_ASSERT(std::memcmp(found.data(), expected.data(), expected.info().bytes()) == 0);
    if (const codecs::VoxelAccess* access = decoder->voxel_access()) {
      const Coordinate c = arbitrary_voxel(volume.extent());
      std::uint64_t label = 0;
      RC_ASSERT(access->at({&c, 1}, lod, {&label, 1}).has_value());
      RC_ASSERT(label == expected.label({c.x >> lod, c.y >> lod, c.z >> lod}));
    }
  };
  check(codec, "decodes what was encoded", property);
}

class LossyCodecProperty : public testing::TestWithParam<const Codec*> {};

TEST_P(LossyCodecProperty, RecordedErrorIsThatOfEveryVolume) {
  const Codec& codec = *GetParam();
  const auto property = [&] {
    const Volume volume =
        arbitrary_scalars(*rc::gen::elementOf(codec.traits().types),
                          arbitrary_extent(*rc::gen::element<std::uint64_t>(3, 9, 17)));
    const Parameters parameters = arbitrary_parameters(codec);
    const auto threads = *rc::gen::inRange(1u, 4u);
    const auto encoded = codecs::encode(codec, volumes::MemorySource(volume), parameters, threads);
    if (!encoded) {
      RC_ASSERT(encoded.error().code != codecs::ErrorCode::kMalformed &&
                !parameters.values().empty());
      RC_DISCARD("refused");
    }
    RC_ASSERT(encoded->breakdown.total() == encoded->bytes.size());
    const auto file = codecs::open_file(encoded->bytes.bytes()).value();
    const auto decoder = codecs::open_decoder(file).value();
    const Volume found = codecs::decode(encoded->bytes.bytes(), 0, threads).value();
    RC_ASSERT(found.info().time_steps == volume.info().time_steps);
    RC_ASSERT(samples::keeps(decoder->recorded_error().value(), volume, found));
    if (const codecs::VoxelAccess* access = decoder->voxel_access()) {
      const Coordinate c = arbitrary_voxel(volume.extent());
      std::uint64_t bits = 0;
      RC_ASSERT(access->at({&c, 1}, 0, {&bits, 1}).has_value());
      RC_ASSERT(bits == samples::bits_at(found, c));
    }
  };
  check(codec, "keeps the recorded error", property);
}

std::vector<const Codec*> codecs_that_are(bool lossless) {
  std::vector<const Codec*> chosen;
  for (const Codec* codec : codecs::all_codecs()) {
    if (codec->traits().lossless == lossless) chosen.push_back(codec);
  }
  return chosen;
}

std::string name_of_case(const testing::TestParamInfo<const Codec*>& info) {
  return samples::test_name(*info.param, {});
}

INSTANTIATE_TEST_SUITE_P(Registry, CodecProperty, testing::ValuesIn(codecs_that_are(true)),
                         name_of_case);
INSTANTIATE_TEST_SUITE_P(Registry, LossyCodecProperty, testing::ValuesIn(codecs_that_are(false)),
                         name_of_case);

}  // namespace
}  // namespace cvr::property
