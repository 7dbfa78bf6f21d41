// encode, decode, validate
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "experiments/cli/arguments.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "experiments/config/yaml_reader.hpp"
#include "experiments/run/memory.hpp"
#include "experiments/stages/encoded_volume.hpp"
#include "volumes/io/file.hpp"
#include "volumes/io/io.hpp"
#include "volumes/plain_text.hpp"
#include "volumes/slab_pipe.hpp"

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

constexpr std::uint64_t kPageBytes = 4096;

/// A volume of at most a quarter of the memory that is left is read before it is encoded, so that
/// the time is that of the work on memory. A larger one is streamed: drawn from its file while it
/// is encoded, and the time includes reading.
class OriginalInMemory {
 public:
  explicit OriginalInMemory(const volumes::VolumeSource& file)
      : file_(file), streamed_(file.info().bytes() > usable_memory() / 4) {
    if (streamed_) return;
    if (file.data() == nullptr) {
      volume_ = volumes::read_all(file);
      read_.emplace(volume_);
      return;
    }
    // Mapped: each page is asked for once.
    [[maybe_unused]] volatile std::byte touched;
    for (std::uint64_t at = 0; at < file.info().bytes(); at += kPageBytes)
      touched = file.data()[at];
  }
  const volumes::VolumeSource& source() const { return read_ ? *read_ : file_; }
  bool streamed() const { return streamed_; }

 private:
  const volumes::VolumeSource& file_;
  bool streamed_;
  volumes::Volume volume_;
  std::optional<volumes::MemorySource> read_;
};

void report_encoding(const Row& report) {
  fmt::print(
      "{}: {} bytes, {:.3f} % of {} bytes ({:.4f} bits per voxel), published accounting {} bytes, "
      "{:.3f} %; "
      "{:.3f} s{}\n",
      volumes::printable(report["file"].get<std::string>()), report["bytes"].get<std::uint64_t>(),
      report["rate"].get<double>(), report["original_bytes"].get<std::uint64_t>(),
      report["bits_per_voxel"].get<double>(), report["published_bytes"].get<std::uint64_t>(),
      report["published_rate"].get<double>(), report["seconds"].get<double>(),
      report["streamed"].get<bool>() ? ", reading included" : "");
  if (report.contains("bound_kept")) {
    fmt::print("  bound kept: {} (largest error {}, allowed {})\n",
               report["bound_kept"].get<bool>() ? "yes" : "no",
               report["recorded_error"]["largest_error"].get<double>(),
               report["bound"].get<double>());
  }
  for (const auto& [name, bytes] : report["breakdown"].items()) {
    if (bytes.get<std::uint64_t>() > 0)
      fmt::print("  {:<11} {:>14}\n", name, bytes.get<std::uint64_t>());
  }
}

/// Returns kExitCheckFailed where the parameters promise an error that was not kept: the file is
/// written, and says so.
int encode(const EncodeOptions& options) {
  const auto [codec, parameters] = parse_codec(options.codec, options.parameters);
  const auto opened = volumes::open_volume(options.in, options.volume.options());
  volumes::refuse_to_replace({options.out}, opened->files());
  volumes::check_output(options.out);
  const OriginalInMemory original(*opened);
  const volumes::VolumeSource& source = original.source();
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
  const auto decoder = codecs::open_decoder(*file);
  if (!decoder) fail_on_file(options.out, decoder.error());
  if (const auto recorded = (*decoder)->recorded_error())
    report["recorded_error"] = to_json(describe_recorded(*recorded));
  Parts::Size size = describe_size(*file, bytes.size(), options.bytes_per_voxel);
  if (codec->traits().stored_compressed && options.json)
    add_rates_at_rest(bytes, source.info().bytes(), size);
  report.update(to_json(size));
  report["streamed"] = original.streamed();
  report["seconds"] = time.wall_seconds;
  report["cpu_seconds"] = time.cpu_seconds;
  options.json ? print_json(report) : report_encoding(report);
  return report.value("bound_kept", true) ? kExitOk : kExitCheckFailed;
}

