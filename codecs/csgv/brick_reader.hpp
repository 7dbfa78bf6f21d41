// How the bricks of an opened payload of the CSGV kind are read: a reader is made whole from the
// tables of the payload and never changes; several threads may use it at once.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codecs/codec.hpp"
#include "codecs/csgv/brick_layout.hpp"
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

/// Facet of readers that find single voxels without decoding their brick.
class VoxelReader {
 public:
  virtual ~VoxelReader() = default;
  /// labels[i] = stored label of the node at `level` (0 = coarsest) that contains points[i].
  virtual BrickError at(const BrickLayout& layout, std::span<const Coordinate> points,
                        unsigned level, std::span<std::uint64_t> labels) const = 0;
};

/// Facet of readers of entropy-coded symbols.
class EntropyTally {
 public:
  virtual ~EntropyTally() = default;
  /// Counts the symbols of a brick's operations.
  virtual BrickError tally(const StoredBrick& brick, const Validity& validity,
                           BrickWorkspace& workspace, SymbolTally& tally) const = 0;
};

class BrickReader {
 public:
  virtual ~BrickReader() = default;
  /// Checks a group for what unpack() and the facets rely on and do not check themselves.
  virtual BrickError check(std::span<const std::uint32_t> group, std::uint32_t bricks,
                           unsigned levels) const = 0;
  /// Rebuilds the levels 0..target of workspace.grid; of levels below the target only what the
  /// target needs.
  virtual BrickError unpack(const StoredBrick& brick, const Validity& validity, unsigned target,
                            BrickWorkspace& workspace) const = 0;
  /// Names the decoder text, adds its constants and the label codes of the volume, and buffers
  /// after start table and bricks.
  virtual Expected<void> describe_to_gpu(const BrickLayout& layout, unsigned threads,
                                         GpuEncoding& encoding) const = 0;

  // Facets, or nullptr.
  virtual const VoxelReader* voxels() const { return nullptr; }
  virtual const EntropyTally* entropy() const { return nullptr; }
};

/// Rebuilds the levels 0..target of workspace.grid from the symbols of a Reader (Reconstruction).
template <class Reader, class Palette>
BrickError rebuild(Reader& reader, const Palette& palette, const Validity& validity,
                   const OperationOptions& options, unsigned target, BrickWorkspace& workspace) {
  Reconstruction<Reader, Palette> reconstruction(reader, palette, workspace.grid, validity,
                                                 options);
  return reconstruction.run(target, workspace.active[0].data(), workspace.active[1].data());
}

}  // namespace cvr::codecs::csgv
