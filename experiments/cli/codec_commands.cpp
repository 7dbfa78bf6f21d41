// encode, decode, validate
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "experiments/cli/arguments.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "experiments/stages/encoded_volume.hpp"
#include "experiments/yaml_reader.hpp"
#include "volumes/io/file.hpp"
#include "volumes/io/io.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments::cli {

namespace {

std::vector<std::string> codec_ids() {
  std::vector<std::string> ids;
  for (const codecs::Codec* codec : codecs::all_codecs()) ids.emplace_back(codec->traits().id);
  return ids;
}

struct EncodeOptions {
  std::string in, out, codec;
  VolumeChoices volume;
  std::vector<std::string> parameters;
  unsigned threads = 1;
  std::uint32_t bytes_per_voxel = 0;
  bool json = false;
};

void report_encoding(const Row& report) {
  fmt::print(
      "{}: {} bytes, {:.3f} % of {} bytes ({:.4f} bits a voxel), published accounting {} bytes, {:.3f} %; "
      "{:.3f} s\n",
      volumes::printable(report["file"].get<std::string>()), report["bytes"].get<std::uint64_t>(), report["rate"].get<double>(),
      report["original_bytes"].get<std::uint64_t>(), report["bits_per_voxel"].get<double>(),
      report["published_bytes"].get<std::uint64_t>(), report["published_rate"].get<double>(),
      report["seconds"].get<double>());
  for (const auto& [name, bytes] : report["breakdown"].items()) {
    if (bytes.get<std::uint64_t>() > 0) fmt::print("  {:<11} {:>14}\n", name, bytes.get<std::uint64_t>());
  }
}

void encode(const EncodeOptions& options) {
  const auto [codec, parameters] = parse_codec(options.codec, options.parameters);
  const auto opened = volumes::open_volume(options.in, options.volume.options());
  volumes::refuse_to_replace({options.out}, opened->files());
  volumes::check_output(options.out);
  // The time is that of the work on memory, so the file is read first.
  const volumes::Volume volume = opened->data() == nullptr ? volumes::read_all(*opened) : volumes::Volume();
  const volumes::MemorySource source(opened->info(),
                                     opened->data() == nullptr ? volume.data() : opened->data());
  const Stopwatch watch;
  const auto encoded = codecs::encode(*codec, source, parameters, options.threads);
  const Sample time = watch.lap("encode", source.info().extent.voxels());
  if (!encoded) fail_on_file(options.in, encoded.error());
  const auto bytes = encoded->bytes.bytes();
  write_file(options.out, bytes);
  const auto file = codecs::open_file(bytes);
  if (!file) fail_on_file(options.out, file.error());
  Row report;
  report["file"] = options.out;
  report["codec"] = options.codec;
  report["parameters"] = parameters.values();
  report["threads"] = options.threads;
  report["original_bytes"] = source.info().bytes();
  Row size = describe_size(*file, bytes.size(), options.bytes_per_voxel);
  if (codec->traits().stored_compressed && options.json)
    add_rates_at_rest(bytes, source.info().bytes(), size);
  for (const auto& [key, value] : size.items()) report[key] = value;
  report["seconds"] = time.wall_seconds;
  report["cpu_seconds"] = time.cpu_seconds;
  options.json ? print_json(report) : report_encoding(report);
}

struct DecodeOptions {
  std::string in, out;
  unsigned lod = 0, threads = 1;
};

void decode(const DecodeOptions& options) {
  if (!volumes::is_volume_path(options.out)) {
    throw volumes::InputError(
        fmt::format("{}: expected the name of a volume (.h5, .nrrd, .nhdr, .nii, .nii.gz, .raw or a folder)",
                    options.out));
  }
  volumes::check_volume_output(options.out, {options.in});
  const volumes::Buffer bytes = read_file(options.in);
  const auto volume = codecs::decode(bytes.bytes(), options.lod, options.threads);
  if (!volume && volume.error().code == volumes::ErrorCode::kOutOfMemory) throw std::bad_alloc();
  if (!volume) fail_on_file(options.in, volume.error());
  volumes::write_volume(options.out, volumes::MemorySource(*volume));
}

struct ValidateOptions {
  std::vector<std::string> files;
  unsigned threads = 1;
};

int validate(const ValidateOptions& options) {
  int exit_code = kExitOk;
  for (const std::string& path : options.files) {
    const volumes::Buffer bytes = read_file(path);
    const auto valid = codecs::validate(bytes.bytes(), options.threads);
    fmt::print("{}: {}\n", volumes::printable(path), valid ? "valid" : volumes::printable(valid.error().message));
    if (!valid) exit_code = kExitCheckFailed;
  }
  return exit_code;
}

}  // namespace

