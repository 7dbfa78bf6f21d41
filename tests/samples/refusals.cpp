#include "tests/samples/refusals.hpp"

#include <fmt/format.h>

#include <fstream>
#include <stdexcept>

#include "codecs/container.hpp"

namespace cvr::samples {

namespace {

using codecs::Codec;
using codecs::Parameters;
using volumes::ErrorCode;

std::string words_of(const Codec& codec, const Parameters& parameters) {
  const std::string changes = parameters.changes(codec.parameters());
  return changes.empty() ? "defaults" : changes;
}

/// The code's name, or "encoded".
std::string outcome(const Codec& codec, const Parameters& parameters,
                    const volumes::Volume& volume) {
  const auto encoded = codecs::encode(codec, volumes::MemorySource(volume), parameters, 1);
  return encoded ? "encoded" : std::string(name_of(encoded.error().code));
}

std::set<std::string> read_cases(const std::string& file) {
  std::ifstream in(file);
  std::set<std::string> cases;
  for (std::string line; std::getline(in, line);) cases.insert(line.substr(0, line.rfind(' ')));
  if (cases.empty()) throw std::runtime_error("no refusals in " + file);
  return cases;
}

}  // namespace

std::string_view name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kBadArgument:
      return "bad-argument";
    case ErrorCode::kUnsupported:
      return "unsupported";
    case ErrorCode::kMalformed:
      return "malformed";
    case ErrorCode::kTruncated:
      return "truncated";
    case ErrorCode::kChecksum:
      return "checksum";
    case ErrorCode::kTooLarge:
      return "too-large";
    case ErrorCode::kOutOfMemory:
      return "out-of-memory";
  }
  return "unknown";
}

std::string refusal_case(const Codec& codec, const Parameters& parameters,
                         const SampleVolume& sample) {
  return fmt::format("{} {} {}", codec.traits().id, words_of(codec, parameters), sample.name);
}

std::vector<std::string> find_refusals(const Codec& codec) {
  std::vector<std::string> lines;
  for (const auto& [parameters, code] : impossible_corners(codec)) {
    lines.push_back(
        fmt::format("{} {} any {}", codec.traits().id, words_of(codec, parameters), name_of(code)));
  }
  const std::vector<Parameters> corners = parameter_corners(codec);
  for (const SampleVolume& sample : sample_volumes()) {
    const volumes::Volume volume = sample.volume();
    if (!accepts(codec, sample)) {
      lines.push_back(fmt::format("{} any {} {}", codec.traits().id, sample.name,
                                  outcome(codec, corners.front(), volume)));
      continue;
    }
    for (const Parameters& parameters : corners) {
      const std::string found = outcome(codec, parameters, volume);
      if (found != "encoded")
        lines.push_back(refusal_case(codec, parameters, sample) + ' ' + found);
    }
  }
  return lines;
}

bool is_listed_refusal(const std::string& file, const Codec& codec, const Parameters& parameters,
                       const SampleVolume& sample) {
  static const std::set<std::string> kCases = read_cases(file);
  return kCases.contains(refusal_case(codec, parameters, sample));
}

}  // namespace cvr::samples
