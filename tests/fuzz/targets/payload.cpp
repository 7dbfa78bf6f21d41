// A payload alone, of the codec that is the variant: all that its decoder can be asked, and the
// decoder texts of the GPU as C++.
#include <map>

#include "codecs/registry.hpp"
#include "tests/fuzz/exercise.hpp"
#include "tests/fuzz/payload_input.hpp"

namespace {

std::vector<std::string> codec_ids() {
  std::vector<std::string> ids;
  for (const auto* codec : cvr::codecs::all_codecs()) ids.emplace_back(codec->traits().id);
  return ids;
}

/// Finding the corners encodes a volume for each; so they are kept.
const std::vector<cvr::codecs::Parameters>& corners_of(const cvr::codecs::Codec& codec) {
  static std::map<std::string_view, std::vector<cvr::codecs::Parameters>> kept;
  auto& corners = kept[codec.traits().id];
  if (corners.empty()) corners = cvr::samples::parameter_corners(codec);
  return corners;
}

}  // namespace

#ifdef CVR_FUZZ_PROGRAM
/// Encoders may take more memory than decoders, so the corners are found before libFuzzer watches.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv);
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* variant = std::getenv("CVRBENCH_FUZZ_VARIANT");
  const auto* codec = cvr::codecs::find_codec(variant == nullptr ? codec_ids().front() : variant);
  if (codec != nullptr) corners_of(*codec);
  return 0;
}
#endif

CVR_FUZZ_TARGET_WITH_VARIANTS(payload, codec_ids, id, input) {
  const cvr::codecs::Codec* codec = cvr::codecs::find_codec(id);
  if (codec == nullptr) std::abort();  // no such variant
  const auto& corners = corners_of(*codec);
  if (input.size() < cvr::fuzz::kPayloadChoices) return;
  cvr::codecs::Stream stream =
      cvr::fuzz::stream_of(*codec, corners, input.first<cvr::fuzz::kPayloadChoices>());
  const std::vector<std::byte> payload(input.begin() + cvr::fuzz::kPayloadChoices, input.end());
  stream.payload = payload;
  cvr::fuzz::exercise_payload(*codec, stream);
}