std::pair<const codecs::Codec*, codecs::Parameters> parse_codec(const std::string& id,
                                                                const std::vector<std::string>& parameters) {
  const codecs::Codec* codec = codecs::find_codec(id);
  if (codec == nullptr) {
    const auto ids = codec_ids();
    throw volumes::InputError(fmt::format("--codec: expected one of {}, found '{}'{}", fmt::join(ids, ", "),
                                          id, did_you_mean(id, ids)));
  }
  auto parsed = codecs::Parameters::parse(codec->parameters(), parameters);
  if (!parsed) throw volumes::InputError(fmt::format("-p: {}: {}", id, parsed.error().message));
  return {codec, std::move(*parsed)};
}

void add_codec_commands(CLI::App& app, int& exit_code) {
  auto e = std::make_shared<EncodeOptions>();
  auto* encoding = app.add_subcommand(
      "encode", "Encodes a volume file; reports size, rates in percent, breakdown and seconds");
  encoding->add_option("in", e->in, "volume file")->required();
  encoding->add_option("-o", e->out, "encoded file to write")->required();
  encoding->add_option("--codec", e->codec, "id of the codec ('list codecs')")->required();
  encoding->add_option("-p", e->parameters, "NAME=VALUE, a parameter of the codec")->allow_extra_args(false);
  encoding->add_option("--threads", e->threads, "threads; the bytes do not depend on it")
      ->check(integer_in(1, kMostThreads));
  add_volume_choices(*encoding, e->volume);
  encoding
      ->add_option("--bytes-per-voxel", e->bytes_per_voxel,
                   "of the original in published_rate: the smallest of 1, 2, 4 that can number the labels is "
                   "the papers' accounting "
                   "(default: the stored type)")
      ->check(integer_in(1, 8));
  encoding->add_flag("--json", e->json,
                     "one object: bytes, published_bytes, rate (percent of the original's bytes), "
                     "published_rate (percent, by the "
                     "papers' accounting), bits_per_voxel, breakdown, seconds; rate_gzip and rate_xz where "
                     "files are usually stored so");
  encoding->callback([e, &exit_code] {
    const InterruptWatch watch;
    encode(*e);
    exit_code = kExitOk;
  });

  auto d = std::make_shared<DecodeOptions>();
  auto* decoding = app.add_subcommand("decode", "Decodes an encoded file into a volume file");
  decoding->add_option("file", d->in, "encoded file")->required();
  decoding->add_option("-o", d->out, "volume file to write")->required();
  decoding->add_option("--lod", d->lod, "level of detail, 0 is the finest")->check(integer_in(0, 63));
  decoding->add_option("--threads", d->threads, "threads")->check(integer_in(1, kMostThreads));
  decoding->callback([d, &exit_code] {
    const InterruptWatch watch;
    decode(*d);
    exit_code = kExitOk;
  });

  auto v = std::make_shared<ValidateOptions>();
  auto* validating = app.add_subcommand(
      "validate", "Decodes everything in encoded files and throws it away; 1 if one is broken");
  validating->add_option("files", v->files, "encoded files")->required();
  validating->add_option("--threads", v->threads, "threads")->check(integer_in(1, kMostThreads));
  validating->callback([v, &exit_code] { exit_code = validate(*v); });
}

}  // namespace cvr::experiments::cli
