#include "experiments/stages/encoded_volume.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <thread>

#include "codecs/general/xz.hpp"
#include "codecs/registry.hpp"
#include "experiments/results/error_row.hpp"
#include "volumes/io/gzip.hpp"

namespace cvr::experiments {

namespace {

constexpr int kPreset = 6;  // of both, their programs' own

std::uint64_t gzip_size(std::span<const std::byte> bytes) {
  std::uint64_t size = 0;
  volumes::GzipWriter gzip([&](std::span<const std::byte> piece) { size += piece.size(); },
                           kPreset);
  gzip.write(bytes);
  gzip.finish();
  return size;
}

std::uint64_t xz_size(std::span<const std::byte> bytes) {
  std::uint64_t size = 0;
  codecs::general::XzEncoder(kPreset).feed(
      bytes, true, [&](std::span<const std::byte> piece) { size += piece.size(); });
  return size;
}

std::filesystem::path scratch_path(const WorkerSpec& spec) {
  const std::string text =
      fmt::format("{}|{}|{}", spec.location.identity, spec.codec, spec.parameters);
  return std::filesystem::path(spec.scratch) /
         fmt::format("{:016x}.cvr", XXH3_64bits(text.data(), text.size()));
}

/// Throws StageFailure unless a lossy file's promise is kept.
void require_kept(std::string_view name, double recorded, double found) {
  if (std::abs(found - recorded) <= 1e-6 * recorded) return;
  throw StageFailure(kFailed, fmt::format("{}: the file records {}, the decoded volume has {}",
                                          name, recorded, found));
}

std::vector<Parts::Step> describe_steps(const codecs::ProgressiveAccess& access,
                                        std::uint64_t header_bytes,
                                        const volumes::VolumeSource& truth, unsigned threads) {
  std::vector<Parts::Step> steps;
  for (unsigned step = 0; step < access.steps(); ++step) {
    volumes::ErrorSink sink(truth, threads);
    checked(access.decode_step(step, threads, sink));
    const std::uint64_t bytes = header_bytes + access.step_bytes(step);
    steps.push_back({.name = std::string(access.step_name(step)),
                     .bytes = bytes,
                     .bits_per_voxel = 8.0 * static_cast<double>(bytes) /
                                       static_cast<double>(truth.info().extent.voxels()),
                     .psnr_db = finite_or_null(sink.psnr()),
                     .largest_error = finite_or_null(sink.largest_error()),
                     .seconds = {}});
  }
  return steps;
}

/// Bytes on a GPU of all buffers of a decoder of scalars; 0 where it has none.
std::uint64_t gpu_bytes(const codecs::Decoder& decoder) {
  const codecs::ProgressiveAccess* progressive = decoder.progressive_access();
  std::uint64_t bytes = 0;
  if (const auto samples =
          decoder.gpu_samples(progressive == nullptr ? 0 : progressive->steps() - 1)) {
    for (const codecs::GpuBuffer& buffer : samples->buffers) bytes += buffer.bytes.size();
  }
  return bytes;
}

/// Checksums of the parts of the file that `file` views.
Named<std::string> checksums(const codecs::OpenedFile& file, const codecs::Decoder& decoder) {
  const std::byte* begin = file.stream.payload.data() - file.header_bytes;
  Named<std::string> sums;
  for (const codecs::Section& section : codecs::sections_of(file, decoder))
    sums[section.name] =
        fmt::format("{:016x}", XXH3_64bits(begin + section.begin, section.end - section.begin));
  return sums;
}

double percent(std::uint64_t part, std::uint64_t whole) {
  return 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

Parts::Size describe_size(const codecs::OpenedFile& file, std::uint64_t file_bytes,
                          std::uint32_t bytes_per_voxel) {
  const volumes::VolumeInfo& info = file.stream.info;
  const std::uint64_t voxels = info.extent.voxels();
  const std::uint64_t accounted = bytes_per_voxel == 0 ? size_of(info.type) : bytes_per_voxel;
  if (file.breakdown.total() != file_bytes) {
    throw StageFailure(kFailed, fmt::format("the breakdown sums to {} bytes, the file has {}",
                                            file.breakdown.total(), file_bytes));
  }
  Parts::Size size;
  size.bytes = file_bytes;
  size.published_bytes = file.published_bytes;
  size.rate = percent(file_bytes, info.bytes());
  size.published_rate = percent(file.published_bytes, voxels * accounted);
  size.published_bytes_per_voxel = accounted;
  size.bits_per_voxel = 8.0 * static_cast<double>(file_bytes) / static_cast<double>(voxels);
  const auto decoder = checked(codecs::open_decoder(file));
  if (const auto& traits = file.codec->traits(); !traits.lossless && traits.gpu_scalars) {
    if (const std::uint64_t bytes = gpu_bytes(*decoder); bytes > 0) {
      size.gpu_bytes = bytes;
      size.gpu_bits_per_voxel = 8.0 * static_cast<double>(bytes) / static_cast<double>(voxels);
    }
  }
  const auto promised = file.codec->promised_error(file.stream.parameters);
  if (const auto recorded = decoder->recorded_error(); promised && recorded) {
    size.bound = *promised;
    size.bound_kept = recorded->largest <= *promised;
  }
  auto& breakdown = size.breakdown.emplace();
  for (std::size_t i = 0; i < codecs::kByteClasses; ++i) {
    const auto byte_class = static_cast<codecs::ByteClass>(i);
    breakdown[std::string(name_of(byte_class))] = file.breakdown[byte_class];
  }
  size.checksums = checksums(file, *decoder);
  return size;
}

void add_rates_at_rest(std::span<const std::byte> file, std::uint64_t original_bytes,
                       Parts::Size& size) {
  size.rate_gzip = percent(gzip_size(file), original_bytes);
  size.rate_xz = percent(xz_size(file), original_bytes);
}

void keep_in_scratch(const std::filesystem::path& path, std::string_view content) {
  const auto unfinished = path.string() + fmt::format(".{}", getpid());
  std::ofstream out(unfinished, std::ios::binary);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(unfinished, path, error);
  if (!out || error) std::filesystem::remove(unfinished, error);
}

void leave_in_scratch(const WorkerSpec& spec, std::span<const std::byte> file) {
  if (spec.scratch.empty()) return;
  std::error_code error;
  if (file.size() > std::filesystem::space(spec.scratch, error).available / 4 || error) return;
  keep_in_scratch(scratch_path(spec), {reinterpret_cast<const char*>(file.data()), file.size()});
}

codecs::Buffer obtain_encoded(const WorkerSpec& spec, const volumes::VolumeSource& source) {
  std::error_code error;
  if (!spec.scratch.empty() && std::filesystem::exists(scratch_path(spec), error)) {
    codecs::Buffer bytes(std::filesystem::file_size(scratch_path(spec)));
    std::ifstream in(scratch_path(spec), std::ios::binary);
    if (in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
      return bytes;
  }
  const codecs::Codec& codec = *codecs::find_codec(spec.codec);
  const auto parameters = checked(
      codecs::Parameters::parse(codec.parameters(), codecs::split_canonical(spec.parameters)));
  auto encoded = checked(
      codecs::encode(codec, source, parameters, std::max(1u, std::thread::hardware_concurrency())));
  leave_in_scratch(spec, encoded.bytes.bytes());
  return std::move(encoded.bytes);
}

Named<double> describe_recorded(const codecs::RecordedError& recorded) {
  return {{"largest_error", recorded.largest}, {"mean_squared_error", recorded.mean_squared}};
}

void verify(std::span<const std::byte> bytes, const volumes::VolumeSource& truth, unsigned threads,
            Parts& parts) {
  const auto file = checked(codecs::open_file(bytes));
  const auto decoder = checked(codecs::open_decoder(file));
  const std::uint64_t voxels = truth.info().extent.voxels();
  const auto report = [&](std::uint64_t compared, std::uint64_t mismatches) {
    parts.verification.emplace();
    parts.verification->voxels_compared = compared;
    parts.verification->mismatches = mismatches;
    if (compared != voxels)
      throw StageFailure(kFailed,
                         fmt::format("decoding delivered {} of {} voxels", compared, voxels));
  };
  if (file.codec->traits().lossless) {
    volumes::CompareSink sink(truth);
    checked(decoder->decode(0, threads, sink));
    report(sink.compared(), sink.mismatches());
    if (sink.mismatches() == 0) return;
    throw StageFailure(kFailed, fmt::format("{} of {} decoded voxels differ from the original",
                                            sink.mismatches(), sink.compared()));
  }
  volumes::ErrorSink sink(truth, threads);
  checked(decoder->decode(0, threads, sink));
  report(sink.compared(), sink.mismatches());
  parts.error = describe_errors(sink);
  const auto recorded = decoder->recorded_error();
  if (!recorded) throw StageFailure(kFailed, "the codec is lossy, and its file records no error");
  parts.error->recorded = describe_recorded(*recorded);
  require_kept("largest error", recorded->largest, sink.largest_error());
  require_kept("mean squared error", recorded->mean_squared, sink.mean_squared_error());
  if (const auto* access = decoder->progressive_access())
    parts.steps = describe_steps(*access, file.header_bytes, truth, threads);
}

void verify_once(const WorkerSpec& spec, std::span<const std::byte> bytes,
                 const volumes::VolumeSource& truth, Parts& parts) {
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  if (spec.scratch.empty()) return verify(bytes, truth, cores, parts);
  const auto path = std::filesystem::path(spec.scratch) /
                    fmt::format("{}-{:016x}.verified", spec.location.identity,
                                XXH3_64bits(bytes.data(), bytes.size()));
  Row found;
  if (std::ifstream in(path); in) found = Row::parse(in, nullptr, false);
  if (!found.is_object()) {
    Parts verified;
    verify(bytes, truth, cores, verified);
    found = to_json(verified);
    keep_in_scratch(path, found.dump());
  }
  const auto known = from_json<Parts>(found);
  parts.verification = known.verification;
  parts.error = known.error;
  parts.steps = known.steps;
}

}  // namespace cvr::experiments
