// What distinguishes the codecs of the CSGV families: how the operations and the palette of one
// brick become words, and back. Everything else (cutting the volume into bricks, multigrid,
// operations, threads, start table) is shared: brick_codec.hpp.
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
#include "codecs/csgv/symbol_tally.hpp"

namespace cvr::codecs::csgv {

/// Scratch memory of one worker, reused from brick to brick.
struct BrickWorkspace {
  explicit BrickWorkspace(std::uint32_t b)
      : grid(b),
        active{std::vector<std::uint32_t>(nodes_of_level(grid.levels() - 2)),
               std::vector<std::uint32_t>(nodes_of_level(grid.levels() - 2))} {}
  LabelGrid grid;
  std::array<std::vector<std::uint32_t>, 2>
      active;                          ///< nodes of two levels that have coded children
  std::vector<std::uint32_t> palette;  ///< of formats that do not store it as it is
};

/// One brick of the volume that is encoded, after each stage.
struct SourceBrick {
  const LabelGrid& grid;
  const Validity& validity;
  const OperationStream& operations;
};

/// What a worker has counted of the bricks that it was shown. Workers are merged in any order:
/// counts must only add up.
class BrickStatistics {
 public:
  virtual ~BrickStatistics() = default;
  virtual void add(const SourceBrick& brick) = 0;
  virtual void merge(const BrickStatistics& other) = 0;
};

/// Which bricks are counted before the first is encoded: every `stride`-th an axis, halved while
/// fewer than `few` are seen, doubled while more than `most` are.
struct Sampling {
  unsigned stride;
  std::uint64_t few = 0, most = ~std::uint64_t{0};
};

/// Scratch memory of BrickFormat::pack, one a worker; formats derive their own.
class PackWorkspace {
 public:
  virtual ~PackWorkspace() = default;
};

/// A brick among the words of its group.
struct StoredBrick {
  std::span<const std::uint32_t> words;
  std::uint32_t member;  ///< its place in the group, x fastest
  std::uint32_t bricks;  ///< of the group
};

/// Where the bricks of a payload lie. Bricks are stored in groups of up to group^3, groups x
/// fastest.
struct BrickLayout {
  BrickLayout(const Extent& volume, std::uint32_t brick_edge, std::uint32_t group_edge);

  std::uint32_t brick;  ///< voxels a side
  std::uint32_t group;  ///< bricks a side of a group
  unsigned levels;
  Extent extent;                          ///< of the volume
  Extent grid;                            ///< bricks along each axis
  Extent groups;                          ///< groups along each axis
  const std::uint32_t* starts = nullptr;  ///< of each group and the end, in words from `words`
  const std::uint32_t* words = nullptr;

  std::uint64_t index(const Coordinate& c) const { return c.x + grid.x * (c.y + grid.y * c.z); }
  /// The group of a brick, and the bricks of a group along each axis: fewer at the volume's border.
  Coordinate group_at(const Coordinate& c) const { return {c.x / group, c.y / group, c.z / group}; }
  std::uint64_t group_index(const Coordinate& g) const {
    return g.x + groups.x * (g.y + groups.y * g.z);
  }
  Extent bricks_of_group(const Coordinate& g) const;
  /// A brick's place in its group, x fastest.
  std::uint32_t member(const Coordinate& c) const;
  StoredBrick stored(const Coordinate& brick) const;
  std::span<const std::uint32_t> group_words(std::uint64_t i) const {
    return {words + starts[i], words + starts[i + 1]};
  }
  BrickExtent brick_extent(const Coordinate& c) const;
};

class BrickFormat {
 public:
  virtual ~BrickFormat() = default;
  virtual OperationOptions options() const = 0;

  /// Bricks a side of what is stored together and has one entry in the start table.
  virtual std::uint32_t group() const { return 1; }

  /// Whether pack() and statistics() ask for the operations; formats that find their own save the
  /// time.
  virtual bool wants_operations() const { return true; }

  /// Formats that number the labels of the volume are told them before anything else, ascending.
  virtual bool wants_labels() const { return false; }
  virtual void set_labels(std::vector<std::uint32_t>) {}

  /// Formats with static tables see sampled bricks first: a counter for each worker, then the sum.
  /// nullptr: no tables.
  virtual Sampling sampling() const { return {1}; }
  virtual std::unique_ptr<BrickStatistics> statistics() const { return nullptr; }
  virtual void fit(const BrickStatistics&) {}
  virtual void write_tables(ByteWriter&) const {}
  virtual Expected<void> read_tables(ByteReader&) { return {}; }

