// zstd: the voxels as one frame, with its content size, without a checksum (the envelope has one).
//
// One thread, one frame: jobs of a multi-threaded frame would change the bytes. The decoder bounds
// its output by the volume and its window by kMaxWindowLog.
#include <fmt/format.h>
#include <zstd.h>

#include <memory>

#include "codecs/general/general.hpp"
#include "codecs/general/slabs.hpp"

namespace cvr::codecs {

namespace {

/// The largest window that levels 1..22 use.
constexpr int kMaxWindowLog = 27;
/// A block takes at least 3 bytes and holds at most 128 KiB.
constexpr std::uint64_t kBlockHeaderBytes = 3;
constexpr std::uint64_t kMaxBlockBytes = std::uint64_t{128} << 10;

class ZstdDecoder final : public Decoder {
 public:
  explicit ZstdDecoder(const Stream& stream) : info_(stream.info), payload_(stream.payload) {}

  Expected<void> decode(unsigned, unsigned, SlabSink& sink) const override {
    const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                       &ZSTD_freeDCtx);
    if (!context) return fail(ErrorCode::kOutOfMemory, "not enough memory for a zstd decoder");
    ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kMaxWindowLog);
    ZSTD_inBuffer in{payload_.data(), payload_.size(), 0};
    std::size_t hint = 1;
    const auto pull = [&](ZSTD_outBuffer& out) -> Expected<bool> {
      const std::size_t in_before = in.pos, out_before = out.pos;
      hint = ZSTD_decompressStream(context.get(), &out, &in);
      if (ZSTD_isError(hint) != 0) {
        return fail(ErrorCode::kMalformed,
                    fmt::format("offset {}: {}", in.pos, ZSTD_getErrorName(hint)));
      }
      return in.pos != in_before || out.pos != out_before;
    };
    auto filled =
        general::fill_slabs(info_, sink, [&](std::span<std::byte> slab) -> Expected<void> {
          ZSTD_outBuffer out{slab.data(), slab.size(), 0};
          while (out.pos < out.size) {
            // A finished frame would be followed by the next one: there is only one.
            if (hint == 0)
              return fail(ErrorCode::kTruncated, "the frame holds fewer voxels than the volume");
            const auto moved = pull(out);
            if (!moved) return tl::unexpected(moved.error());
            if (!*moved)
              return fail(ErrorCode::kTruncated,
                          fmt::format("offset {}: the frame is cut off", in.pos));
          }
          return {};
        });
    if (!filled) return filled;
    std::byte surplus;
    ZSTD_outBuffer out{&surplus, 1, 0};
    while (hint != 0) {
      const auto moved = pull(out);
      if (!moved) return tl::unexpected(moved.error());
      if (out.pos != 0)
        return fail(ErrorCode::kMalformed, "the frame holds more voxels than the volume");
      if (!*moved)
        return fail(ErrorCode::kTruncated, fmt::format("offset {}: the frame is cut off", in.pos));
    }
    if (in.pos != in.size) {
      return fail(ErrorCode::kMalformed,
                  fmt::format("offset {}: {} bytes follow the frame", in.pos, in.size - in.pos));
    }
    return {};
  }

 private:
  VolumeInfo info_;
  std::span<const std::byte> payload_;
};

class ZstdCodec final : public Codec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits{.id = "zstd",
                                .version = 1,
                                .family = "general",
                                .summary = "the voxels as one zstd frame",
                                .lossless = true,
                                .types = volumes::kVoxelTypes,
                                .access = Granularity::kVolume,
                                .levels_of_detail = false,
                                .stored_compressed = false};
    return kTraits;
  }
  std::span<const ParameterSpec> parameters() const override {
    static const std::array kParameters{ParameterSpec{.name = "level",
                                                      .type = ParameterType::kInteger,
                                                      .default_value = "3",
                                                      .minimum = 1,
                                                      .maximum = 22,
                                                      .description = "compression level of zstd"}};
    return kParameters;
  }

  Expected<Payload> encode(const VolumeSource& source, const Parameters& parameters,
                           unsigned) const override {
    const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                       &ZSTD_freeCCtx);
    if (!context) return fail(ErrorCode::kOutOfMemory, "not enough memory for a zstd encoder");
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel,
                           static_cast<int>(parameters.integer("level")));
    ZSTD_CCtx_setPledgedSrcSize(context.get(), source.info().bytes());
    Payload payload{};
    Buffer piece(ZSTD_CStreamOutSize());
    auto fed = general::feed_slabs(
        source, [&](std::span<const std::byte> slab, bool last) -> Expected<void> {
          ZSTD_inBuffer in{slab.data(), slab.size(), 0};
          for (bool done = false; !done;) {
            ZSTD_outBuffer out{piece.data(), piece.size(), 0};
            const std::size_t left =
                ZSTD_compressStream2(context.get(), &out, &in, last ? ZSTD_e_end : ZSTD_e_continue);
            if (ZSTD_isError(left) != 0)
              return fail(ErrorCode::kOutOfMemory, ZSTD_getErrorName(left));
            payload.bytes.append(piece.data(), out.pos);
            done = last ? left == 0 : in.pos == in.size;
          }
          return {};
        });
    if (!fed) return tl::unexpected(fed.error());
    payload.breakdown[ByteClass::kData] = payload.published_bytes = payload.bytes.size();
    return payload;
  }

  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const override {
    const std::uint64_t wanted = stream.info.bytes();
    const unsigned long long announced =
        ZSTD_getFrameContentSize(stream.payload.data(), stream.payload.size());
    if (announced == ZSTD_CONTENTSIZE_ERROR)
      return fail(ErrorCode::kMalformed, "offset 0: expected a zstd frame");
    if (announced != wanted) {
      return fail(
          ErrorCode::kMalformed,
          announced == ZSTD_CONTENTSIZE_UNKNOWN
              ? fmt::format("offset 0: expected a frame of {} bytes, found one of unknown size",
                            wanted)
              : fmt::format("offset 0: expected a frame of {} bytes, found one of {}", wanted,
                            announced));
    }
    if (wanted / kMaxBlockBytes > stream.payload.size() / kBlockHeaderBytes) {
      return fail(ErrorCode::kTruncated, fmt::format("{} bytes cannot hold {} bytes of voxels",
                                                     stream.payload.size(), wanted));
    }
    return std::make_unique<ZstdDecoder>(stream);
  }
};

}  // namespace

const Codec& zstd_codec() {
  static const ZstdCodec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
