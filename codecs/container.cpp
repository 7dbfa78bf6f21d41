#include "codecs/container.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>

#include "codecs/bytes.hpp"
#include "codecs/registry.hpp"

namespace cvr::codecs {

namespace {

constexpr std::string_view kMagic = "CVRBENCH";
/// What a volume rarely has takes a version of its own, so that the bytes of all others are what
/// they were before.
constexpr std::uint32_t kVolumeVersion = 1, kSeriesVersion = 2, kPlacedVersion = 3;

std::uint32_t version_for(const VolumeInfo& info) {
  if (std::ranges::any_of(info.offset, [](double o) { return o != 0; })) return kPlacedVersion;
  return info.time_steps > 1 ? kSeriesVersion : kVolumeVersion;
}

constexpr std::size_t kAlignment = 8;  // of header and payload: decoders read words in place
constexpr std::size_t kHeaderHashOffset = 32;
constexpr std::size_t kFixedHeaderBytes = 96;
constexpr std::size_t kAccountBytes =
    8 * (1 + kByteClasses);  // published bytes and breakdown, at the header's end
constexpr std::uint64_t kMaxAxis = std::uint64_t{1} << 40;
constexpr std::uint64_t kMaxVoxels = std::uint64_t{1} << 50;

std::uint64_t header_hash(std::span<const std::byte> header) {
  Buffer copy;
  copy.append(header);
  std::fill_n(copy.data() + kHeaderHashOffset, 8, std::byte{0});
  return XXH3_64bits(copy.data(), copy.size());
}

Buffer make_header(const Codec& codec, const VolumeInfo& info, const Parameters& parameters,
                   const Payload& encoded) {
  const Buffer& payload = encoded.bytes;
  ByteWriter out;
  out.text(kMagic);
  const std::uint32_t version = version_for(info);
  out.put(version);
  const std::size_t size_at = out.size();
  out.put(std::uint32_t{0});
  out.put(static_cast<std::uint64_t>(payload.size()));
  out.put(static_cast<std::uint64_t>(XXH3_64bits(payload.data(), payload.size())));
  out.put(std::uint64_t{0});
  out.put(codec.traits().version);
  out.put(static_cast<std::uint8_t>(info.type));
  out.put(static_cast<std::uint8_t>(info.kind));
  out.put(std::uint16_t{0});
  for (const std::uint64_t n : {info.extent.x, info.extent.y, info.extent.z}) out.put(n);
  for (const double size : info.voxel_size) out.put(size);
  if (version >= kSeriesVersion) out.put(info.time_steps);
  if (version >= kPlacedVersion) {
    for (const double offset : info.offset) out.put(offset);
  }
  const std::string canonical = parameters.canonical();
  for (const std::string_view text :
       {codec.traits().id, std::string_view(canonical), std::string_view(info.voxel_unit)}) {
    out.put(narrow<std::uint16_t>(text.size()));
    out.text(text);
  }
  out.align(kAlignment);
  ByteBreakdown breakdown = encoded.breakdown;
  breakdown[ByteClass::kHeader] += out.size() + kAccountBytes;
  out.put(encoded.published_bytes);
  for (std::size_t i = 0; i < kByteClasses; ++i) out.put(breakdown[static_cast<ByteClass>(i)]);
  Buffer header = out.take();
  const auto size = narrow<std::uint32_t>(header.size());
  std::memcpy(header.data() + size_at, &size, sizeof size);
  const std::uint64_t hash = header_hash(header.bytes());
  std::memcpy(header.data() + kHeaderHashOffset, &hash, sizeof hash);
  return header;
}

Expected<void> check_encodable(const Codec& codec, const VolumeInfo& info) {
  if (auto accepted = accepts(codec.traits(), info); !accepted) return accepted;
  const Extent& e = info.extent;
  if (e.x == 0 || e.y == 0 || e.z == 0)
    return fail(ErrorCode::kBadArgument, "the volume is empty: " + to_string(e));
  if (e.x > kMaxAxis || e.y > kMaxAxis || e.z > kMaxAxis || e.x > kMaxVoxels / e.y ||
      e.x * e.y > kMaxVoxels / e.z) {
    return fail(ErrorCode::kTooLarge,
                "the volume exceeds 2^40 voxels per axis or 2^50 voxels: " + to_string(e));
  }
  if (info.time_steps == 0 || e.z % info.time_steps != 0) {
    return fail(
        ErrorCode::kBadArgument,
        fmt::format("expected time steps that divide {} planes, found {}", e.z, info.time_steps));
  }
  return {};
}

/// Throws the slabs away.
class NullSink final : public SlabSink {
 public:
  explicit NullSink(const VolumeInfo& info) : info_(info) {}
  std::uint64_t preferred_depth() const override { return 1; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    slab_.resize((z1 - z0) * info_.extent.x * info_.extent.y * size_of(info_.type));
    return slab_.data();
  }
  void end(std::uint64_t, std::uint64_t) override {}

