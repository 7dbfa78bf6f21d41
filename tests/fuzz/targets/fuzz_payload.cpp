// libFuzzer: a payload alone. The first bytes choose codec, parameters, voxel type and extent; the rest is
// the payload.
#include <cstring>
#include <vector>

#include "codecs/registry.hpp"
#include "tests/fuzz/exercise.hpp"
#include "tests/zoo/zoo.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kChoices = 8;
  if (size < kChoices) return 0;
  const auto all = cvr::codecs::all_codecs();
  const cvr::codecs::Codec& codec = *all[data[0] % all.size()];
  static const auto kCorners = [&] {
    std::vector<std::vector<cvr::codecs::Parameters>> corners;
    for (const auto* c : all) corners.push_back(cvr::zoo::parameter_corners(*c));
    return corners;
  }();
  const auto& corners = kCorners[data[0] % all.size()];
  const auto& types = codec.traits().types;
  const auto side = [&](std::size_t i) { return std::uint64_t{data[i]} % 80 + 1; };
  cvr::codecs::Stream stream{.info = {.extent = {side(3), side(4), side(5)},
                                      .type = types[data[2] % types.size()],
                                      .kind = codec.traits().lossless ? cvr::volumes::VolumeKind::kLabels
                                                                      : cvr::volumes::VolumeKind::kScalars,
                                      .voxel_unit = {}},
                             .parameters = corners[data[1] % corners.size()],
                             .payload = {}};
  std::vector<std::byte> payload(size - kChoices);
  if (!payload.empty()) std::memcpy(payload.data(), data + kChoices, payload.size());
  stream.payload = payload;
  cvr::fuzz::exercise_payload(codec, stream);
  return 0;
}
