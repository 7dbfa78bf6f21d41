// gzip streams (RFC 1952) of one or several members, through zlib; read to a known size, written in
// pieces.
//
// A stream names no trustworthy size, so readers say how many bytes they need and compare that with
// the length of the stream first: DEFLATE cannot expand by more than 1032 to 1, which bounds what a
// forged header can make us allocate.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "volumes/buffer.hpp"

namespace cvr::volumes {

/// Whether the bytes start with the gzip magic 1f 8b.
bool is_gzip(std::span<const std::byte> bytes);

/// Throws InputError if `compressed` bytes cannot hold `needed` bytes.
void check_inflatable(const std::string& file, std::uint64_t compressed, std::uint64_t needed);

/// Fills `out` with the first bytes of the inflated stream, whatever follows. Throws InputError
/// that names `file` if the stream is damaged or too short.
void inflate_start(const std::string& file, std::span<const std::byte> stream,
                   std::span<std::byte> out);

/// Leaves out `before` bytes of the inflated stream, fills `out` with the next ones, and expects
/// exactly `after` more bytes, the right checksums and the end of the file behind them. Throws
/// InputError that names `file` and both numbers if the stream is damaged, too short or too long,
/// or followed by anything.
void inflate_exactly(const std::string& file, std::span<const std::byte> stream,
                     std::uint64_t before, std::span<std::byte> out, std::uint64_t after);

/// The length of the inflated stream, which nothing follows; everything is inflated once for it.
/// Throws like inflate_exactly.
std::uint64_t inflated_size(const std::string& file, std::span<const std::byte> stream);

/// The whole inflated stream, checksum verified; throws InputError if it is damaged or longer than
/// `limit` bytes.
Buffer inflate_all(const std::string& file, std::span<const std::byte> stream, std::uint64_t limit);

/// Compresses what is written to it and hands the stream on in pieces. No time stamp or name: equal
/// input gives equal bytes.
class GzipWriter {
 public:
  using Sink = std::function<void(std::span<const std::byte>)>;
  GzipWriter(Sink sink, int level);
  ~GzipWriter();
  void write(std::span<const std::byte> bytes);
  /// Writes what is left and the trailer.
  void finish();

 private:
  struct State;
  void run(std::span<const std::byte> bytes, int flush);
  Sink sink_;
  std::unique_ptr<State> state_;
};

}  // namespace cvr::volumes
