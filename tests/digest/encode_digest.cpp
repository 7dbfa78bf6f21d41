// The bytes that every codec makes of the sample volumes, as checksums: whatever compiler, build
// type, instruction set and number of threads made them, they are the same.
//
//   encode_digest                 prints them
//   encode_digest --check FILE    compares them with a file (tests/golden/digests.txt); exit code 1 where one differs
//
// A line: codec, parameters that differ from the defaults, volume, XXH3-64 of the encoded file and
// of the decoded voxels (of lossless codecs "exact", and they are). Each is encoded by one thread
// and again by 2 to 16, a number that goes round from line to line.
#include <fmt/format.h>
#include <xxhash.h>

#include <cstdio>
#include <cstring>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::digest {
namespace {

/// Volumes that every corner of the parameters is tried on; all others are encoded with the
/// defaults.
const std::set<std::string> kForCorners{
    "blobs_u16",          "noise_of_700_labels_u16", "labels_above_2pow32_u64",
    "ramp_of_scalars_u8", "series_of_4_u8",          "one_outlier_f32"};

std::string hash_of(const std::byte* bytes, std::size_t size) {
  return fmt::format("{:016x}", XXH3_64bits(bytes, size));
}

/// The two checksums, or what is wrong.
std::string digest_of(const codecs::Codec& codec, const codecs::Parameters& parameters,
                      const volumes::Volume& volume, unsigned threads) {
  const volumes::MemorySource source(volume);
  const auto encoded = codecs::encode(codec, source, parameters, 1);
  if (!encoded) return "refused";
  const auto again = codecs::encode(codec, source, parameters, threads);
  if (!again || again->bytes.size() != encoded->bytes.size() ||
      std::memcmp(again->bytes.data(), encoded->bytes.data(), encoded->bytes.size()) != 0) {
    return fmt::format("other bytes by {} threads", threads);
  }
  const auto decoded = codecs::decode(encoded->bytes.bytes(), 0, threads);
  if (!decoded) return "not decoded: " + decoded.error().message;
  const bool exact = std::memcmp(decoded->data(), volume.data(), volume.info().bytes()) == 0;
  if (codec.traits().lossless && !exact) return "other voxels";
  return hash_of(encoded->bytes.data(), encoded->bytes.size()) + ' ' +
         (codec.traits().lossless ? std::string("exact")
                                  : hash_of(decoded->data(), decoded->info().bytes()));
}

std::vector<std::string> lines() {
  std::vector<std::string> all;
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    const auto corners = samples::parameter_corners(*codec);
    for (const samples::SampleVolume& sample : samples::sample_volumes()) {
      if (!samples::accepts(*codec, sample)) continue;
      const volumes::Volume volume = sample.volume();
      for (const codecs::Parameters& parameters : corners) {
        const unsigned threads = 2 + static_cast<unsigned>(all.size() % 15);
        const std::string changes = parameters.changes(codec->parameters());
        all.push_back(fmt::format("{} {} {} {}", codec->traits().id,
                                  changes.empty() ? "defaults" : changes, sample.name,
                                  digest_of(*codec, parameters, volume, threads)));
        if (!kForCorners.contains(sample.name)) break;  // the first corner is the defaults
      }
    }
  }
  return all;
}

int check(const std::vector<std::string>& found, const std::string& path) {
  std::ifstream in(path);
  std::vector<std::string> expected;
  for (std::string line; std::getline(in, line);) expected.push_back(line);
  int differences = 0;
  for (std::size_t i = 0; i < std::max(found.size(), expected.size()); ++i) {
    const std::string was = i < expected.size() ? expected[i] : "nothing",
                      is = i < found.size() ? found[i] : "nothing";
    if (was == is) continue;
    if (++differences <= 20) fmt::print("{}:{}: expected {}\n  found {}\n", path, i + 1, was, is);
  }
  fmt::print("{} encodings, {} differ\n", found.size(), differences);
  return differences == 0 && !expected.empty() ? 0 : 1;
}

}  // namespace
}  // namespace cvr::digest

int main(int argc, char** argv) {
  const std::vector<std::string> lines = cvr::digest::lines();
  if (argc == 3 && std::string(argv[1]) == "--check") return cvr::digest::check(lines, argv[2]);
  for (const std::string& line : lines) fmt::print("{}\n", line);
  return argc == 1 ? 0 : 2;
}
