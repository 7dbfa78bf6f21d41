// The payload of the codec neuroglancer; FORMAT.md has it byte by byte.
//
//   u32 chunk edge E, u32 levels L
//   u64 x (chunks + 1)   chunk table: where each stream starts, in words from the first stream; the last entry is their sum
//   u32 x sum            the streams: all chunks of level 0, x fastest, then those of level 1, ...
// Level k has the extent ceil(extent / 2^k) and chunks of E voxels of its own along each axis.
#pragma once

#include <algorithm>

#include "codecs/codec.hpp"
#include "volumes/compressed_segmentation.hpp"

namespace cvr::codecs::neuroglancer {

struct PayloadLayout {
  static constexpr std::uint64_t kHeaderBytes = 8;
  static constexpr std::uint64_t kTableEntryBytes = 8;
};
inline constexpr std::uint32_t kAutomaticChunk = 512;
inline constexpr std::uint32_t kMaxChunk = 4096;
inline constexpr unsigned kMaxLevels = 8;

inline volumes::BlockSize block_size(const Parameters& parameters) {
  const auto block = parameters.triple("block");
  return {block[0], block[1], block[2]};
}

/// The extent of the chunk at a position of the chunk grid.
inline Extent chunk_extent(const Extent& level, std::uint32_t edge, const Coordinate& chunk) {
  return {std::min<std::uint64_t>(edge, level.x - chunk.x * edge),
          std::min<std::uint64_t>(edge, level.y - chunk.y * edge),
          std::min<std::uint64_t>(edge, level.z - chunk.z * edge)};
}

/// Bricks (chunks at the finest level) must halve evenly down to the coarsest level.
inline bool chunk_suits_levels(std::uint32_t edge, unsigned levels) {
  return edge % (1u << (levels - 1)) == 0;
}

/// Appends the streams of a whole level to payload.bytes, in chunks of `edge` voxels per side, and
/// their ends in words to `ends`, counted from its last entry. kTooLarge: a table offset does not
/// fit; then some streams have been appended.
Expected<void> append_level(const VolumeSource& level, std::uint32_t edge,
                            const volumes::BlockSize& block, unsigned threads, Payload& payload,
                            std::vector<std::uint64_t>& ends);

/// Checks the chunk table and opens every stream.
Expected<std::unique_ptr<Decoder>> open_decoder(const Stream& stream);

}  // namespace cvr::codecs::neuroglancer
