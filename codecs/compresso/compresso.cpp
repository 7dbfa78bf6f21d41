// The codecs compresso and compresso-lzma: one payload, bare or inside an xz container.
#include "codecs/compresso/compresso.hpp"

#include <fmt/format.h>

#include "codecs/compresso/format.hpp"
#include "codecs/general/xz.hpp"

namespace cvr::codecs {

namespace compresso {

Expected<WindowSize> window_size(const Parameters& parameters) {
  const auto edges = parameters.triple("window");
  const WindowSize window{edges[0], edges[1], edges[2]};
  if (window.bits() > 64) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("parameter 'window': expected at most 64 voxels, found {},{},{}",
                            window.x, window.y, window.z));
  }
  return window;
}

}  // namespace compresso

namespace {

constexpr std::uint32_t kXzPreset = 6;
constexpr std::uint64_t kPieceBytes = std::uint64_t{16} << 20;

std::span<const ParameterSpec> window_parameter() {
  static const std::array kParameters{
      ParameterSpec{.name = "window",
                    .type = ParameterType::kTriple,
                    .default_value = "8,8,1",
                    .minimum = 1,
                    .maximum = 64,
                    .description = "voxels of a window along each axis, at most 64 in all"}};
  return kParameters;
}

Traits compresso_traits(std::string_view id, std::string_view summary, bool stored_compressed,
                        std::vector<FrontPart> front) {
  return {.id = id,
          .version = 1,
          .family = "compresso",
          .summary = summary,
          .lossless = true,
          .types = volumes::kLabelTypes,
          .access = Granularity::kVolume,
          .levels_of_detail = false,
          .stored_compressed = stored_compressed,
          .front = std::move(front)};
}

class CompressoCodec final : public Codec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits =
        compresso_traits("compresso", "boundary windows and component labels of each slice", true,
                         {{ByteClass::kHeader}, {ByteClass::kPalette}, {ByteClass::kTables}});
    return kTraits;
  }
  std::span<const ParameterSpec> parameters() const override { return window_parameter(); }

  Expected<Payload> encode(const VolumeSource& source, const Parameters& parameters,
                           unsigned threads) const override {
    const auto window = compresso::window_size(parameters);
    if (!window) return tl::unexpected(window.error());
    return compresso::encode_payload(source, *window, threads);
  }
  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const override {
    const auto window = compresso::window_size(stream.parameters);
    if (!window) return tl::unexpected(window.error());
    return compresso::open_payload(stream.info, *window, stream.payload);
  }
};

/// Owns the unpacked payload that its inner decoder views.
class UnpackedDecoder final : public Decoder {
 public:
  UnpackedDecoder(Buffer payload, std::unique_ptr<Decoder> inner)
      : payload_(std::move(payload)), inner_(std::move(inner)) {}
  Expected<void> decode(unsigned lod, unsigned threads, SlabSink& sink) const override {
    return inner_->decode(lod, threads, sink);
  }

 private:
  Buffer payload_;
  std::unique_ptr<Decoder> inner_;
};

class CompressoLzmaCodec final : public Codec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits =
        compresso_traits("compresso-lzma", "compresso inside an xz container", false, {});
    return kTraits;
  }
  std::span<const ParameterSpec> parameters() const override { return window_parameter(); }

  Expected<Payload> encode(const VolumeSource& source, const Parameters& parameters,
                           unsigned threads) const override {
    auto inner = compresso_codec().encode(source, parameters, threads);
    if (!inner) return inner;
    Payload payload{};
    general::XzEncoder(kXzPreset).feed(
        inner->bytes.bytes(), true,
        [&](std::span<const std::byte> piece) { payload.bytes.append(piece); });
    payload.breakdown[ByteClass::kData] = payload.published_bytes = payload.bytes.size();
    return payload;
  }

  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const override {
    const auto window = compresso::window_size(stream.parameters);
    if (!window) return tl::unexpected(window.error());
    const auto size = general::xz_uncompressed_size(stream.payload);
    if (!size) return tl::unexpected(size.error());
    // Per voxel at most one id or two location entries, one window and its word: no payload is
    // larger.
    const std::uint64_t voxel = 2 * size_of(stream.info.type) + 8 + 8;
    if (*size > compresso::PayloadLayout::kHeaderBytes + stream.info.extent.voxels() * voxel) {
      return fail(ErrorCode::kMalformed,
                  fmt::format("the xz stream announces {} bytes, more than {} voxels can take",
                              *size, stream.info.extent.voxels()));
    }
    Buffer payload;
    general::XzDecoder decoder(stream.payload);
    while (payload.size() < *size) {
      const std::size_t at = payload.size();
      payload.resize(at + std::min(kPieceBytes, *size - at));
      if (auto ok = decoder.fill(payload.bytes().subspan(at)); !ok)
        return tl::unexpected(ok.error());
    }
    if (auto ok = decoder.finish(); !ok) return tl::unexpected(ok.error());
    auto inner = compresso::open_payload(stream.info, *window, payload.bytes());
    if (!inner) return inner;
    return std::make_unique<UnpackedDecoder>(std::move(payload), std::move(*inner));
  }
};

}  // namespace

const Codec& compresso_codec() {
  static const CompressoCodec kCodec;
  return kCodec;
}

const Codec& compresso_lzma_codec() {
  static const CompressoLzmaCodec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
