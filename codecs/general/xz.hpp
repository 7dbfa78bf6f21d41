// The xz container (liblzma) in pieces: one stream, one block, CRC64, as the library's own presets
// write it.
//
// Sizes are bounded on both sides: the encoder's memory by its preset, the decoder's by
// kMaxDecoderMemory, and the decoder never produces more than it is asked for.
#pragma once

#include <lzma.h>

#include <cstdint>
#include <functional>
#include <span>

#include "volumes/buffer.hpp"
#include "volumes/error.hpp"

namespace cvr::codecs::general {

/// Preset 9 needs 65 MiB; streams that ask for more are refused.
inline constexpr std::uint64_t kMaxDecoderMemory = std::uint64_t{128} << 20;

class XzEncoder {
 public:
  /// preset 0..9.
  explicit XzEncoder(std::uint32_t preset);
  ~XzEncoder() { lzma_end(&stream_); }
  XzEncoder(const XzEncoder&) = delete;
  XzEncoder& operator=(const XzEncoder&) = delete;
  using Sink = std::function<void(std::span<const std::byte>)>;
  /// Hands what comes out to `out` in pieces. The call with `last` finishes the stream. Throws
  /// std::bad_alloc.
  void feed(std::span<const std::byte> in, bool last, const Sink& out);

 private:
  lzma_stream stream_ = LZMA_STREAM_INIT;
  volumes::Buffer piece_;
};

class XzDecoder {
 public:
  explicit XzDecoder(std::span<const std::byte> in);
  ~XzDecoder() { lzma_end(&stream_); }
  XzDecoder(const XzDecoder&) = delete;
  XzDecoder& operator=(const XzDecoder&) = delete;
  /// Fills `out` completely. Errors: kTruncated, kMalformed, kChecksum, kOutOfMemory.
  volumes::Expected<void> fill(std::span<std::byte> out);
  /// Succeeds if the stream ends here and nothing follows it.
  volumes::Expected<void> finish();

 private:
  volumes::Expected<void> step();

  lzma_stream stream_ = LZMA_STREAM_INIT;
  std::size_t size_;
  bool ended_ = false;
};

/// The uncompressed size that the index at the end of the container tells; the whole of `in` must
/// be one container. Fails too if that size is beyond what LZMA can pack into so few bytes.
volumes::Expected<std::uint64_t> xz_uncompressed_size(std::span<const std::byte> in);

}  // namespace cvr::codecs::general
