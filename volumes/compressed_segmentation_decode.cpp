// The decoder and the checks of compressed_segmentation streams; layout in the header.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "volumes/compressed_segmentation.hpp"

namespace cvr::volumes {

namespace {

/// Positions inside a stream are 32-bit numbers.
constexpr std::uint64_t kMaxExtent = 0xffffffffu;

bool is_legal_bits(std::uint32_t bits) { return bits <= 32 && (bits & (bits - 1)) == 0; }

/// Values per axis that lie inside the extent.
Extent valid_part(const Extent& extent, const BlockSize& block, const Coordinate& position) {
  return {std::min<std::uint64_t>(block.x, extent.x - position.x * block.x),
          std::min<std::uint64_t>(block.y, extent.y - position.y * block.y),
          std::min<std::uint64_t>(block.z, extent.z - position.z * block.z)};
}

std::string describe(const Coordinate& position) {
  return fmt::format("block {},{},{}", position.x, position.y, position.z);
}

/// Writes the valid part of a block. Returns the OR of all labels, before they were narrowed to T.
template <class T>
std::uint64_t decode_block(const CompressedSegmentation& stream,
                           const CompressedSegmentation::Block& header, const BlockSize& block,
                           const Extent& valid, T* out, std::uint64_t row_stride,
                           std::uint64_t plane_stride) {
  if (header.bits == 0) {
    const std::uint64_t label = stream.table_entry(header.table_offset, 0);
    for (std::uint64_t z = 0; z < valid.z; ++z) {
      for (std::uint64_t y = 0; y < valid.y; ++y) {
        T* row = out + y * row_stride + z * plane_stride;
        if (valid.x == 8) {
          for (int x = 0; x < 8; ++x) row[x] = static_cast<T>(label);
        } else {
          std::fill_n(row, valid.x, static_cast<T>(label));
        }
      }
    }
    return label;
  }
  using Word = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
  const std::uint32_t* values = stream.channel().data() + header.value_offset;
  Word seen = 0;
  const auto entry = [&](std::uint64_t index) {
    return static_cast<Word>(stream.table_entry(header.table_offset, index));
  };
  if (block.x == 8 && header.bits <= 8) {
    // A row is `bits` bytes. The table is copied so that no voxel reads it unaligned; entries
    // behind its end are not used.
    std::array<Word, 256> table;
    const std::uint64_t entries =
        std::min<std::uint64_t>(std::uint64_t{1} << header.bits,
                                (stream.channel().size() - header.table_offset) / kTableWords<T>);
    for (std::uint64_t i = 0; i < entries; ++i) table[i] = entry(i);
    const auto* packed = reinterpret_cast<const std::byte*>(values);
    const std::uint32_t mask = (1u << header.bits) - 1;
    for (std::uint64_t z = 0; z < valid.z; ++z) {
      for (std::uint64_t y = 0; y < valid.y; ++y) {
        T* row = out + y * row_stride + z * plane_stride;
        std::uint64_t bits = 0;
        std::memcpy(&bits, packed + header.bits * (y + block.y * z), header.bits);
        if (valid.x == 8) {
          for (int x = 0; x < 8; ++x, bits >>= header.bits) {
            const Word label = table[bits & mask];
            seen |= label;
            row[x] = static_cast<T>(label);
          }
        } else {
          for (std::uint64_t x = 0; x < valid.x; ++x, bits >>= header.bits) {
            const Word label = table[bits & mask];
            seen |= label;
            row[x] = static_cast<T>(label);
          }
        }
      }
    }
    return seen;
  }
  const std::uint64_t mask = (std::uint64_t{1} << header.bits) - 1;
  for (std::uint64_t z = 0; z < valid.z; ++z) {
    for (std::uint64_t y = 0; y < valid.y; ++y) {
      T* row = out + y * row_stride + z * plane_stride;
      std::uint64_t bit = std::uint64_t{header.bits} * block.x * (y + std::uint64_t{block.y} * z);
      for (std::uint64_t x = 0; x < valid.x; ++x, bit += header.bits) {
        const Word label = entry((values[bit / 32] >> (bit % 32)) & mask);
        seen |= label;
        row[x] = static_cast<T>(label);
      }
    }
  }
  return seen;
}

}  // namespace

Expected<CompressedSegmentation> CompressedSegmentation::open(std::span<const std::uint32_t> words,
                                                              const Extent& extent,
                                                              const BlockSize& block,
                                                              unsigned table_words) {
  const auto legal = [](std::uint32_t edge) { return edge >= 1 && edge <= kMaxBlockEdge; };
  if (!legal(block.x) || !legal(block.y) || !legal(block.z)) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("block: expected edges of 1..{}, found {},{},{}", kMaxBlockEdge,
                            block.x, block.y, block.z));
  }
  if (std::max({extent.x, extent.y, extent.z}) > kMaxExtent) {
    return fail(
        ErrorCode::kTooLarge,
        fmt::format("expected fewer than 2^32 voxels per axis, found {}", to_string(extent)));
  }
  if (words.empty())
    return fail(ErrorCode::kTruncated,
                "word 0: expected the channel offset, found the end of the stream");
  if (words[0] != 1)
    return fail(ErrorCode::kMalformed,
                fmt::format("word 0: expected the channel offset 1, found {}", words[0]));
  CompressedSegmentation stream;
  stream.channel_ = words.subspan(1);
  stream.extent_ = extent;
  stream.block_ = block;
  stream.edges_are_powers_ = true;
  const std::array sizes{block.x, block.y, block.z};
  for (std::size_t i = 0; i < 3; ++i) {
    stream.edges_[i] = {sizes[i], static_cast<std::uint32_t>(std::countr_zero(sizes[i]))};
    stream.edges_are_powers_ = stream.edges_are_powers_ && std::has_single_bit(sizes[i]);
  }
  stream.table_words_ = table_words;
  const auto blocks = [](std::uint64_t n, std::uint32_t edge) {
    return n / edge + (n % edge != 0 ? 1 : 0);
  };
  stream.grid_ = {blocks(extent.x, block.x), blocks(extent.y, block.y), blocks(extent.z, block.z)};
  std::uint64_t room = stream.channel_.size() / 2;
  for (const std::uint64_t n : {stream.grid_.x, stream.grid_.y, stream.grid_.z})
    room = n == 0 ? room : room / n;
  if (room == 0 && extent.x != 0 && extent.y != 0 && extent.z != 0) {
    return fail(ErrorCode::kTruncated,
                fmt::format("word 1: expected two words for each of {} blocks, found {} words",
                            to_string(stream.grid_), stream.channel_.size()));
  }
  Coordinate position;
  for (position.z = 0; position.z < stream.grid_.z; ++position.z) {
    for (position.y = 0; position.y < stream.grid_.y; ++position.y) {
      for (position.x = 0; position.x < stream.grid_.x; ++position.x) {
        if (auto ok = stream.check_block(position); !ok) return tl::unexpected(ok.error());
      }
    }
  }
  return stream;
}

