// Writes the seeds that fuzzing starts from: fuzz_seeds OUT makes OUT/TARGET/NAME, the same files
// in every run. Small encodings of the sample volumes by every codec and corner of its parameters,
// volume files as the writers of this project make them, and the configurations, scenes and
// descriptions that it comes with.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "tests/fuzz/payload_input.hpp"
#include "tests/fuzz/seeds_hdf5.hpp"
#include "volumes/io/io.hpp"

namespace cvr::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestSeed = 6000;

class Seeds {
 public:
  explicit Seeds(fs::path out) : out_(std::move(out)) {}
  void add(const std::string& target, const std::string& name, std::string_view bytes) {
    if (bytes.size() > kLargestSeed) return;
    fs::create_directories(out_ / target);
    std::ofstream(out_ / target / name, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    ++count_;
  }
  std::size_t count() const { return count_; }

 private:
  fs::path out_;
  std::size_t count_ = 0;
};

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void add_encodings(Seeds& seeds) {
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    const std::string id(codec->traits().id);
    const auto corners = samples::parameter_corners(*codec);
    for (const samples::SampleVolume& sample : samples::sample_volumes()) {
      const volumes::Extent& e = sample.info.extent;
      if (!samples::accepts(*codec, sample) || std::max({e.x, e.y, e.z}) > kLargestSide ||
          e.voxels() > 6000)
        continue;
      const volumes::Volume volume = sample.volume();
      // All corners of the small volumes that have room for several blocks; of the others the
      // defaults.
      const bool all_corners = e.voxels() >= 200 && e.voxels() <= 1000;
      for (std::size_t corner = 0; corner < (all_corners ? corners.size() : 1); ++corner) {
        const auto encoded =
            codecs::encode(*codec, volumes::MemorySource(volume), corners[corner], 1);
        if (!encoded || encoded->bytes.size() > kLargestSeed)
          continue;  // a corner that does not suit the volume
        const std::string name = fmt::format("{}.{}.{}", id, corner, sample.name);
        const auto file = codecs::open_file(encoded->bytes.bytes()).value();
        const auto choices = choices_of(*codec, corner, sample.info);
        std::string payload(reinterpret_cast<const char*>(choices.data()), choices.size());
        payload += std::string_view(reinterpret_cast<const char*>(file.stream.payload.data()),
                                    file.stream.payload.size());
        seeds.add("payload-" + id, name, payload);
        if (corner > 0) continue;
        const std::string_view whole(reinterpret_cast<const char*>(encoded->bytes.data()),
                                     encoded->bytes.size());
        seeds.add("decode", name, whole);
        if (e.voxels() <= 1000) seeds.add("envelope", name, whole);
      }
    }
  }
}

void add_volume_files(Seeds& seeds, const fs::path& scratch) {
  for (const samples::SampleVolume& sample : samples::sample_volumes()) {
    if (sample.info.bytes() > 3000) continue;
    const volumes::Volume volume = sample.volume();
    for (const auto& [target, ending] :
         {std::pair{"hdf5", ".h5"}, {"nrrd", ".nrrd"}, {"nifti", ".nii"}, {"nifti", ".nii.gz"}}) {
      const fs::path path = scratch / (sample.name + ending);
      try {
        volumes::write_volume(path.string(), volumes::MemorySource(volume));
        seeds.add(target, path.filename().string(), read(path));
      } catch (const volumes::InputError&) {  // what the format cannot hold
      }
    }
    try {
      const fs::path raw = scratch / (sample.name + ".raw");
      volumes::write_volume(raw.string(), volumes::MemorySource(volume));
      const std::string sidecar = read(raw.string() + ".yaml");
      seeds.add("raw_sidecar", sample.name, static_cast<char>(sample.info.bytes()) + sidecar);
      const fs::path nhdr = scratch / (sample.name + ".nhdr");
      volumes::write_volume(nhdr.string(), volumes::MemorySource(volume));
      seeds.add("nhdr", sample.name, read(nhdr));
    } catch (const volumes::InputError&) {
    }
  }
}

