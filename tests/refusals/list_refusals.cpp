// What is refused: by codecs of the sample volumes (tests/samples/refusals.hpp), by access modes of
// the codecs that a GPU decodes.
//
//   list_refusals                 prints it
//   list_refusals --check FILE    compares it with a file (tests/golden/refusals.txt); exit code 1
//                                 where a line differs
//
// No device is asked: the lines of access modes are for the limits of made-up ones, so that they
// are the same on every machine. Such a line: codec, access mode, brick size, volume and device,
// then the reason in words.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "gpu/caches/cache.hpp"
#include "tests/samples/refusals.hpp"
#include "volumes/parallel.hpp"

namespace cvr::refusals {
namespace {

struct MadeUpDevice {
  const char* name;
  gpu::DeviceLimits limits;
};

/// Between what Vulkan asks of every device and what none refuses.
constexpr std::array<MadeUpDevice, 3> kDevices{{
    {"least", {1u << 30, 1u << 30, 16384, 4, 65535, 65535, true}},
    {"software", {std::uint64_t{2} << 30, std::uint64_t{2} << 30, 32768, 8, 65535, 65535, true}},
    {"boundless",
     {~std::uint64_t{0}, ~std::uint64_t{0}, UINT32_MAX, 32, UINT32_MAX, UINT32_MAX, false}},
}};
constexpr std::array kBricks{16, 32, 64};
constexpr std::array kVolumes{"odd_sides_65x33x70_u32", "every_voxel_its_label_33x34x35_u32"};

/// Lines of one codec, volume and brick size.
void add_refusals(std::vector<std::string>& lines, const codecs::Codec& codec,
                  const samples::SampleVolume& sample, int brick) {
  std::vector<std::string> given;
  for (const auto& spec : codec.parameters()) {
    if (spec.name == "brick") given.push_back(fmt::format("brick={}", brick));
  }
  const auto line = [&](std::string_view mode, std::string_view device, std::string_view reason) {
    lines.push_back(fmt::format("{} {} brick={} {} on {}: {}", codec.traits().id, mode, brick,
                                sample.name, device, reason));
  };
  const auto parameters = codecs::Parameters::parse(codec.parameters(), given);
  if (!parameters) return line("all", "any", parameters.error().message);
  const volumes::Volume volume = sample.volume();
  const auto encoded = codecs::encode(codec, volumes::MemorySource(volume), *parameters, 1);
  if (!encoded) return line("all", "any", encoded.error().message);
  const auto file = codecs::open_file(encoded->bytes.bytes()).value();
  const auto decoder = codecs::open_decoder(file).value();
  const auto encoding = decoder->gpu_encoding(static_cast<std::uint32_t>(brick), 1);
  if (!encoding) return line("all", "any", encoding.error().message);
  for (const gpu::CacheTraits& mode : gpu::all_caches()) {
    if (!mode.labels) continue;  // it refuses all labels
    for (const MadeUpDevice& device : kDevices) {
      const std::string reason = mode.refuses(*encoding, device.limits);
      if (!reason.empty()) line(mode.id, device.name, reason);
    }
  }
}

std::vector<std::string> refusals_of_modes(const codecs::Codec& codec) {
  std::vector<std::string> lines;
  if (!codec.traits().gpu_decodable) return lines;
  for (const char* name : kVolumes) {
    for (const int brick : kBricks) add_refusals(lines, codec, samples::sample(name), brick);
  }
  return lines;
}

/// Codecs side by side; the lines in the registry's order, those of access modes last.
std::vector<std::string> lines() {
  const auto registry = codecs::all_codecs();
  std::vector<std::vector<std::string>> of_codecs(registry.size()), of_modes(registry.size());
  volumes::parallel_for(std::max(std::thread::hardware_concurrency(), 1u), registry.size(),
                        [&](unsigned, std::uint64_t k) {
                          of_codecs[k] = samples::find_refusals(*registry[k]);
                          of_modes[k] = refusals_of_modes(*registry[k]);
                        });
  std::vector<std::string> all;
  for (auto* parts : {&of_codecs, &of_modes}) {
    for (auto& part : *parts) std::ranges::move(part, std::back_inserter(all));
  }
  return all;
}

/// Prints the lines that only one of the two has.
int check(std::vector<std::string> found, const std::string& path) {
  std::ifstream in(path);
  std::vector<std::string> expected;
  for (std::string line; std::getline(in, line);) expected.push_back(line);
  const std::size_t count = found.size();
  std::ranges::sort(found);
  std::ranges::sort(expected);
  std::vector<std::string> gone, more;
  std::ranges::set_difference(expected, found, std::back_inserter(gone));
  std::ranges::set_difference(found, expected, std::back_inserter(more));
  for (const std::string& line : gone) fmt::print("no longer refused: {}\n", line);
  for (const std::string& line : more) fmt::print("refused: {}\n", line);
  fmt::print("{} refusals, {} of them new, {} gone; {} lists them\n", count, more.size(),
             gone.size(), path);
  return gone.empty() && more.empty() && !expected.empty() ? 0 : 1;
}

}  // namespace
}  // namespace cvr::refusals

int main(int argc, char** argv) {
  const std::vector<std::string> lines = cvr::refusals::lines();
  if (argc == 3 && std::string(argv[1]) == "--check") return cvr::refusals::check(lines, argv[2]);
  for (const std::string& line : lines) fmt::print("{}\n", line);
  return argc == 1 ? 0 : 2;
}