  virtual std::unique_ptr<PackWorkspace> pack_workspace() const {
    return std::make_unique<PackWorkspace>();
  }
  /// Takes the bricks of a group one after the other, x fastest; finish_group ends it. Either may
  /// append to `words`, which hold this group and earlier ones. Called by several threads at once,
  /// each with a workspace of its own.
  virtual void pack(const SourceBrick& brick, PackWorkspace& workspace,
                    std::vector<std::uint32_t>& words, ByteBreakdown& bytes) const = 0;
  virtual void finish_group(PackWorkspace&, std::vector<std::uint32_t>& /*words*/,
                            ByteBreakdown&) const {}
  /// Formats whose tables are fitted to every brick keep what they need of all bricks first: pack()
  /// and finish_group() append no words; then fit_kept() sees the workspaces of all workers, and
  /// write_kept() appends the n-th group that `kept` has finished, with a write_workspace() for
  /// what it needs on the way.
  virtual bool keeps_bricks() const { return false; }
  virtual void fit_kept(std::span<PackWorkspace* const>) {}
  virtual std::unique_ptr<PackWorkspace> write_workspace() const { return nullptr; }
  virtual void write_kept(const PackWorkspace& /*kept*/, std::size_t /*n*/,
                          PackWorkspace& /*scratch*/, std::vector<std::uint32_t>& /*words*/,
                          ByteBreakdown&) const {}

  /// Rebuilds the levels 0..target of workspace.grid; of levels below the target only what the
  /// target needs.
  virtual BrickError unpack(const StoredBrick& brick, const Validity& validity, unsigned target,
                            BrickWorkspace& workspace) const = 0;
  /// Formats with an entropy coder count the symbols of a brick's operations; the others have no
  /// entropy of their own.
  virtual bool has_entropy() const { return false; }
  virtual BrickError tally(const StoredBrick&, const Validity&, BrickWorkspace&,
                           SymbolTally&) const {
    return nullptr;
  }
  /// Checks what unpack() and at() rely on; formats without voxel access may leave it to unpack().
  virtual BrickError check(std::span<const std::uint32_t> /*group*/, std::uint32_t /*bricks*/,
                           unsigned /*levels*/) const {
    return nullptr;
  }

  virtual bool has_voxel_access() const { return false; }
  /// labels[i] = stored label of the node at `level` (0 = coarsest) that contains points[i].
  virtual BrickError at(const BrickLayout&, std::span<const Coordinate>, unsigned /*level*/,
                        std::span<std::uint64_t>) const {
    return "no voxel access";
  }

  /// Names the decoder text, adds its constants and the label codes of the volume, and buffers
  /// after start table and bricks.
  virtual Expected<void> describe_to_gpu(const BrickLayout& layout, unsigned threads,
                                         GpuEncoding& encoding) const = 0;
};

/// What the published formats tell a GPU of their bricks, each a group of its own that ends with a
/// palette: all labels, and the words of the largest brick without its palette. Checks every
/// palette, which formats without voxel access leave unchecked on opening.
Expected<void> add_palettes(const BrickLayout& layout, unsigned threads, GpuEncoding& encoding);

/// The layout that the formats share: L level starts, then the palette size.
inline void append_level_starts(const OperationStream& operations,
                                std::vector<std::uint32_t>& words) {
  for (unsigned l = 0; l < operations.levels(); ++l) words.push_back(operations.level_start(l));
  words.push_back(static_cast<std::uint32_t>(operations.palette().size()));
}

/// The palette ends a brick, newest entry first: entry k is the k-th word from the end.
inline void append_palette(const OperationStream& operations, std::vector<std::uint32_t>& words) {
  words.insert(words.end(), operations.palette().rbegin(), operations.palette().rend());
}

/// Appends a whole brick of plain nibbles: level starts, palette size, symbols (8 a word, first in
/// the low nibble), palette.
void append_nibble_brick(const OperationStream& operations, std::vector<std::uint32_t>& words,
                         ByteBreakdown& bytes);

/// Hands out nibbles; a Reader for Reconstruction.
class NibbleReader {
 public:
  NibbleReader(const std::uint32_t* words, std::uint64_t word_count)
      : words_(words), end_(8 * word_count) {}
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
