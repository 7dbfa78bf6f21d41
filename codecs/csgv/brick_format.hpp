// What distinguishes the codecs of the CSGV families: how the operations and the palette of one brick become words, and back.
// Everything else (cutting the volume into bricks, multigrid, operations, threads, start table) is shared: brick_codec.hpp.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "codecs/bytes.hpp"
#include "codecs/codec.hpp"
#include "codecs/csgv/label_grid.hpp"
#include "codecs/csgv/operations.hpp"
#include "codecs/csgv/reconstruct.hpp"
#include "codecs/succinct/bit_vector.hpp"

namespace cvr::codecs::csgv {

/// How often each symbol occurs: [0] in all coarse levels, [1] in the finest.
using SymbolCounts = std::array<std::array<std::uint64_t, 16>, 2>;

/// Scratch memory of one worker, reused from brick to brick.
struct BrickWorkspace {
  explicit BrickWorkspace(std::uint32_t b)
      : grid(b), active{std::vector<std::uint32_t>(nodes_of_level(grid.levels() - 2)),
                        std::vector<std::uint32_t>(nodes_of_level(grid.levels() - 2))} {}
  LabelGrid grid;
  std::array<std::vector<std::uint32_t>, 2> active;  ///< for Reconstruction::run
};

/// Scratch memory of BrickFormat::pack, one a worker.
struct PackWorkspace {
  std::vector<std::uint8_t> bytes;
  std::array<succinct::BitAppender, 5> wavelet_levels;
  succinct::BitAppender matrix, stops;
};

/// Where the bricks of an opened payload lie.
struct BrickLayout {
  std::uint32_t brick;          ///< voxels a side
  unsigned levels;
  Extent extent;                ///< of the volume
  Extent grid;                  ///< bricks along each axis
  const std::uint32_t* starts;  ///< bricks + 1 entries, in words from `words`
  const std::uint32_t* words;
  std::uint64_t index(const Coordinate& c) const { return c.x + grid.x * (c.y + grid.y * c.z); }
  std::span<const std::uint32_t> brick_words(std::uint64_t i) const { return {words + starts[i], words + starts[i + 1]}; }
  BrickExtent brick_extent(const Coordinate& c) const;
};

class BrickFormat {
 public:
  virtual ~BrickFormat() = default;
  virtual OperationOptions options() const = 0;

  /// Formats with static tables see the counts of sampled bricks first; every `sampling()`-th brick an axis, 0 = no pre-pass.
  virtual unsigned sampling() const { return 0; }
  virtual void fit(const SymbolCounts&) {}
  virtual void write_tables(ByteWriter&) const {}
  virtual Expected<void> read_tables(ByteReader&) { return {}; }

  /// Appends one brick to `words`. Called by several threads at once.
  virtual void pack(const OperationStream& operations, PackWorkspace& workspace, std::vector<std::uint32_t>& words,
                    ByteBreakdown& bytes) const = 0;
  /// Rebuilds the levels 0..target of workspace.grid.
  virtual BrickError unpack(std::span<const std::uint32_t> words, const Validity& validity, unsigned target,
                            BrickWorkspace& workspace) const = 0;
  /// Checks what unpack() and at() rely on; formats without voxel access may leave it to unpack().
  virtual BrickError check(std::span<const std::uint32_t>, unsigned /*levels*/) const { return nullptr; }

  virtual bool has_voxel_access() const { return false; }
  /// labels[i] = stored label of the node at `level` (0 = coarsest) that contains points[i].
  virtual BrickError at(const BrickLayout&, std::span<const Coordinate>, unsigned /*level*/, std::span<std::uint64_t>) const {
    return "no voxel access";
  }

  /// Names the decoder text and adds its constants, and buffers after start table and bricks.
  virtual void describe_to_gpu(GpuEncoding& encoding) const = 0;
};

/// The layout that the formats share: L level starts, then the palette size.
inline void append_level_starts(const OperationStream& operations, std::vector<std::uint32_t>& words) {
  for (unsigned l = 0; l < operations.levels(); ++l) words.push_back(operations.level_start(l));
  words.push_back(static_cast<std::uint32_t>(operations.palette().size()));
}

/// The palette ends a brick, newest entry first: entry k is the k-th word from the end.
inline void append_palette(const OperationStream& operations, std::vector<std::uint32_t>& words) {
  words.insert(words.end(), operations.palette().rbegin(), operations.palette().rend());
}

/// Appends a whole brick of plain nibbles: level starts, palette size, symbols (8 a word, first in the low nibble), palette.
void append_nibble_brick(const OperationStream& operations, std::vector<std::uint32_t>& words, ByteBreakdown& bytes);

/// Hands out nibbles; a Reader for Reconstruction.
class NibbleReader {
 public:
  NibbleReader(const std::uint32_t* words, std::uint64_t word_count) : words_(words), end_(8 * word_count) {}
  void begin_level(unsigned, bool) {}
  bool take(unsigned count, std::uint64_t& codes) {
    if (position_ + count > end_) return false;
    const std::uint64_t word = position_ / 8;
    std::uint64_t nibbles = words_[word];
    if ((word + 1) * 8 < end_) nibbles |= std::uint64_t{words_[word + 1]} << 32;
    nibbles >>= 4 * (position_ % 8);
    codes = nibbles_to_bytes(static_cast<std::uint32_t>(nibbles));
    if (count < 8) codes &= (std::uint64_t{1} << (8 * count)) - 1;
    position_ += count;
    return true;
  }

 private:
  const std::uint32_t* words_;
  std::uint64_t end_;
  std::uint64_t position_ = 0;
};

}  // namespace cvr::codecs::csgv
