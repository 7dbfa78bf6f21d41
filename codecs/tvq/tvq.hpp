// Vector quantisation of blocks of 4x4x4 voxels: vq of whole blocks, hvq of a hierarchy of means (Schneider & Westermann 2003), tvq of
// transform coefficients with classified codebooks (Fout & Ma 2007).
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& vq_codec();
const Codec& hvq_codec();
const Codec& tvq_codec();

/// What decoders of vq, hvq and tvq can do besides (dynamic_cast from Decoder): the memory that a device needs to draw from them.
/// shaders/shared/tvq.glsl reads it, and so does VoxelAccess.
class DeviceImage {
 public:
  virtual ~DeviceImage() = default;
  virtual std::uint64_t index_bytes() const = 0;  ///< one record of codes a block, packed bit by bit
  virtual std::uint64_t book_bytes() const = 0;   ///< associated codebooks: one entry a voxel (hvq: octants in its first book)
  /// Rows, books and records as words.
  virtual std::span<const std::uint32_t> words() const = 0;
};

}  // namespace cvr::codecs