 private:
  VolumeInfo info_;
  Buffer slab_;
};

}  // namespace

Expected<Encoded> encode(const Codec& codec, const VolumeSource& source,
                         const Parameters& parameters, unsigned threads) {
  const VolumeInfo& info = source.info();
  if (auto ok = check_encodable(codec, info); !ok) return tl::unexpected(ok.error());
  auto payload = codec.encode(source, parameters, threads);
  if (!payload) return tl::unexpected(payload.error());
  const Buffer header = make_header(codec, info, parameters, *payload);
  // The header goes in front of the payload in the same block: a second copy of the payload would
  // double the memory.
  Encoded encoded{std::move(payload->bytes), payload->breakdown, payload->published_bytes};
  const std::size_t payload_size = encoded.bytes.size();
  encoded.bytes.reserve(payload_size + header.size());
  encoded.bytes.resize(payload_size + header.size());
  if (payload_size > 0)
    std::memmove(encoded.bytes.data() + header.size(), encoded.bytes.data(), payload_size);
  std::memcpy(encoded.bytes.data(), header.data(), header.size());
  encoded.breakdown[ByteClass::kHeader] += header.size();
  return encoded;
}

Expected<OpenedFile> open_file(std::span<const std::byte> bytes) {
  if (reinterpret_cast<std::uintptr_t>(bytes.data()) % kAlignment != 0) {
    return fail(
        ErrorCode::kBadArgument,
        fmt::format("the bytes of a file must lie at a multiple of {} in memory", kAlignment));
  }
  ByteReader in(bytes);
  constexpr std::size_t kLeast = kFixedHeaderBytes + kAccountBytes;
  if (bytes.size() < kLeast) {
    return fail(
        ErrorCode::kTruncated,
        fmt::format("expected a header of at least {} bytes, found {}", kLeast, bytes.size()));
  }
  if (in.text(kMagic.size()) != kMagic)
    return fail(ErrorCode::kMalformed, "offset 0: expected the magic 'CVRBENCH'");
  const auto container_version = in.get<std::uint32_t>();
  if (container_version < kVolumeVersion || container_version > kPlacedVersion) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("offset 8: expected container version {} to {}, found {}",
                            kVolumeVersion, kPlacedVersion, container_version));
  }
  const auto header_size = in.get<std::uint32_t>();
  const auto payload_size = in.get<std::uint64_t>();
  if (header_size < kLeast || header_size > bytes.size() ||
      payload_size != bytes.size() - header_size) {
    return fail(
        ErrorCode::kTruncated,
        fmt::format("offset 12: header of {} and payload of {} bytes announced, the file has {}",
                    header_size, payload_size, bytes.size()));
  }
  if (header_size % kAlignment != 0) {
    return fail(ErrorCode::kMalformed,
                fmt::format("offset 12: expected a header of a multiple of 8 bytes, found {}",
                            header_size));
  }
  const auto header = bytes.first(header_size);
  const auto payload = bytes.subspan(header_size);
  const auto payload_hash = in.get<std::uint64_t>();
  if (in.get<std::uint64_t>() != header_hash(header)) {
    return fail(ErrorCode::kChecksum, "offset 32: the header's checksum does not match");
  }
  if (payload_hash != XXH3_64bits(payload.data(), payload.size())) {
    return fail(ErrorCode::kChecksum, "offset 24: the payload's checksum does not match");
  }
  const auto codec_version = in.get<std::uint32_t>();
  const auto type = in.get<std::uint8_t>();
  const auto kind = in.get<std::uint8_t>();
  in.get<std::uint16_t>();
  VolumeInfo info;
  info.extent = {in.get<std::uint64_t>(), in.get<std::uint64_t>(), in.get<std::uint64_t>()};
  for (double& size : info.voxel_size) size = in.get<double>();
  if (container_version >= kSeriesVersion) {
    info.time_steps = in.get<std::uint64_t>();
    const std::uint64_t least = container_version == kSeriesVersion ? 2 : 1;
    if (info.time_steps < least)
      return fail(ErrorCode::kMalformed,
                  fmt::format("offset 96: expected {} or more time steps, found {}", least,
                              info.time_steps));
  }
  if (container_version >= kPlacedVersion) {
    for (double& offset : info.offset) offset = in.get<double>();
    if (!std::ranges::all_of(info.offset, [](double o) { return std::isfinite(o); }))
      return fail(ErrorCode::kMalformed, "offset 104: expected a finite offset");
  }
  std::array<std::string, 3> texts;
  for (std::string& text : texts) {
    const auto length = in.get<std::uint16_t>();
    text = in.text(length);
  }
  if (in.failed() || in.position() > header_size - kAccountBytes)
    return fail(ErrorCode::kMalformed, "a string leaves the header");
  const Codec* codec = find_codec(texts[0]);
  if (codec == nullptr)
    return fail(ErrorCode::kUnsupported, fmt::format("unknown codec '{}'", texts[0]));
  if (codec_version != codec->traits().version) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("offset 40: expected version {} of {}, found {}",
                            codec->traits().version, texts[0], codec_version));
  }
  if (type >= volumes::kVoxelTypes.size() || kind > 1)
    return fail(ErrorCode::kMalformed, "offset 44: unknown voxel type or kind");
  info.type = static_cast<VoxelType>(type);
  info.kind = static_cast<VolumeKind>(kind);
  info.voxel_unit = texts[2];
  if (auto ok = check_encodable(*codec, info); !ok) return tl::unexpected(ok.error());
  auto parameters = Parameters::parse(codec->parameters(), split_canonical(texts[1]));
  if (!parameters) return tl::unexpected(parameters.error());
  ByteReader account(header.last(kAccountBytes));
  OpenedFile file{codec,
                  Stream{info, std::move(*parameters), payload},
                  header_size,
                  account.get<std::uint64_t>(),
                  {}};
  for (std::size_t i = 0; i < kByteClasses; ++i)
    file.breakdown[static_cast<ByteClass>(i)] = account.get<std::uint64_t>();
  if (file.breakdown.total() != bytes.size()) {
    return fail(ErrorCode::kMalformed,
                fmt::format("offset {}: expected a breakdown that sums to {} bytes, found {}",
                            header_size - kAccountBytes, bytes.size(), file.breakdown.total()));
  }
  return file;
}

