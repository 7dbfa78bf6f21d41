// The payload of the codec compresso; FORMAT.md has it byte by byte.
//
//   u64 ids, u64 windows, u64 locations, u64 words, u32 word bytes, u32 zero
//   ids        the label of each component, slice by slice; as wide as a voxel
//   windows    the distinct windows, ascending; the smallest of 1, 2, 4, 8 bytes that holds a window's bits
//   locations  for each boundary voxel that no neighbour decides (slice.hpp), slice by slice, in
//   raster order
//   words      the windows in raster order: 2 * index, or 2 * n + 1 for n times the window without boundary;
//              as wide as a window (8 bytes for 8x8x1), or wider where the indices need it
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

/// Meaning of a location. A neighbour is named only where it is not boundary: its label is known
/// from the ids alone, so that slices can be decoded side by side. The left and upper neighbours of
/// a voxel that needs a location are boundary, so that 0 and 2, which the published format reserves
/// for them, do not occur and are refused.
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

/// The largest run or index in a word of so many bytes.
inline std::uint64_t largest_in_word(std::uint64_t bytes) {
  return ~std::uint64_t{0} >> (64 - 8 * bytes + 1);
}

struct WindowSize {
  std::uint32_t x, y, z;
  std::uint32_t bits() const { return x * y * z; }
  /// 1, 2, 4 or 8.
  std::uint32_t bytes() const { return std::bit_ceil((bits() + 7) / 8); }
  /// Bytes of a word: as wide as a window, as in the published format, or wider where the indices
  /// of `windows` need it.
  std::uint64_t word_bytes(std::uint64_t windows) const {
    std::uint64_t width = bytes();
    while (width < 8 && windows > largest_in_word(width) + 1) width *= 2;
    return width;
  }
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

/// Field `index` of an array of unsigned numbers of 1, 2, 4 or 8 bytes.
inline std::uint64_t load_unsigned(const std::byte* array, std::uint64_t index,
                                   std::uint64_t bytes) {
  switch (bytes) {
    case 1:
      return load<std::uint8_t>(array, index);
    case 2:
      return load<std::uint16_t>(array, index);
    case 4:
      return load<std::uint32_t>(array, index);
    default:
      return load<std::uint64_t>(array, index);
  }
}

Expected<Payload> encode_payload(const VolumeSource& source, const WindowSize& window,
                                 unsigned threads);
Expected<std::unique_ptr<Decoder>> open_payload(const VolumeInfo& info, const WindowSize& window,
                                                std::span<const std::byte> payload);

}  // namespace cvr::codecs::compresso
