// From voxels to samples: what an encoder must know of a whole volume, and blocks of 4x4x4 samples
// near the origin.
#pragma once

#include <optional>

#include "codecs/tvq/format.hpp"

namespace cvr::codecs::tvq {

/// The value of zero blocks, which are exact.
enum class ZeroValue : std::uint8_t {
  kZero,   ///< 0 where the range of the volume holds it, else its least value
  kLeast,  ///< the least value
  kMode,   ///< the most frequent value; not of f32
};

/// One pass over a source: the domain of its samples and the voxels that are not finite.
struct Survey {
  Domain domain;
  std::vector<ExceptionRun> exceptions;
  std::vector<std::uint32_t> exception_bits;
};
/// Errors: kUnsupported where voxels are not finite and `mask` is false (the message has their
/// number and the first position), or for the mode of f32.
Expected<Survey> survey(const VolumeSource& source, ZeroValue zero, bool mask);

/// Samples of the blocks of a part of the volume, 64 a block, x fastest. Blocks beyond the volume's
/// far sides repeat its last voxels. Voxels that are not finite become the mean of the finite ones
/// of their block.
std::vector<float> read_blocks(const VolumeSource& source, const Domain& domain,
                               const volumes::Box& box);

/// Units a sample.
inline double units_of(const Domain& domain) { return static_cast<double>(1u << domain.fraction); }

}  // namespace cvr::codecs::tvq
