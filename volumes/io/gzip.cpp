#include "volumes/io/gzip.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <new>
#include <vector>

#include "volumes/io/format.hpp"

namespace cvr::volumes {

namespace {

constexpr int kGzipWindow = 15 + 16;
constexpr std::size_t kPiece = std::size_t{1} << 18;
constexpr std::size_t kMaximumStep = std::size_t{1} << 30;
constexpr std::uint64_t kMaximumRatio = 1032;
constexpr std::uint64_t kMaximumSurplus = std::uint64_t{1}
                                          << 30;  // counted for the error, then given up

class Inflater {
 public:
  Inflater(const std::string& file, std::span<const std::byte> stream)
      : file_(file), stream_(stream) {
    if (inflateInit2(&state_, kGzipWindow) != Z_OK) throw std::bad_alloc();
  }
  ~Inflater() { inflateEnd(&state_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// Leaves out bytes as far as the stream goes and returns their number.
  std::uint64_t skip(std::uint64_t count) {
    std::vector<std::byte> unused(std::min<std::uint64_t>(count, kPiece));
    std::uint64_t done = 0;
    for (std::size_t got = 1; done < count && got > 0; done += got)
      got = read(std::span(unused).first(std::min<std::uint64_t>(count - done, unused.size())));
    return done;
  }

  /// To be called when nothing is left to read: the stream must be the last thing in its file.
  void expect_end() const {
    if (consumed_ == stream_.size()) return;
    throw_input_error(file_, fmt::format("byte {} of the gzip stream", consumed_),
                      "the end of the file",
                      fmt::format("{} bytes behind the gzip stream", stream_.size() - consumed_));
  }

  /// Fills `out` as far as the stream goes and returns the number of bytes.
  std::size_t read(std::span<std::byte> out) {
    std::size_t done = 0;
    while (done < out.size() && !ended_) done += step(out.subspan(done));
    return done;
  }

 private:
  std::size_t step(std::span<std::byte> out) {
    const auto in = stream_.subspan(consumed_, std::min(stream_.size() - consumed_, kMaximumStep));
    state_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(in.data()));
    state_.avail_in = static_cast<uInt>(in.size());
    const auto room = static_cast<uInt>(std::min(out.size(), kMaximumStep));
    state_.next_out = reinterpret_cast<Bytef*>(out.data());
    state_.avail_out = room;
    const int status = inflate(&state_, Z_NO_FLUSH);
    consumed_ += in.size() - state_.avail_in;
    const std::size_t made = room - state_.avail_out;
    if (status == Z_STREAM_END) {
      // A further member continues the stream; anything else after the trailer is not part of it.
      ended_ = !is_gzip(stream_.subspan(consumed_));
      if (!ended_) inflateReset(&state_);
      return made;
    }
    const std::string position = fmt::format("byte {} of the gzip stream", consumed_);
    if (status == Z_BUF_ERROR || (status == Z_OK && consumed_ == stream_.size() && made == 0)) {
      throw_input_error(file_, position, "more compressed bytes", "the end of the stream");
    }
    if (status == Z_MEM_ERROR) throw std::bad_alloc();
    if (status != Z_OK) {
      throw_input_error(file_, position, "a gzip stream",
                        state_.msg != nullptr ? state_.msg : "damaged bytes");
    }
    return made;
  }

  const std::string& file_;
  std::span<const std::byte> stream_;
  std::size_t consumed_ = 0;
  bool ended_ = false;
  z_stream state_{};
};

[[noreturn]] void throw_short(const std::string& file, std::uint64_t expected,
                              std::uint64_t found) {
  throw_input_error(file, "gzip stream", fmt::format("{} inflated bytes", expected),
                    fmt::format("the end of the stream after {}", found));
}

}  // namespace

bool is_gzip(std::span<const std::byte> bytes) {
  return bytes.size() >= 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
}

void check_inflatable(const std::string& file, std::uint64_t compressed, std::uint64_t needed) {
  if (needed / kMaximumRatio > compressed) {
    throw_input_error(file, "", fmt::format("{} bytes of voxels", needed),
                      fmt::format("a gzip stream of {} bytes, which cannot hold them", compressed));
  }
}

void inflate_start(const std::string& file, std::span<const std::byte> stream,
                   std::span<std::byte> out) {
  Inflater inflater(file, stream);
  const std::size_t got = inflater.read(out);
  if (got < out.size()) throw_short(file, out.size(), got);
}

void inflate_exactly(const std::string& file, std::span<const std::byte> stream,
                     std::uint64_t before, std::span<std::byte> out, std::uint64_t after) {
  const std::uint64_t all = before + out.size() + after;
  Inflater inflater(file, stream);
  std::uint64_t got = inflater.skip(before);
  if (got == before) got += inflater.read(out);
  if (got == before + out.size()) got += inflater.skip(after);
  if (got < all) throw_short(file, all, got);
  if (const std::uint64_t surplus = inflater.skip(kMaximumSurplus); surplus > 0) {
    throw_input_error(
        file, "gzip stream", fmt::format("{} inflated bytes", all),
        fmt::format("{}{}", surplus == kMaximumSurplus ? "at least " : "", all + surplus));
  }
  inflater.expect_end();
}

std::uint64_t inflated_size(const std::string& file, std::span<const std::byte> stream) {
  Inflater inflater(file, stream);
  const std::uint64_t size = inflater.skip(std::numeric_limits<std::uint64_t>::max());
  inflater.expect_end();
  return size;
}

Buffer inflate_all(const std::string& file, std::span<const std::byte> stream,
                   std::uint64_t limit) {
  Inflater inflater(file, stream);
  Buffer bytes;
  for (;;) {
    const std::size_t at = bytes.size();
    const std::size_t step = std::clamp<std::size_t>(at, kPiece, kMaximumStep);
    bytes.resize(at + step);
    const std::size_t got = inflater.read(bytes.bytes().subspan(at));
    bytes.resize(at + got);
    if (bytes.size() > limit) {
      throw_input_error(file, "", fmt::format("at most {} inflated bytes", limit),
                        fmt::format("more"));
    }
    if (got < step) {
      inflater.expect_end();
      return bytes;
    }
  }
}

struct GzipWriter::State {
  z_stream stream{};
  std::vector<std::byte> piece = std::vector<std::byte>(kPiece);
};

GzipWriter::GzipWriter(Sink sink, int level)
    : sink_(std::move(sink)), state_(std::make_unique<State>()) {
  constexpr int kMemoryLevel = 8;
  if (deflateInit2(&state_->stream, level, Z_DEFLATED, kGzipWindow, kMemoryLevel,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::bad_alloc();
  }
}

GzipWriter::~GzipWriter() { deflateEnd(&state_->stream); }

void GzipWriter::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t step = std::min(bytes.size(), kMaximumStep);
    run(bytes.first(step), Z_NO_FLUSH);
    bytes = bytes.subspan(step);
  }
}

void GzipWriter::finish() { run({}, Z_FINISH); }

void GzipWriter::run(std::span<const std::byte> bytes, int flush) {
  z_stream& stream = state_->stream;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  do {
    stream.next_out = reinterpret_cast<Bytef*>(state_->piece.data());
    stream.avail_out = static_cast<uInt>(state_->piece.size());
    deflate(&stream, flush);
    sink_(std::span(state_->piece).first(state_->piece.size() - stream.avail_out));
  } while (stream.avail_out == 0);
}

}  // namespace cvr::volumes
