// What the codecs of independent blocks of scalars share: the cutting into blocks, threads, slabs,
// single voxels, and the recorded error. A codec adds a BlockFormat, which codes runs of whole
// blocks. FORMAT.md beside this file has the layout of the payload.
//
// Blocks are numbered x fastest, then y, then z, within layers of equal z; a run is up to 64
// consecutive blocks of one layer. Runs start at words of 64 bits, so that threads write and read
// them apart whatever the number of bits per block. Blocks that stick out of the volume are filled by
// repeating its last voxels, the rule that adds the least high frequencies; what lies outside is
// neither stored again nor counted in the error.
#pragma once

#include <memory>

#include "codecs/codec.hpp"
#include "codecs/scalar_range.hpp"

namespace cvr::codecs::scalar_blocks {

inline constexpr unsigned kRunBlocks = 64;

/// Codes runs of whole blocks; serves one thread at a time. Voxels lie block after block, each x
/// fastest, in the volume's type.
class BlockCoder {
 public:
  virtual ~BlockCoder() = default;
  /// Encodes the `count` <= kRunBlocks blocks of one run into `words`, which are zero and as many
  /// as max_words(count) says. Returns the number of words used: max_words(count) where all blocks
  /// have the same size.
  virtual Expected<std::uint64_t> encode(const std::byte* voxels, unsigned count,
                                         std::uint64_t* words) = 0;
  /// Decodes blocks first .. first + count - 1 of a run. Words come from a payload whose sizes were
  /// checked and nothing else.
  virtual Expected<void> decode(std::span<const std::byte> words, unsigned first, unsigned count,
                                std::byte* voxels) = 0;
  /// Whether single voxels are decoded without their block, by voxel().
  virtual bool has_voxels() const { return false; }
  /// The bits (see VoxelAccess) of voxel `index` of block `block` of a run.
  virtual std::uint64_t voxel(std::span<const std::byte>, unsigned, unsigned) { return 0; }
};

class BlockFormat {
 public:
  virtual ~BlockFormat() = default;
  virtual Extent block() const = 0;
  /// Bits of every block; where their sizes differ, of the largest possible, and fixed_size() is
  /// false.
  virtual std::uint64_t bits() const = 0;
  virtual bool fixed_size() const { return true; }
  /// One for each thread.
  virtual std::unique_ptr<BlockCoder> coder() const = 0;

  std::uint64_t max_words(std::uint64_t blocks) const { return (blocks * bits() + 63) / 64; }
};

/// What a payload begins with: the recorded error and the range, then where runs of blocks begin.
inline const std::vector<FrontPart> kFront{{ByteClass::kHeader}, {ByteClass::kIndex}};

/// A codec that is a BlockFormat. It takes u8, u16, i16 and f32.
class ScalarBlocksCodec : public Codec {
 public:
  Expected<Payload> encode(const VolumeSource& source, const Parameters& parameters,
                           unsigned threads) const final;
  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const final;

 protected:
  /// `range` is that of the volume.
  virtual std::unique_ptr<const BlockFormat> format(VoxelType type, const Parameters& parameters,
                                                    const ScalarRange& range) const = 0;
};

}  // namespace cvr::codecs::scalar_blocks
