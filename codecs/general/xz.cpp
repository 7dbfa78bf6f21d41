#include "codecs/general/xz.hpp"

#include <fmt/format.h>

#include <new>

namespace cvr::codecs::general {

using volumes::ErrorCode;
using volumes::Expected;
using volumes::fail;

namespace {

constexpr std::size_t kPieceBytes = std::size_t{1} << 18;

/// A repeated match of 273 bytes takes at least 14 decisions of log2(2048 / 2017) bits: about 7100
/// bytes a byte.
constexpr std::uint64_t kMaxRatio = 8192;

const std::uint8_t* bytes_of(std::span<const std::byte> in) {
  return reinterpret_cast<const std::uint8_t*>(in.data());
}

}  // namespace

XzEncoder::XzEncoder(std::uint32_t preset) : piece_(kPieceBytes) {
  if (lzma_easy_encoder(&stream_, preset, LZMA_CHECK_CRC64) != LZMA_OK) throw std::bad_alloc();
}

void XzEncoder::feed(std::span<const std::byte> in, bool last, const Sink& out) {
  stream_.next_in = bytes_of(in);
  stream_.avail_in = in.size();
  for (bool done = false; !done;) {
    stream_.next_out = reinterpret_cast<std::uint8_t*>(piece_.data());
    stream_.avail_out = piece_.size();
    const lzma_ret result = lzma_code(&stream_, last ? LZMA_FINISH : LZMA_RUN);
    if (result != LZMA_OK && result != LZMA_STREAM_END) throw std::bad_alloc();
    out(piece_.bytes().first(piece_.size() - stream_.avail_out));
    done = last ? result == LZMA_STREAM_END : stream_.avail_in == 0;
  }
}

XzDecoder::XzDecoder(std::span<const std::byte> in) : size_(in.size()) {
  if (lzma_stream_decoder(&stream_, kMaxDecoderMemory, 0) != LZMA_OK) throw std::bad_alloc();
  stream_.next_in = bytes_of(in);
  stream_.avail_in = in.size();
}

Expected<void> XzDecoder::step() {
  const lzma_ret result = lzma_code(&stream_, LZMA_FINISH);
  const std::size_t at = size_ - stream_.avail_in;
  switch (result) {
    case LZMA_OK:
      return {};
    case LZMA_STREAM_END:
      ended_ = true;
      return {};
    case LZMA_BUF_ERROR:
      return fail(ErrorCode::kTruncated, fmt::format("offset {}: the xz stream is cut off", at));
    case LZMA_MEMLIMIT_ERROR:
      return fail(
          ErrorCode::kTooLarge,
          fmt::format("offset {}: the xz stream asks for a larger dictionary than any preset", at));
    case LZMA_MEM_ERROR:
      return fail(ErrorCode::kOutOfMemory, "not enough memory for an xz decoder");
    case LZMA_FORMAT_ERROR:
      return fail(ErrorCode::kMalformed, "offset 0: expected an xz stream");
    default:
      return fail(ErrorCode::kMalformed, fmt::format("offset {}: the xz stream is damaged", at));
  }
}

Expected<void> XzDecoder::fill(std::span<std::byte> out) {
  stream_.next_out = reinterpret_cast<std::uint8_t*>(out.data());
  stream_.avail_out = out.size();
  while (stream_.avail_out > 0) {
    if (ended_) return fail(ErrorCode::kTruncated, "the xz stream holds fewer bytes than expected");
    if (auto ok = step(); !ok) return ok;
  }
  return {};
}

Expected<void> XzDecoder::finish() {
  std::uint8_t surplus;
  stream_.next_out = &surplus;
  stream_.avail_out = 1;
  while (!ended_) {
    if (auto ok = step(); !ok) return ok;
    if (stream_.avail_out == 0)
      return fail(ErrorCode::kMalformed, "the xz stream holds more bytes than expected");
  }
  if (stream_.avail_in != 0)
    return fail(ErrorCode::kMalformed,
                fmt::format("{} bytes follow the xz stream", stream_.avail_in));
  return {};
}

Expected<std::uint64_t> xz_uncompressed_size(std::span<const std::byte> in) {
  if (in.size() < 2 * LZMA_STREAM_HEADER_SIZE) {
    return fail(ErrorCode::kTruncated,
                fmt::format("expected an xz stream, found {} bytes", in.size()));
  }
  const std::size_t footer_at = in.size() - LZMA_STREAM_HEADER_SIZE;
  lzma_stream_flags footer;
  if (lzma_stream_footer_decode(&footer, bytes_of(in) + footer_at) != LZMA_OK ||
      footer.backward_size > footer_at) {
    return fail(ErrorCode::kTruncated,
                fmt::format("offset {}: expected the footer of an xz stream", footer_at));
  }
  lzma_index* index = nullptr;
  std::uint64_t memory = kMaxDecoderMemory;
  std::size_t at = footer_at - footer.backward_size;
  const std::size_t index_at = at;
  if (lzma_index_buffer_decode(&index, &memory, nullptr, bytes_of(in), &at, footer_at) != LZMA_OK) {
    return fail(ErrorCode::kMalformed,
                fmt::format("offset {}: expected the index of an xz stream", index_at));
  }
  const std::uint64_t size = lzma_index_uncompressed_size(index);
  lzma_index_end(index, nullptr);
  if (size / kMaxRatio > in.size()) {
    return fail(ErrorCode::kMalformed,
                fmt::format("offset {}: {} bytes cannot hold {} bytes", index_at, in.size(), size));
  }
  return size;
}

}  // namespace cvr::codecs::general