void add_hdf5_files(Seeds& seeds, const fs::path& scratch) {
  const fs::path path = scratch / "seed.h5";
  const auto add = [&](const std::string& name, const Hdf5Seed& seed) {
    write_hdf5_seed(path.string(), seed);
    seeds.add("hdf5", name, read(path));
  };
  for (const auto layout : {Hdf5Seed::kCompact, Hdf5Seed::kContiguous, Hdf5Seed::kChunked}) {
    for (unsigned type = 0; type < 6; ++type) {
      for (const bool latest : {false, true}) {
        add(fmt::format("layout{}_type{}{}", static_cast<int>(layout), type,
                        latest ? "_latest" : ""),
            {.latest = latest, .layout = layout, .type = type});
      }
    }
    add(fmt::format("layout{}_attributes", static_cast<int>(layout)),
        {.latest = true, .layout = layout, .attributes = true});
    add(fmt::format("layout{}_old_attributes", static_cast<int>(layout)),
        {.layout = layout, .attributes = true});
    add(fmt::format("layout{}_variable_text", static_cast<int>(layout)),
        {.latest = true, .layout = layout, .type = 1, .attributes = true, .variable_length = true});
  }
  for (const int rank : {1, 2, 4, 5})
    add(fmt::format("rank{}", rank), {.latest = true, .layout = Hdf5Seed::kCompact, .rank = rank});
}

/// Headers that the files beside them fit.
void add_detached_headers(Seeds& seeds) {
  const std::string sizes = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 4 4 4\n";
  seeds.add("nhdr", "raw", sizes + "encoding: raw\ndata file: v.raw\n");
  seeds.add("nhdr", "gzip", sizes + "encoding: gzip\ndatafile: v.raw.gz\n");
  seeds.add("nhdr", "skip",
            "NRRD0005\ntype: short\nendian: big\ndimension: 3\nsizes: 2 4 3\nencoding: raw\nbyte "
            "skip: -1\ndata file: v.raw\n");
  seeds.add("nhdr", "line_skip",
            sizes +
                "encoding: raw\nline skip: 0\nspacings: 1 2 3\nunits: \"mm\" \"mm\" \"mm\"\ndata "
                "file: v.raw\n");
  seeds.add("nhdr", "list",
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 3\nencoding: raw\ndata file: "
            "LIST\nv1.raw\nv2.raw\nv3.raw\n");
  seeds.add("nhdr", "series",
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 3\nencoding: raw\ndata file: v%d.raw "
            "1 3 1\n");
  seeds.add(
      "nhdr", "space",
      sizes +
          "space: left-posterior-superior\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace "
          "origin: (4,5,6)\nspace units: \"mm\" \"mm\" \"mm\"\n"
          "kinds: domain domain domain\nkey:=value\n# comment\nencoding: raw\ndata file: v.raw\n");
}

void add_precomputed(Seeds& seeds) {
  const auto info = [](const std::string& type, const std::string& scale) {
    return R"({"@type": "neuroglancer_multiscale_volume", "type": ")" + type +
           R"(", "num_channels": 1, "data_type": "uint8", "scales": [)" + scale + "]}";
  };
  const std::string raw =
      R"({"key": "s", "size": [8, 4, 4], "resolution": [4, 4, 40.5], "voxel_offset": [0, 0, 0], "chunk_sizes": [[4, 4, 4]], "encoding": "raw"})";
  const std::string compressed =
      R"({"key": "c", "size": [4, 4, 4], "resolution": [4, 4, 40], "chunk_sizes": [[4, 4, 4]], "encoding": "compressed_segmentation", )"
      R"("compressed_segmentation_block_size": [4, 4, 4]})";
  seeds.add("precomputed_info", "raw", info("segmentation", raw));
  seeds.add("precomputed_info", "image", info("image", raw));
  std::string wide = info("segmentation", raw + ", " + compressed);
  seeds.add("precomputed_info", "two_scales", wide);
  wide.replace(wide.find("uint8"), 5, "uint32");
  seeds.add("precomputed_info", "compressed", wide);
  seeds.add("precomputed_chunk", "raw_u8", '\5' + std::string(210, '\3'));
  seeds.add("precomputed_chunk", "raw_u16", '\7' + std::string(420, '\3'));
  // Eight blocks of one label each: headers of two words, no voxels, a table of one label.
  std::string one_label{'\0', '\1', '\0', '\0', '\0'};
  for (int block = 0; block < 8; ++block)
    one_label += std::string{'\x10', 0, 0, 0, '\x10', 0, 0, 0};
  seeds.add("precomputed_chunk", "one_label_u32", one_label + std::string{7, 0, 0, 0});
}

void add_files(Seeds& seeds, const std::string& target, const fs::path& folder,
               const std::string& ending) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ending)
      seeds.add(target, entry.path().filename().string(), read(entry.path()));
  }
}