Expected<void> CompressedSegmentation::check_block(const Coordinate& position) const {
  const Block header = block(grid_.index(position));
  const std::uint64_t size = channel_.size();
  if (!is_legal_bits(header.bits)) {
    return fail(ErrorCode::kMalformed,
                fmt::format("{}: expected 0, 1, 2, 4, 8, 16 or 32 bits per value, found {}",
                            describe(position), header.bits));
  }
  const std::uint64_t value_words = (header.bits * block_.voxels() + 31) / 32;
  if (value_words > 0 && (header.value_offset > size || value_words > size - header.value_offset)) {
    return fail(ErrorCode::kMalformed,
                fmt::format("{}: {} value words at offset {} leave the stream of {} words",
                            describe(position), value_words, header.value_offset, size));
  }
  const std::uint64_t entries =
      header.table_offset > size ? 0 : (size - header.table_offset) / table_words_;
  if (entries >= (std::uint64_t{1} << header.bits)) return {};
  std::uint64_t largest = 0;
  if (header.bits != 0) {
    const Extent valid = valid_part(extent_, block_, position);
    const std::uint64_t mask = (std::uint64_t{1} << header.bits) - 1;
    for (std::uint64_t z = 0; z < valid.z; ++z) {
      for (std::uint64_t y = 0; y < valid.y; ++y) {
        for (std::uint64_t x = 0; x < valid.x; ++x) {
          const std::uint64_t bit =
              header.bits * (x + block_.x * (y + std::uint64_t{block_.y} * z));
          largest = std::max<std::uint64_t>(
              largest, (channel_[header.value_offset + bit / 32] >> (bit % 32)) & mask);
        }
      }
    }
  }
  if (largest < entries) return {};
  return fail(ErrorCode::kMalformed,
              fmt::format("{}: entry {} of the table at offset {} leaves the stream of {} words",
                          describe(position), largest, header.table_offset, size));
}