Expected<std::unique_ptr<Decoder>> open_decoder(const OpenedFile& file) {
  return file.codec->open(file.stream);
}

std::vector<Section> sections_of(const OpenedFile& file, const Decoder& decoder) {
  std::vector<Section> sections{{"envelope", 0, file.header_bytes}};
  const std::uint64_t end = file.header_bytes + file.stream.payload.size();
  const auto up_to = [&](std::string name, std::uint64_t to) {
    if (to > sections.back().end)
      sections.push_back({std::move(name), sections.back().end, std::min(to, end)});
  };
  if (const ProgressiveAccess* steps = decoder.progressive_access()) {
    for (unsigned step = 0; step < steps->steps(); ++step)
      up_to(fmt::format("step {}", steps->step_name(step)),
            file.header_bytes + steps->step_bytes(step));
  } else {
    std::uint64_t at = file.header_bytes;
    for (const auto& [byte_class, bytes, alignment] : file.codec->traits().front) {
      at = file.header_bytes + (at - file.header_bytes + alignment - 1) / alignment * alignment;
      at += bytes > 0 ? bytes
                      : file.breakdown[byte_class] -
                            (byte_class == ByteClass::kHeader ? file.header_bytes : 0);
      up_to(std::string(name_of(byte_class)), at);
    }
  }
  up_to(sections.size() == 1 ? "payload" : "rest", end);
  return sections;
}

Expected<Volume> decode(std::span<const std::byte> bytes, unsigned lod, unsigned threads) {
  auto file = open_file(bytes);
  if (!file) return tl::unexpected(file.error());
  auto decoder = open_decoder(*file);
  if (!decoder) return tl::unexpected(decoder.error());
  if (lod >= (*decoder)->levels()) {
    return fail(ErrorCode::kBadArgument, fmt::format("level of detail: expected 0..{}, found {}",
                                                     (*decoder)->levels() - 1, lod));
  }
  try {
    volumes::VolumeSink sink(level_info(file->stream.info, lod));
    if (auto ok = (*decoder)->decode(lod, threads, sink); !ok) return tl::unexpected(ok.error());
    return sink.take();
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory,
                "not enough memory for " + to_string(level_extent(file->stream.info.extent, lod)));
  }
}

Expected<void> validate(std::span<const std::byte> bytes, unsigned threads) {
  auto file = open_file(bytes);
  if (!file) return tl::unexpected(file.error());
  auto decoder = open_decoder(*file);
  if (!decoder) return tl::unexpected(decoder.error());
  for (unsigned lod = 0; lod < (*decoder)->levels(); ++lod) {
    NullSink sink(level_info(file->stream.info, lod));
    if (auto ok = (*decoder)->decode(lod, threads, sink); !ok) return ok;
  }
  return {};
}

}  // namespace cvr::codecs
