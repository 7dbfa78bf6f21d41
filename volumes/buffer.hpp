// An owned run of bytes that is not zeroed and grows in place.
//
// std::vector zero-fills and, when it grows, holds the old and the new copy at once. Encoded
// volumes reach gigabytes, so this buffer uses realloc: large blocks are then remapped by the
// kernel and never exist twice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <span>
#include <utility>

namespace cvr::volumes {

class Buffer {
 public:
  Buffer() = default;
  /// `size` bytes of undefined content. Throws std::bad_alloc.
  explicit Buffer(std::size_t size) { resize(size); }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    Buffer(std::move(other)).swap(*this);
    return *this;
  }
  Buffer(const Buffer& other) : Buffer(other.size_) {
    if (size_ > 0) std::memcpy(data_, other.data_, size_);
  }
  Buffer& operator=(const Buffer& other) {
    Buffer(other).swap(*this);
    return *this;
  }
  ~Buffer() { std::free(data_); }

  std::byte* data() { return data_; }
  const std::byte* data() const { return data_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::span<const std::byte> bytes() const { return {data_, size_}; }
  std::span<std::byte> bytes() { return {data_, size_}; }

  /// Grows or shrinks; bytes beyond the old size are undefined.
  void resize(std::size_t size) {
    if (size > capacity_)
      reserve(size > capacity_ + capacity_ / 2 ? size : capacity_ + capacity_ / 2);
    size_ = size;
  }
  void reserve(std::size_t capacity) {
    if (capacity <= capacity_) return;
    void* grown = std::realloc(data_, capacity);
    if (grown == nullptr) throw std::bad_alloc();
    data_ = static_cast<std::byte*>(grown);
    capacity_ = capacity;
  }
  void append(const void* source, std::size_t count) {
    if (count == 0) return;
    const std::size_t at = size_;
    resize(size_ + count);
    std::memcpy(data_ + at, source, count);
  }
  void append(std::span<const std::byte> source) { append(source.data(), source.size()); }

  void swap(Buffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

 private:
  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace cvr::volumes