/// How many blocks from `index` on, at most `limit`, have one label and share its table: they are
/// written as one, in longer rows.
std::uint64_t CompressedSegmentation::uniform_run(std::uint64_t index, std::uint64_t limit) const {
  const Block first = block(index);
  if (first.bits != 0) return 1;
  std::uint64_t run = 1;
  for (; run < limit; ++run) {
    const Block next = block(index + run);
    if (next.bits != 0 || next.table_offset != first.table_offset) break;
  }
  return run;
}

template <class T>
Expected<void> CompressedSegmentation::decode_layers(std::uint64_t begin, std::uint64_t end,
                                                     const LabelBox<T>& out) const {
  std::uint64_t index = begin * grid_.x * grid_.y;
  Coordinate position;
  for (position.z = begin; position.z < end; ++position.z) {
    for (position.y = 0; position.y < grid_.y; ++position.y) {
      position.x = 0;
      for (std::uint64_t run = 1; position.x < grid_.x; position.x += run, index += run) {
        run = uniform_run(index, grid_.x - position.x);
        Extent valid = valid_part(extent_, block_, position);
        if (run > 1) valid.x = std::min(run * block_.x, extent_.x - position.x * block_.x);
        T* voxels = out.labels + position.x * block_.x + position.y * block_.y * out.row_stride +
                    (position.z - begin) * block_.z * out.plane_stride;
        const std::uint64_t seen = decode_block(*this, block(index), block_, valid, voxels,
                                                out.row_stride, out.plane_stride);
        if (seen > std::numeric_limits<T>::max()) {
          return fail(ErrorCode::kMalformed, fmt::format("{}: a label exceeds {} bits",
                                                         describe(position), 8 * sizeof(T)));
        }
      }
    }
  }
  return {};
}

template <class T>
Expected<void> decode_compressed_segmentation(std::span<const std::uint32_t> words,
                                              const LabelBox<T>& box, const BlockSize& block) {
  const auto stream = CompressedSegmentation::open(words, box.extent, block, kTableWords<T>);
  if (!stream) return tl::unexpected(stream.error());
  return stream->decode_layers(0, stream->grid().z, box);
}

#define CVR_INSTANTIATE(T)                                                                    \
  template Expected<void> CompressedSegmentation::decode_layers(std::uint64_t, std::uint64_t, \
                                                                const LabelBox<T>&) const;    \
  template Expected<void> decode_compressed_segmentation(std::span<const std::uint32_t>,      \
                                                         const LabelBox<T>&, const BlockSize&);
CVR_INSTANTIATE(std::uint8_t)
CVR_INSTANTIATE(std::uint16_t)
CVR_INSTANTIATE(std::uint32_t)
CVR_INSTANTIATE(std::uint64_t)
#undef CVR_INSTANTIATE

CompressedSegmentationWords count_words(std::span<const std::uint32_t> words, const Extent& extent,
                                        const BlockSize& block) {
  const auto blocks = [](std::uint64_t n, std::uint32_t edge) { return (n + edge - 1) / edge; };
  const std::uint64_t count =
      blocks(extent.x, block.x) * blocks(extent.y, block.y) * blocks(extent.z, block.z);
  CompressedSegmentationWords sums{1 + 2 * count, 0, 0};
  for (std::uint64_t i = 0; i < count; ++i)
    sums.values += ((words[1 + 2 * i] >> 24) * block.voxels() + 31) / 32;
  sums.tables = words.size() - sums.headers - sums.values;
  return sums;
}

}  // namespace cvr::volumes
