#include "experiments/run/bench_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "codecs/registry.hpp"
#include "experiments/config/datasets.hpp"

namespace cvr::experiments {

namespace {

using volumes::VolumeKind;

constexpr double kGoodPsnr = 40;  // dB
constexpr std::size_t kVoxelStages = 3;

/// A text as YAML takes it, whatever it holds.
std::string quoted(const std::string& text) { return Row(text).dump(); }

std::string dataset_line(const BenchVolume& volume) {
  std::string line =
      fmt::format("      - {{file: {}, name: {}", quoted(volume.file), quoted(volume.name));
  if (volume.options.kind) line += fmt::format(", kind: {}", name_of(*volume.options.kind));
  if (!volume.options.axes.empty()) line += fmt::format(", axes: {}", volume.options.axes);
  if (volume.options.allow_external) line += ", allow_external: true";
  return line + "}\n";
}

std::vector<std::string> codecs_for(const BenchVolume& volume) {
  std::vector<std::string> ids;
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    if (codecs::accepts(codec->traits(), volume.info)) ids.emplace_back(codec->traits().id);
  }
  return ids;
}

std::string voxel_block(const BenchVolume& volume) {
  return fmt::format(
      "  - datasets:\n{}    codecs: [{}]\n    stages: [encode, decode, random-access]\n",
      dataset_line(volume), fmt::join(codecs_for(volume), ", "));
}

std::string image_block(const BenchVolume& volume) {
  return fmt::format(
      "  - datasets:\n{}    codecs: [{}]\n    stages: [render]\n    scenes: [{}]\n"
      "    access_modes: all\n    size: [320, 180]\n    frames: 4\n    warm_frames: 2\n"
      "    keep_images: 1\n",
      dataset_line(volume), volume.drawn_codec, name_of(volume.info.kind));
}

constexpr std::string_view kLabelTable =
    "  - name: bench_labels\n"
    "    title: \"Label volumes: size, speed and exactness, one thread\"\n"
    "    where: {kind: labels}\n"
    "    rows: [dataset, codec]\n"
    "    columns: [rate, encode_mvoxel_per_s, decode_mvoxel_per_s, access_uniform_ns, exact, "
    "peak_mib, status]\n";
constexpr std::string_view kScalarTable =
    "  - name: bench_scalars\n"
    "    title: \"Scalar volumes: speed against error, one thread\"\n"
    "    where: {kind: scalars}\n"
    "    rows: [dataset, codec]\n"
    "    columns: [bits_per_voxel, volume_psnr_db, largest_error, encode_mvoxel_per_s, "
    "decode_mvoxel_per_s, access_uniform_ns, peak_mib, status]\n";
constexpr std::string_view kImageTable =
    "  - name: bench_images\n"
    "    title: \"Images by access mode\"\n"
    "    rows: [dataset, codec, access_mode]\n"
    "    columns: [frame_ms, first_frame_ms, warm_ms, converged_after, label_mismatches, psnr_db, "
    "gpu_mib, status]\n";

}  // namespace

BenchVolume open_for_bench(const std::string& file, const volumes::OpenOptions& options) {
  BenchVolume volume{std::filesystem::absolute(file).lexically_normal().string(),
                     name_of_file(file), options, volumes::open_volume(file, options)->info(), ""};
  if (codecs_for(volume).empty())
    throw volumes::InputError(
        fmt::format("{}: expected a volume that some codec takes, found {} {}", file,
                    name_of(volume.info.kind), name_of(volume.info.type)));
  return volume;
}

std::string codec_to_draw(const BenchVolume& volume, const std::vector<Result>& rows) {
  struct Candidate {
    std::string id;
    std::uint64_t bytes;
    double psnr;
    bool good() const { return psnr >= kGoodPsnr; }
  };
  std::optional<Candidate> best;
  for (const Result& row : rows) {
    const codecs::Codec* codec = codecs::find_codec(row.codec.id);
    if (codec == nullptr || !row.is_ok() || row.dataset.name != volume.name || !row.size ||
        !row.size->bytes)
      continue;
    const codecs::Traits& traits = codec->traits();
    const bool labels = volume.info.kind == VolumeKind::kLabels;
    const bool fits = labels ? traits.gpu_decodable && traits.access == codecs::Granularity::kVoxel
                             : traits.gpu_scalars && !traits.lossless;
    if (!fits) continue;
    const double psnr = row.error && row.error->psnr_db ? *row.error->psnr_db : kGoodPsnr;
    const Candidate here{row.codec.id, *row.size->bytes, psnr};
    const auto better = [](const Candidate& a, const Candidate& b) {
      if (a.good() != b.good()) return a.good();
      return a.good() ? a.bytes < b.bytes : a.psnr > b.psnr;
    };
    if (!best || better(here, *best)) best = here;
  }
  return best ? best->id : "";
}

std::size_t bench_cells(const std::vector<BenchVolume>& volumes) {
  std::size_t cells = 0;
  for (const BenchVolume& volume : volumes) cells += kVoxelStages * codecs_for(volume).size();
  return cells;
}

std::string bench_config(const std::vector<BenchVolume>& volumes, double timeout) {
  std::vector<std::string> names;
  for (const BenchVolume& volume : volumes) names.push_back(volume.name);
  std::string text = fmt::format(
      "# Written by `cvrbench bench`. To measure again: cvrbench run THIS_FILE --out DIR\n"
      "title: {}\nrounds: 3\nmax_rounds: 9\ntimeout_s: {:.3g}\nlods: [0]\nmatrix:\n",
      quoted(fmt::format("Benchmark of {}", fmt::join(names, ", "))), timeout);
  for (const BenchVolume& volume : volumes) text += voxel_block(volume);
  bool images = false;
  for (const BenchVolume& volume : volumes) {
    if (volume.drawn_codec.empty()) continue;
    text += image_block(volume);
    images = true;
  }
  text += "tables:\n";
  const auto any = [&](VolumeKind kind) {
    return std::ranges::any_of(volumes, [&](const BenchVolume& v) { return v.info.kind == kind; });
  };
  if (any(VolumeKind::kLabels)) text += kLabelTable;
  if (any(VolumeKind::kScalars)) text += kScalarTable;
  if (images) text += kImageTable;
  return text;
}

}  // namespace cvr::experiments
