// Reading and writing little-endian fields of streams: the writer checks every narrowing, the
// reader never leaves its bytes.
#pragma once

#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

#include "volumes/buffer.hpp"

namespace cvr::codecs {

/// The one way in which a size becomes a smaller stored type. Throws std::overflow_error: formats
/// check their limits before.
template <class To, class From>
To narrow(From value) {
  static_assert(std::is_unsigned_v<To> && std::is_unsigned_v<From>);
  if (value > std::numeric_limits<To>::max())
    throw std::overflow_error("a size does not fit its field");
  return static_cast<To>(value);
}

class ByteWriter {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) { bytes_.append(&value, sizeof value); }
  void text(std::string_view text) { bytes_.append(text.data(), text.size()); }
  void append(std::span<const std::byte> bytes) { bytes_.append(bytes); }
  /// Zeros up to the next multiple of `alignment`.
  void align(std::size_t alignment) {
    while (bytes_.size() % alignment != 0) put(std::uint8_t{0});
  }
  std::size_t size() const { return bytes_.size(); }
  volumes::Buffer take() { return std::move(bytes_); }

 private:
  volumes::Buffer bytes_;
};

/// After an attempt to read past the end every get returns zero and failed() is true.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class T>
  requires std::is_arithmetic_v<T> T get() {
    T value{};
    if (const auto source = take(sizeof value); source.size() == sizeof value)
      std::memcpy(&value, source.data(), sizeof value);
    return value;
  }
  std::string text(std::size_t length) {
    const auto source = take(length);
    return {reinterpret_cast<const char*>(source.data()), source.size()};
  }
  /// The next `length` bytes, or an empty span (and failed()) when fewer are left.
  std::span<const std::byte> take(std::size_t length) {
    if (failed_ || length > bytes_.size() - position_) {
      failed_ = true;
      return {};
    }
    const auto taken = bytes_.subspan(position_, length);
    position_ += length;
    return taken;
  }
  std::size_t position() const { return position_; }
  std::size_t remaining() const { return bytes_.size() - position_; }
  bool failed() const { return failed_; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;
  bool failed_ = false;
};

}  // namespace cvr::codecs
