// Neuroglancer's compressed_segmentation stream: blocks of labels as a sorted table and small
// indices into it.
//
// Source: the published format description of Neuroglancer. All words are u32, little endian; one
// channel:
//   word 0         1: where the channel starts, in words. All offsets below are relative to that word.
//   2 gx gy gz     block headers, x fastest, g = ceil(extent / block):
//                    word 0: bits 0..23 table offset, bits 24..31 bits per value (0, 1, 2, 4, 8, 16
//                    or 32)
//                    word 1: value offset
//   then for every block: its values, then its table unless an earlier block has an equal one
//   (which is then shared)
//     values: the index of (x, y, z) at bit `bits * (x + bx * (y + by * z))`, least significant
//     first; ceil to words.
//             Blocks at the border keep their full size; voxels outside the extent have index 0.
//     table:  the block's labels, ascending; one word per label (u8, u16, u32 volumes) or two, low
//     first (u64).
//
// Extent, block size and label width are not in the stream. The table offset has 24 bits: a stream
// whose tables start later is refused (kTooLarge), never wrapped. Encoding is deterministic; the
// vector and the portable code give the same words.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/volume.hpp"

namespace cvr::volumes {

/// Voxels of a block along each axis, each 1..kMaxBlockEdge.
struct BlockSize {
  std::uint32_t x = 8, y = 8, z = 8;
  bool operator==(const BlockSize&) const = default;
  std::uint64_t voxels() const { return std::uint64_t{x} * y * z; }
};
inline constexpr std::uint32_t kMaxBlockEdge = 64;
/// Table offsets are below this many words.
inline constexpr std::uint64_t kMaxTableOffset = std::uint64_t{1} << 24;

/// Voxels inside a larger array: (x, y, z) lies at labels[x + row_stride * y + plane_stride * z];
/// strides in voxels.
template <class T>
struct LabelBox {
  T* labels;
  Extent extent;
  std::uint64_t row_stride;
  std::uint64_t plane_stride;
};
/// Dense voxels, x fastest.
template <class T>
LabelBox<T> dense_box(T* labels, const Extent& extent) {
  return {labels, extent, extent.x, extent.x * extent.y};
}

/// Words of a label in the tables: 1 up to u32, 2 for u64.
template <class T>
inline constexpr unsigned kTableWords = sizeof(T) == 8 ? 2 : 1;

/// The complete stream of one channel, including the leading word 1. T: u8, u16, u32 (tables of
/// u32) or u64. Errors: kBadArgument (block edge), kTooLarge (a table offset beyond 24 bits or a
/// value offset beyond 32).
template <class T>
Expected<std::vector<std::uint32_t>> encode_compressed_segmentation(const LabelBox<const T>& box,
                                                                    const BlockSize& block);
template <class T>
Expected<std::vector<std::uint32_t>> encode_compressed_segmentation(const T* labels,
                                                                    const Extent& extent,
                                                                    const BlockSize& block) {
  return encode_compressed_segmentation<T>(dense_box(labels, extent), block);
}

/// Decodes a stream of any origin. Errors: kBadArgument (block edge), kTruncated, kMalformed (a
/// header, value or table outside the stream, bits per value that do not exist, a label too wide
/// for T). On error the voxels are partly written.
template <class T>
Expected<void> decode_compressed_segmentation(std::span<const std::uint32_t> words,
                                              const LabelBox<T>& box, const BlockSize& block);
template <class T>
Expected<void> decode_compressed_segmentation(std::span<const std::uint32_t> words,
                                              const Extent& extent, const BlockSize& block,
                                              T* labels) {
  return decode_compressed_segmentation<T>(words, dense_box(labels, extent), block);
}

/// Single voxels of a stream. Views the words it was opened on.
class CompressedSegmentation {
 public:
  /// Checks every header and every index that could leave the stream, so that label() never reads
  /// outside `words`. Time: two words per block, and the values of those few blocks whose table is
  /// closer to the end than 2^bits entries.
  static Expected<CompressedSegmentation> open(std::span<const std::uint32_t> words,
                                               const Extent& extent, const BlockSize& block,
                                               unsigned table_words);

  struct Block {
    std::uint32_t table_offset;
    std::uint32_t bits;
    std::uint32_t value_offset;
  };
  /// The header of block `index` = x + gx * (y + gy * z).
  Block block(std::uint64_t index) const {
    const std::uint32_t word = channel_[2 * index];
    return {word & 0xffffffu, word >> 24, channel_[2 * index + 1]};
  }
  /// The label of a voxel inside the extent: four reads.
  std::uint64_t label(const Coordinate& c) const {
    return edges_are_powers_
               ? label_at(c, [](std::uint64_t n, const Edge& e) { return n >> e.shift; })
               : label_at(c, [](std::uint64_t n, const Edge& e) {
                   return std::uint64_t{static_cast<std::uint32_t>(n) / e.size};
                 });
  }
  /// Decodes the layers [begin, end) of blocks along z. `out.labels` is where the voxel (0, 0,
  /// begin * block.z) goes; the extent of `out` is not used. Error: kMalformed (a label too wide
  /// for T).
  template <class T>
  Expected<void> decode_layers(std::uint64_t begin, std::uint64_t end,
                               const LabelBox<T>& out) const;
  /// Entry `index` of the table at an offset.
  std::uint64_t table_entry(std::uint32_t table_offset, std::uint64_t index) const {
    const std::uint32_t* entry = channel_.data() + table_offset + index * table_words_;
    return table_words_ == 1 ? entry[0] : entry[0] | (std::uint64_t{entry[1]} << 32);
  }
  /// Blocks along each axis.
  const Extent& grid() const { return grid_; }
  /// The stream without its leading word.
  std::span<const std::uint32_t> channel() const { return channel_; }

 private:
  struct Edge {
    std::uint32_t size = 1;
    std::uint32_t shift = 0;  ///< log2(size) where that is whole
  };
  std::uint64_t uniform_run(std::uint64_t index, std::uint64_t limit) const;
  Expected<void> check_block(const Coordinate& position) const;
  template <class Divide>
  std::uint64_t label_at(const Coordinate& c, Divide divide) const {
    const Coordinate b{divide(c.x, edges_[0]), divide(c.y, edges_[1]), divide(c.z, edges_[2])};
    const Block header = block(grid_.index(b));
    std::uint64_t index = 0;
    if (header.bits != 0) {
      const std::uint64_t voxel =
          (c.x - b.x * block_.x) +
          block_.x * ((c.y - b.y * block_.y) + block_.y * (c.z - b.z * block_.z));
      const std::uint64_t bit = voxel * header.bits;
      const std::uint64_t mask = (std::uint64_t{1} << header.bits) - 1;
      index = (channel_[header.value_offset + bit / 32] >> (bit % 32)) & mask;
    }
    return table_entry(header.table_offset, index);
  }

  std::span<const std::uint32_t> channel_;
  Extent extent_;
  Extent grid_;
  BlockSize block_;
  Edge edges_[3];
  bool edges_are_powers_ = false;
  unsigned table_words_ = 1;
};

/// Where the words of a stream go.
struct CompressedSegmentationWords {
  std::uint64_t headers;  ///< including the leading word
  std::uint64_t values;
  std::uint64_t tables;
};
CompressedSegmentationWords count_words(std::span<const std::uint32_t> words, const Extent& extent,
                                        const BlockSize& block);

}  // namespace cvr::volumes