struct DecodeOptions {
  std::string in, out;
  unsigned lod = 0, threads = 1;
};

void decode(const DecodeOptions& options) {
  if (!volumes::is_volume_path(options.out)) {
    throw volumes::InputError(fmt::format(
        "{}: expected the name of a volume (.h5, .nrrd, .nhdr, .nii, .nii.gz, .raw or a folder)",
        options.out));
  }
  volumes::check_volume_output(options.out, {options.in});
  const volumes::MappedFile bytes(options.in);
  const auto file = codecs::open_file(bytes.bytes());
  if (!file) fail_on_file(options.in, file.error());
  const auto decoder = codecs::open_decoder(*file);
  if (!decoder) fail_on_file(options.in, decoder.error());
  if (options.lod >= (*decoder)->levels()) {
    throw volumes::InputError(fmt::format("{}: level of detail: expected 0..{}, found {}",
                                          options.in, (*decoder)->levels() - 1, options.lod));
  }
  volumes::write_volume(
      options.out, volumes::SlabPipe(codecs::level_info(file->stream.info, options.lod), options.in,
                                     [&](volumes::SlabSink& sink) {
                                       return (*decoder)->decode(options.lod, options.threads,
                                                                 sink);
                                     }));
}

struct ValidateOptions {
  std::vector<std::string> files;
  unsigned threads = 1;
};

int validate(const ValidateOptions& options) {
  int exit_code = kExitOk;
  for (const std::string& path : options.files) {
    const volumes::MappedFile bytes(path);
    const auto valid = codecs::validate(bytes.bytes(), options.threads);
    fmt::print("{}: {}\n", volumes::printable(path),
               valid ? "valid" : volumes::printable(valid.error().message));
    if (!valid) exit_code = kExitCheckFailed;
  }
  return exit_code;
}

}  // namespace

std::pair<const codecs::Codec*, codecs::Parameters> parse_codec(
    const std::string& id, const std::vector<std::string>& parameters) {
  const codecs::Codec* codec = codecs::find_codec(id);
  if (codec == nullptr) {
    const auto ids = codec_ids();
    throw volumes::InputError(fmt::format("--codec: expected one of {}, found '{}'{}",
                                          fmt::join(ids, ", "), id, did_you_mean(id, ids)));
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
  encoding->add_option("-p", e->parameters, "NAME=VALUE, a parameter of the codec")
      ->allow_extra_args(false);
  encoding->add_option("--threads", e->threads, "threads; the bytes do not depend on it")
      ->check(integer_in(1, kMostThreads));
  add_volume_choices(*encoding, e->volume);
  encoding
      ->add_option("--bytes-per-voxel", e->bytes_per_voxel,
                   "of the original in published_rate: the smallest of 1, 2, 4 that can number the "
                   "labels is "
                   "the papers' accounting "
                   "(default: the stored type)")
      ->check(integer_in(1, 8));
  encoding->add_flag(
      "--json", e->json,
      "one object: bytes, published_bytes, rate (percent of the original's bytes), "
      "published_rate (percent, by the "
      "papers' accounting), bits_per_voxel, breakdown, seconds; rate_gzip and rate_xz where "
      "files are usually stored so");
  encoding->callback([e, &exit_code] {
    const InterruptWatch watch;
    exit_code = encode(*e);
  });

  auto d = std::make_shared<DecodeOptions>();
  auto* decoding = app.add_subcommand("decode", "Decodes an encoded file into a volume file");
  decoding->add_option("file", d->in, "encoded file")->required();
  decoding->add_option("-o", d->out, "volume file to write")->required();
  decoding->add_option("--lod", d->lod, "level of detail, 0 is the finest")
      ->check(integer_in(0, 63));
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
