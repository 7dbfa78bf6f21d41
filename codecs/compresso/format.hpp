// The payload of the codec compresso; FORMAT.md has it byte by byte.
//
//   u64 ids, u64 windows, u64 locations, u64 words, u32 word bytes (2 or 4), u32 zero
//   windows:   the distinct windows, ascending; the smallest of 1, 2, 4, 8 bytes that holds a window's bits
//   ids:       the label of each component, slice by slice; as wide as a voxel
//   locations: for each boundary voxel that no neighbour decides (slice.hpp), slice by slice, raster order;
//   as wide as a voxel words:     the windows in raster order: 2 * index into the list, or 2 * n + 1 for n
//   times the window without boundary
#pragma once

#include <bit>
#include <cstring>

#include "codecs/codec.hpp"

namespace cvr::codecs::compresso {

struct PayloadLayout {
  static constexpr std::uint64_t kIds = 0;
  static constexpr std::uint64_t kWindows = 8;
  static constexpr std::uint64_t kLocations = 16;
  static constexpr std::uint64_t kWords = 24;
  static constexpr std::uint64_t kWordBytes = 32;
  static constexpr std::uint64_t kZero = 36;
  static constexpr std::uint64_t kHeaderBytes = 40;
};

/// Meaning of a location. Neighbours 1, 3, 4, 5 count only where they are not boundary: their label is known
/// from the ids alone, so that slices can be decoded side by side.
struct Location {
  static constexpr std::uint64_t kLeft = 0;
  static constexpr std::uint64_t kRight = 1;
  static constexpr std::uint64_t kUp = 2;
  static constexpr std::uint64_t kDown = 3;
  static constexpr std::uint64_t kBelow = 4;     ///< z - 1
  static constexpr std::uint64_t kAbove = 5;     ///< z + 1
  static constexpr std::uint64_t kEscape = 6;    ///< the next entry is the label
  static constexpr std::uint64_t kExplicit = 7;  ///< and more: the label plus 7
};

/// Words of 16 bits address so many distinct windows.
inline constexpr std::uint64_t kMaxNarrowWindows = std::uint64_t{1} << 15;

inline std::uint64_t word_bytes(std::uint64_t windows) { return windows <= kMaxNarrowWindows ? 2 : 4; }
/// The largest run or index in words of so many bytes.
inline std::uint64_t largest_in_word(std::uint64_t bytes) {
  return (std::uint64_t{1} << (8 * bytes - 1)) - 1;
}

struct WindowSize {
  std::uint32_t x, y, z;
  std::uint32_t bits() const { return x * y * z; }
  /// 1, 2, 4 or 8.
  std::uint32_t bytes() const { return std::bit_ceil((bits() + 7) / 8); }
};
/// Fails where a window has more than 64 voxels.
Expected<WindowSize> window_size(const Parameters& parameters);

inline Extent window_grid(const Extent& e, const WindowSize& w) {
  const auto up = [](std::uint64_t n, std::uint64_t d) { return n / d + (n % d != 0 ? 1 : 0); };
  return {up(e.x, w.x), up(e.y, w.y), up(e.z, w.z)};
}

/// Field `index` of an array of T that need not be aligned.
template <class T>
T load(const std::byte* array, std::uint64_t index) {
  T value;
  std::memcpy(&value, array + index * sizeof(T), sizeof value);
  return value;
}

Expected<Payload> encode_payload(const VolumeSource& source, const WindowSize& window, unsigned threads);
Expected<std::unique_ptr<Decoder>> open_payload(const VolumeInfo& info, const WindowSize& window,
                                                std::span<const std::byte> payload);

}  // namespace cvr::codecs::compresso