void add_records(Seeds& seeds) {
  const std::string row =
      R"({"cell":"0123456789abcdef","key":"k","stage":"decode","status":"ok","dataset":{"name":"d","voxels":64,"extent":[4,4,4]},"codec":{"id":"raw","version":1,)"
      R"("parameters":{}},"threads":1,"verification":{"method":"bytes","wrong_voxels":0},"size":{"bytes":100,"breakdown":{"header":36,"data":64}},)"
      R"("seconds":{"samples":[0.1,0.2,0.15],"median":0.15,"interval":[0.1,0.2]},"provenance":{"machine":"m","revision":"r","cpu":"c","time":"t"}})";
  seeds.add("rows", "one", row + '\n');
  seeds.add("rows", "two", row + '\n' + row + '\n');
  seeds.add("rows", "torn", row + '\n' + row.substr(0, 100));
  seeds.add("rows", "failed",
            R"({"cell":"c","key":"k","status":"failed","reason":"it did"})"
            "\n");
  seeds.add("journal", "rounds",
            R"({"cell":"c","origin":"origin","samples":{"seconds":1.5}})"
            "\n"
            R"({"cell":"c","origin":"other","samples":{"seconds":[1,2]}})"
            "\n");
  seeds.add(
      "baseline", "small",
      R"({"config": "c", "cells": {"k": {"size.bytes": 123, "size.checksums.index": "0123456789abcdef", "status": "ok"}}})");
  seeds.add(
      "noise", "machine",
      R"({"m": {"cpu": "c", "time": "t", "config": "q", "apart": {"decode": {"floor": 0.08, "cells": 12, "largest": 0.08, "median": 0.01}},)"
      R"( "interleaved": {"decode": {"floor": 0.02, "cells": 12, "largest": 0.02, "median": 0.01}}}})");
  std::string figures;
  for (int i = 0; i < 8; ++i) {
    figures += fmt::format(
        R"({{"time":"2026-01-0{}T00:00:00Z","revision":"r{}","key":"k","codec":"raw","version":1,"quantity":"seconds","kind":"time",)"
        R"("unit":"s","class":"decode","value":{},"interval":[0.9,1.1],"n":9}})"
        "\n",
        i + 1, i, i < 4 ? 1 : 2);
  }
  seeds.add("history", "step", figures);
  seeds.add(
      "history", "exact",
      R"({"time":"a","revision":"r","key":"k","codec":"raw","version":1,"quantity":"size.checksums.data","kind":"exact","unit":"","class":"","value":"00ff"})"
      "\n"
      R"({"time":"b","revision":"s","key":"k","codec":"raw","version":1,"quantity":"size.checksums.data","kind":"exact","unit":"","class":"","value":"01ff"})"
      "\n");
  seeds.add("published", "table",
            "citation: c\nhardware: h\nnotes: n\ntables:\n  t: {title: T, figures: [{dataset: d, "
            "codec: raw, parameters: {brick: 32}, rate: 5.4, seconds: 3.2},\n"
            "    {dataset: d, codec: raw, cache: none, shading: ao, frame_ms: 9.7}]}\n");
  seeds.add("settings", "config",
            "rounds=3\nmax_rounds=9\ntarget_interval=0.1\ntimeout_s=5\nmemory_limit_gib=1\nseed="
            "7\nscale=0.5\nlods=all\ntitle=x\n");
  seeds.add("settings", "filter", "codec=csgv*\nstage=encode\nthreads=1\ndataset=g\nbrick=[13]?\n");
  seeds.add("settings", "parameters", "brick=32\ndelta=1\nsampling=2\n");
  seeds.add("settings", "triple", "chunk=8,8,4\nlevel=4\nshuffle=1\n");
  seeds.add("settings", "mode", "mode=accuracy\ntolerance_log2=-4\nblock_bits=128\n");
}

}  // namespace
}  // namespace cvr::fuzz

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: fuzz_seeds OUT\n", stderr);
    return 2;
  }
  namespace fs = std::filesystem;
  const fs::path scratch = fs::path(argv[1]) / "scratch";
  fs::create_directories(scratch);
  cvr::fuzz::Seeds seeds(argv[1]);
  cvr::fuzz::add_encodings(seeds);
  cvr::fuzz::add_volume_files(seeds, scratch);
  cvr::fuzz::add_hdf5_files(seeds, scratch);
  cvr::fuzz::add_detached_headers(seeds);
  cvr::fuzz::add_precomputed(seeds);
  cvr::fuzz::add_records(seeds);
  const fs::path configs = CVR_SOURCE_DIR "/configs";
  cvr::fuzz::add_files(seeds, "scene", configs / "scenes", ".yaml");
  cvr::fuzz::add_files(seeds, "catalogue", configs / "datasets", ".yaml");
  cvr::fuzz::add_files(seeds, "config", configs, ".yaml");
  cvr::fuzz::add_files(seeds, "published", fs::path(CVR_SOURCE_DIR) / "results/published", ".yaml");
  fs::remove_all(scratch);
  std::printf("%zu seeds\n", seeds.count());
}
