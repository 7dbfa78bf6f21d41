// The input of the target `payload`: eight bytes that choose what the envelope would say, then the
// payload.
//
//   0  which of samples::parameter_corners        1  which voxel type of the codec; 128 and above: scalars where both kinds are legal
//   2  3  4  extent x, y, z, less one, modulo 40   5  time steps, less one, where they divide z   6  7  nothing
#pragma once

#include <array>

#include "codecs/codec.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::fuzz {

inline constexpr std::size_t kPayloadChoices = 8;
inline constexpr std::uint64_t kLargestSide = 40;

/// What the first bytes choose; the payload is not set.
inline codecs::Stream stream_of(const codecs::Codec& codec,
                                const std::vector<codecs::Parameters>& corners,
                                std::span<const std::byte, kPayloadChoices> choices) {
  const auto byte = [&](std::size_t i) { return std::to_integer<std::uint64_t>(choices[i]); };
  const auto side = [&](std::size_t i) { return byte(i) % kLargestSide + 1; };
  const auto& types = codec.traits().types;
  volumes::VolumeInfo info{.extent = {side(2), side(3), side(4)},
                           .type = types[byte(1) % 128 % types.size()],
                           .voxel_unit = {}};
  info.kind = volumes::VolumeKind::kLabels;
  if (byte(1) >= 128 || !codecs::accepts(codec.traits(), info))
    info.kind = volumes::VolumeKind::kScalars;
  if (!codecs::accepts(codec.traits(), info)) info.kind = volumes::VolumeKind::kLabels;
  if (info.extent.z % (byte(5) + 1) == 0) info.time_steps = byte(5) + 1;
  return {.info = info, .parameters = corners[byte(0) % corners.size()], .payload = {}};
}

/// The bytes that choose a volume and the corner of that number; sides of at most kLargestSide.
inline std::array<std::byte, kPayloadChoices> choices_of(const codecs::Codec& codec,
                                                         std::size_t corner,
                                                         const volumes::VolumeInfo& info) {
  const auto& types = codec.traits().types;
  std::size_t type = 0;
  while (types[type] != info.type) ++type;
  if (info.kind == volumes::VolumeKind::kScalars) type += 128;
  std::array<std::byte, kPayloadChoices> choices{};
  choices[0] = static_cast<std::byte>(corner);
  choices[1] = static_cast<std::byte>(type);
  choices[2] = static_cast<std::byte>(info.extent.x - 1);
  choices[3] = static_cast<std::byte>(info.extent.y - 1);
  choices[4] = static_cast<std::byte>(info.extent.z - 1);
  choices[5] = static_cast<std::byte>(info.time_steps - 1);
  return choices;
}

}  // namespace cvr::fuzz
