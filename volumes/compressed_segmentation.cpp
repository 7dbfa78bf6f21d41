// The encoder of compressed_segmentation streams; layout in the header.
//
// One row of blocks (all blocks of one by, bz) at a time. A first pass reads its voxel rows in memory order
// and finds the blocks of one label; only the others are visited again. Such a block is cut into runs along x
// (a row equal to the row before shares its runs), each run looks its label up in a palette in order of
// discovery, the palette is sorted, and the runs are packed: with v0, v1, ... the sorted indices of a row's
// runs, the packed row is the XOR over runs of (v_i ^ v_i-1) * 0b...0001_0001 shifted to the run's start, so
// that no voxel is touched alone.
#include "volumes/compressed_segmentation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "volumes/compressed_segmentation_tables.hpp"

namespace cvr::volumes {

namespace {

using segmentation::Palette;
using segmentation::TableIndex;

/// Bit x is set where row[x] differs from row[x - 1]; n <= 64.
template <class T>
std::uint64_t change_mask(const T* row, std::uint32_t n) {
#if defined(CVR_SEGMENTATION_AVX2)
  if (n == 8) {
    if constexpr (sizeof(T) == 8) {
      const auto equal = [row](int at) {
        const __m256i here = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(row + at));
        const __m256i next = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(row + at + 1));
        return static_cast<unsigned>(
            _mm256_movemask_pd(_mm256_castsi256_pd(_mm256_cmpeq_epi64(here, next))));
      };
      // Pairs 0..3, then pairs 3..6: every load stays within the eight voxels.
      const unsigned same = equal(0) | (equal(3) << 3);
      return (~same & 0x7fu) << 1;
    } else {
      __m256i lanes;
      if constexpr (sizeof(T) == 4) {
        lanes = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(row));
      } else if constexpr (sizeof(T) == 2) {
        lanes = _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(row)));
      } else {
        lanes = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(row)));
      }
      const __m256i before =
          _mm256_permutevar8x32_epi32(lanes, _mm256_setr_epi32(0, 0, 1, 2, 3, 4, 5, 6));
      return ~static_cast<unsigned>(
                 _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(lanes, before)))) &
             0xffu;
    }
  }
#endif
  std::uint64_t mask = 0;
  for (std::uint32_t x = 1; x < n; ++x) mask |= std::uint64_t{row[x] != row[x - 1]} << x;
  return mask;
}

/// Non-zero if a voxel of the row differs from `first`.
template <class T>
std::uint64_t difference(const T* row, std::uint32_t n, T first) {
  if (n == 8) {
    constexpr std::uint64_t kLanes = ~std::uint64_t{0} / std::numeric_limits<T>::max();
    const std::uint64_t all = kLanes * first;
    std::uint64_t words[sizeof(T)];
    std::memcpy(words, row, sizeof words);
    std::uint64_t any = 0;
    for (const std::uint64_t word : words) any |= word ^ all;
    return any;
  }
  std::uint64_t any = 0;
  for (std::uint32_t x = 0; x < n; ++x) any |= static_cast<std::uint64_t>(row[x] ^ first);
  return any;
}

template <class T>
class StreamEncoder {
  using Word = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;

 public:
  StreamEncoder(const LabelBox<const T>& box, const BlockSize& block)
      : box_(box),
        block_(block),
        grid_{(box.extent.x + block.x - 1) / block.x, (box.extent.y + block.y - 1) / block.y,
              (box.extent.z + block.z - 1) / block.z},
        first_(grid_.x),
        any_(grid_.x),
        palette_(block.voxels()),
        entries_(block.voxels()),
        spare_(block.voxels()),
        ranks_(block.voxels()),
        table_(block.voxels()),
        runs_(block.voxels()),
        rows_(std::size_t{block.y} * block.z) {}

  Expected<std::vector<std::uint32_t>> encode() {
    end_ = 2 * grid_.voxels();
    out_.resize(1 + end_);
    out_[0] = 1;
    std::uint64_t index = 0;
    for (std::uint64_t bz = 0; bz < grid_.z; ++bz) {
      for (std::uint64_t by = 0; by < grid_.y; ++by) {
        find_uniform_blocks(by, bz);
        for (std::uint64_t bx = 0; bx < grid_.x; ++bx, ++index) {
          make_room();
          if (any_[bx] == 0) {
            put_uniform(index, first_[bx]);
          } else {
            put_mixed(index, {bx, by, bz});
          }
        }
        if (too_large_) {
          return fail(ErrorCode::kTooLarge,
                      fmt::format("a table offset needs more than 24 bits: a stream "
                                  "holds at most {} words before its last table",
                                  kMaxTableOffset));
        }
      }
    }
    out_.resize(1 + end_);
    return std::move(out_);
  }

