// lzma: the voxels in one xz container.
#include <fmt/format.h>

#include "codecs/general/general.hpp"
#include "codecs/general/slabs.hpp"
#include "codecs/general/xz.hpp"

namespace cvr::codecs {

namespace {

class LzmaDecoder final : public Decoder {
 public:
  explicit LzmaDecoder(const Stream& stream) : info_(stream.info), payload_(stream.payload) {}

  Expected<void> decode(unsigned, unsigned, SlabSink& sink) const override {
    general::XzDecoder decoder(payload_);
    auto filled = general::fill_slabs(
        info_, sink, [&](std::span<std::byte> slab) { return decoder.fill(slab); });
    if (!filled) return filled;
    return decoder.finish();
  }

 private:
  VolumeInfo info_;
  std::span<const std::byte> payload_;
};

class LzmaCodec final : public Codec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits{.id = "lzma",
                                .version = 1,
                                .family = "general",
                                .summary = "the voxels in one xz container",
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
                                                      .default_value = "6",
                                                      .minimum = 0,
                                                      .maximum = 9,
                                                      .description = "preset of liblzma"}};
    return kParameters;
  }

  Expected<Payload> encode(const VolumeSource& source, const Parameters& parameters,
                           unsigned) const override {
    general::XzEncoder encoder(static_cast<std::uint32_t>(parameters.integer("level")));
    Payload payload{};
    const auto append = [&](std::span<const std::byte> piece) { payload.bytes.append(piece); };
    auto fed = general::feed_slabs(
        source, [&](std::span<const std::byte> slab, bool last) -> Expected<void> {
          encoder.feed(slab, last, append);
          return {};
        });
    if (!fed) return tl::unexpected(fed.error());
    payload.breakdown[ByteClass::kData] = payload.published_bytes = payload.bytes.size();
    return payload;
  }

  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const override {
    const auto size = general::xz_uncompressed_size(stream.payload);
    if (!size) return tl::unexpected(size.error());
    if (*size != stream.info.bytes()) {
      return fail(ErrorCode::kMalformed,
                  fmt::format("expected an xz stream of {} bytes, found one of {}",
                              stream.info.bytes(), *size));
    }
    return std::make_unique<LzmaDecoder>(stream);
  }
};

}  // namespace

const Codec& lzma_codec() {
  static const LzmaCodec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
