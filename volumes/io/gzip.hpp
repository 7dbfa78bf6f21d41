// gzip streams (RFC 1952) of one or several members, through zlib; read to a known size, written in pieces.
//
// A stream names no trustworthy size, so readers say how many bytes they need and compare that with the
// length of the stream first: DEFLATE cannot expand by more than 1032 to 1, which bounds what a forged header
// can make us allocate.
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

/// Leaves out `skip` bytes of the inflated stream and fills `out` with the next ones; if the stream ends
/// there, its checksum is verified too. Throws InputError that names `file` if the stream is damaged or too
/// short.
void inflate_range(const std::string& file, std::span<const std::byte> stream, std::uint64_t skip,
                   std::span<std::byte> out);

/// The whole inflated stream, checksum verified; throws InputError if it is damaged or longer than `limit`
/// bytes.
Buffer inflate_all(const std::string& file, std::span<const std::byte> stream, std::uint64_t limit);

/// Compresses what is written to it and hands the stream on in pieces. No time stamp or name: equal input
/// gives equal bytes.
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