 private:
  struct Run {
    std::uint32_t x;
    std::uint32_t index;  ///< into the palette
  };
  struct Row {
    std::uint32_t begin, end;  ///< runs
  };

  const T* row(std::uint64_t y, std::uint64_t z) const {
    return box_.labels + y * box_.row_stride + z * box_.plane_stride;
  }
  static std::uint32_t valid(std::uint64_t extent, std::uint64_t begin, std::uint32_t block) {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(block, extent - begin));
  }

  void find_uniform_blocks(std::uint64_t by, std::uint64_t bz) {
    const std::uint64_t y0 = by * block_.y, z0 = bz * block_.z;
    const std::uint64_t y1 = y0 + valid(box_.extent.y, y0, block_.y),
                        z1 = z0 + valid(box_.extent.z, z0, block_.z);
    const T* top = row(y0, z0);
    for (std::uint64_t bx = 0; bx < grid_.x; ++bx) first_[bx] = top[bx * block_.x];
    std::ranges::fill(any_, 0);
    const std::uint64_t full = box_.extent.x / block_.x;
    for (std::uint64_t z = z0; z < z1; ++z) {
      for (std::uint64_t y = y0; y < y1; ++y) {
        const T* at = row(y, z);
        if (block_.x == 8) {
          for (std::uint64_t bx = 0; bx < full; ++bx)
            any_[bx] |= difference(at + bx * 8, 8, first_[bx]);
        } else {
          for (std::uint64_t bx = 0; bx < full; ++bx)
            any_[bx] |= difference(at + bx * block_.x, block_.x, first_[bx]);
        }
        if (full < grid_.x) {
          const std::uint64_t x0 = full * block_.x;
          any_[full] |= difference(at + x0, valid(box_.extent.x, x0, block_.x), first_[full]);
        }
      }
    }
  }

  /// Room for the largest values and table that a block can have.
  void make_room() {
    const std::uint64_t needed = 1 + end_ + block_.voxels() * 3;
    if (out_.size() < needed)
      out_.resize(std::max<std::uint64_t>(needed, out_.size() + out_.size() / 2));
  }
  std::uint32_t* channel() { return out_.data() + 1; }

  void put_header(std::uint64_t index, std::uint64_t table, std::uint32_t bits,
                  std::uint64_t values) {
    too_large_ |= table >= kMaxTableOffset || values > 0xffffffffu;
    channel()[2 * index] = static_cast<std::uint32_t>(table) | (bits << 24);
    channel()[2 * index + 1] = static_cast<std::uint32_t>(values);
  }
  /// The offset of a table, written at the end unless an equal one exists.
  std::uint64_t put_table(const Word* labels, std::uint32_t count) {
    std::uint32_t words = count * kTableWords<T>;
    const auto* table = reinterpret_cast<const std::uint32_t*>(labels);
    const std::uint64_t offset = tables_.find_or_add(channel(), table, words, end_);
    if (offset == end_) {
      std::memcpy(channel() + end_, labels, std::size_t{count} * sizeof(Word));
      end_ += words;
    }
    return offset;
  }

  void put_uniform(std::uint64_t index, T label) {
    const std::uint64_t values = end_;
    if (!has_uniform_ || label != uniform_label_) {
      const Word word = label;
      uniform_offset_ = put_table(&word, 1);
      uniform_label_ = label;
      has_uniform_ = true;
    }
    put_header(index, uniform_offset_, 0, values);
  }

  void put_mixed(std::uint64_t index, const Coordinate& position) {
    const Coordinate origin{position.x * block_.x, position.y * block_.y, position.z * block_.z};
    width_ = valid(box_.extent.x, origin.x, block_.x);
    height_ = valid(box_.extent.y, origin.y, block_.y);
    depth_ = valid(box_.extent.z, origin.z, block_.z);
    if (width_ == 8) {
      find_runs(origin, std::integral_constant<std::uint32_t, 8>());
    } else {
      find_runs(origin, width_);
    }
    const std::uint32_t count = sort_palette();
    const std::uint32_t bits = count <= 2       ? 1
                               : count <= 4     ? 2
                               : count <= 16    ? 4
                               : count <= 256   ? 8
                               : count <= 65536 ? 16
                                                : 32;
    const std::uint64_t values = end_;
    end_ += (bits * block_.voxels() + 31) / 32;
    pack(channel() + values, bits);
    put_header(index, put_table(table_.data(), count), bits, values);
  }

  template <class Width>
  void find_runs(const Coordinate& origin, Width width) {
    palette_.clear();
    std::uint32_t count = 0;
    const T* previous = nullptr;
    Row* out = rows_.data();
    for (std::uint32_t z = 0; z < depth_; ++z) {
      for (std::uint32_t y = 0; y < height_; ++y, ++out) {
        const T* here = row(origin.y + y, origin.z + z) + origin.x;
        if (previous != nullptr && std::memcmp(here, previous, width * sizeof(T)) == 0) {
          out[0] = out[-1];
        } else {
          out->begin = count;
          runs_[count++] = {0, palette_.index_of(here[0])};
          for (std::uint64_t changes = change_mask(here, width); changes != 0;
               changes &= changes - 1) {
            const auto x = static_cast<std::uint32_t>(std::countr_zero(changes));
            runs_[count++] = {x, palette_.index_of(here[x])};
          }
          out->end = count;
        }
        previous = here;
      }
    }
  }

  /// Fills table_ (labels ascending, each once) and ranks_ (palette index -> table index). Returns
  /// the labels of the table.
  std::uint32_t sort_palette() {
    const std::uint32_t count = palette_.size();
    const Word* labels = palette_.labels();
    if (count == 2) {
      const bool swapped = labels[1] < labels[0];
      ranks_[0] = swapped;
      ranks_[1] = !swapped;
      table_[0] = labels[swapped];
      table_[1] = labels[!swapped];
      return count;
    }
    if (palette_.distinct()) {
      // Rank = how many are smaller: quadratic, but without a branch that could be mispredicted.
      for (std::uint32_t i = 0; i < count; ++i) {
        std::uint32_t rank = 0;
        for (std::uint32_t j = 0; j < count; ++j) rank += labels[j] < labels[i];
        ranks_[i] = rank;
        table_[rank] = labels[i];
      }
      return count;
    }
    for (std::uint32_t i = 0; i < count; ++i) entries_[i] = {labels[i], i};
    segmentation::sort_entries(entries_.data(), spare_.data(), count);
    std::uint32_t rank = 0;
    table_[0] = entries_[0].label;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (entries_[i].label != table_[rank]) table_[++rank] = entries_[i].label;
      ranks_[entries_[i].index] = rank;
    }
    return rank + 1;
  }

  void pack(std::uint32_t* values, std::uint32_t bits) {
    if (block_.x == 8 && bits == 1) return pack_rows<1>(values);
    if (block_.x == 8 && bits == 2) return pack_rows<2>(values);
    if (block_.x == 8 && bits == 4) return pack_rows<4>(values);
    if (block_.x == 8 && bits == 8) return pack_rows<8>(values);
    if (bits == 16) return pack_whole<std::uint16_t>(values);
    std::fill_n(values, (bits * block_.voxels() + 31) / 32, 0u);
    const Row* rows = rows_.data();
    for (std::uint32_t z = 0; z < depth_; ++z) {
      for (std::uint32_t y = 0; y < height_; ++y, ++rows) {
        std::uint64_t bit = std::uint64_t{bits} * block_.x * (y + std::uint64_t{block_.y} * z);
        for (std::uint32_t run = rows->begin; run < rows->end; ++run) {
          const std::uint32_t end = run + 1 < rows->end ? runs_[run + 1].x : width_;
          const std::uint32_t rank = ranks_[runs_[run].index];
          for (std::uint32_t x = runs_[run].x; x < end; ++x, bit += bits)
            values[bit / 32] |= rank << (bit % 32);
        }
      }
    }
  }

  /// Values of whole bytes.
  template <class Value>
  void pack_whole(std::uint32_t* values) {
    std::memset(values, 0, (sizeof(Value) * block_.voxels() + 3) / 4 * 4);
    auto* out = reinterpret_cast<std::byte*>(values);
    const Row* rows = rows_.data();
    for (std::uint32_t z = 0; z < depth_; ++z) {
      for (std::uint32_t y = 0; y < height_; ++y, ++rows) {
        std::byte* row = out + sizeof(Value) * block_.x * (y + std::uint64_t{block_.y} * z);
        for (std::uint32_t run = rows->begin; run < rows->end; ++run) {
          const std::uint32_t end = run + 1 < rows->end ? runs_[run + 1].x : width_;
          const auto rank = static_cast<Value>(ranks_[runs_[run].index]);
          for (std::uint32_t x = runs_[run].x; x < end; ++x)
            std::memcpy(row + sizeof rank * x, &rank, sizeof rank);
        }
      }
    }
  }

  /// Rows of eight values: kBits bytes each.
  template <unsigned kBits>
  void pack_rows(std::uint32_t* values) {
    constexpr std::uint64_t kOnes = ~std::uint64_t{0} / ((std::uint64_t{1} << kBits) - 1);
    const std::uint64_t inside =
        width_ == 8 ? ~std::uint64_t{0} : (std::uint64_t{1} << (kBits * width_)) - 1;
    values[(kBits * block_.voxels() + 31) / 32 - 1] = 0;
    auto* out = reinterpret_cast<std::byte*>(values);
    const Row* rows = rows_.data();
    std::uint32_t packed_begin = ~0u;
    std::uint64_t packed = 0;
    for (std::uint32_t z = 0; z < block_.z; ++z) {
      for (std::uint32_t y = 0; y < block_.y; ++y, out += kBits) {
        if (y >= height_ || z >= depth_) {
          std::memset(out, 0, kBits);
          continue;
        }
        if (rows->begin != packed_begin) {
          packed_begin = rows->begin;
          std::uint64_t rank = ranks_[runs_[packed_begin].index];
          packed = rank * kOnes;
          for (std::uint32_t run = packed_begin + 1; run < rows->end; ++run) {
            const std::uint64_t next = ranks_[runs_[run].index];
            packed ^= ((next ^ rank) * kOnes) << (kBits * runs_[run].x);
            rank = next;
          }
          packed &= inside;
        }
        ++rows;
        std::memcpy(out, &packed, kBits);
      }
    }
  }

  LabelBox<const T> box_;
  BlockSize block_;
  Extent grid_;
  std::vector<std::uint32_t> out_;
  std::uint64_t end_ = 0;  ///< words of the channel so far
  TableIndex tables_;
  bool too_large_ = false;
  std::vector<T> first_;            ///< first label of each block of the row of blocks
  std::vector<std::uint64_t> any_;  ///< zero where such a block has one label
  bool has_uniform_ = false;
  T uniform_label_ = 0;  ///< of the newest uniform block
  std::uint64_t uniform_offset_ = 0;
  Palette<Word> palette_;
  std::vector<segmentation::Entry<Word>> entries_, spare_;
  std::vector<std::uint32_t> ranks_;
  std::vector<Word> table_;
  std::vector<Run> runs_;
  std::vector<Row> rows_;
  std::uint32_t width_ = 0, height_ = 0, depth_ = 0;  ///< of the current block, inside the extent
};

}  // namespace

template <class T>
Expected<std::vector<std::uint32_t>> encode_compressed_segmentation(const LabelBox<const T>& box,
                                                                    const BlockSize& block) {
  const auto legal = [](std::uint32_t edge) { return edge >= 1 && edge <= kMaxBlockEdge; };
  if (!legal(block.x) || !legal(block.y) || !legal(block.z)) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("block: expected edges of 1..{}, found {},{},{}", kMaxBlockEdge,
                            block.x, block.y, block.z));
  }
  // The headers lie before every table: whatever the labels, more headers than this cannot be addressed.
  std::uint64_t headers = 2;
  const std::array edges{std::pair{box.extent.x, block.x}, std::pair{box.extent.y, block.y},
                         std::pair{box.extent.z, block.z}};
  for (const auto& [extent, edge] : edges) {
    const std::uint64_t blocks = extent / edge + (extent % edge != 0 ? 1 : 0);
    if (blocks != 0 && headers >= (kMaxTableOffset + blocks - 1) / blocks) {
      return fail(
          ErrorCode::kTooLarge,
          fmt::format(
              "a table offset needs more than 24 bits: the block headers of {} voxels alone "
              "reach {} words",
              to_string(box.extent), kMaxTableOffset));
    }
    headers *= blocks;
  }
  return StreamEncoder<T>(box, block).encode();
}

template Expected<std::vector<std::uint32_t>> encode_compressed_segmentation(
    const LabelBox<const std::uint8_t>&, const BlockSize&);
template Expected<std::vector<std::uint32_t>> encode_compressed_segmentation(
    const LabelBox<const std::uint16_t>&, const BlockSize&);
template Expected<std::vector<std::uint32_t>> encode_compressed_segmentation(
    const LabelBox<const std::uint32_t>&, const BlockSize&);
template Expected<std::vector<std::uint32_t>> encode_compressed_segmentation(
    const LabelBox<const std::uint64_t>&, const BlockSize&);

}  // namespace cvr::volumes
