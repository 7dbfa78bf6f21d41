// The transform of 4x4x4 blocks: DCT-II or Karhunen-Loeve, its 64 coefficients cut into zones and
// partitions (Fout & Ma 2007, sections 3 and 4).
//
// Voxel (x, y, z) of a block is number i = x + 4y + 16z. Coefficient (u, v, w) counts the orders
// along x, y, z; the zone is the octant [u >= 2] + 2 [v >= 2] + 4 [w >= 2]. Coefficients are kept
// in *partition order*, eight a zone:
//
//   0        DC, 8 times the mean
//   1..7     zone 0, with DC the lowest octant          partition LP (7)
//   8..31    zones x, y, z                              partition BP (24)
//   32..63   zones xy, xz, yz, xyz                      partition HP (32)
//
// A basis is stored as integers, so that every machine projects code vectors back to the same
// voxels.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codecs/codec.hpp"

namespace cvr::codecs::tvq {

inline constexpr unsigned kBlockEdge = 4;
inline constexpr unsigned kBlockVoxels = 64;
inline constexpr unsigned kZones = 8;
inline constexpr unsigned kPartitions = 3;
inline constexpr std::array<unsigned, kPartitions> kPartitionBegin{1, 8, 32};
inline constexpr std::array<unsigned, kPartitions> kPartitionSize{7, 24, 32};

enum class TransformKind : std::uint8_t {
  kDct,
  kKltSeparable,  ///< along each axis the KLT of lines of 4 with the constant vector kept, so that DC stays the mean
  kKltFull,  ///< of whole blocks without their mean; vectors go to the zone that their spectrum lies in
};

/// Position in partition order of the coefficient u + 4v + 16w.
std::array<std::uint8_t, kBlockVoxels> partition_order();

/// 64 orthonormal vectors of 64 voxels, to 2^-14.
class Basis {
 public:
  static constexpr unsigned kFractionBits = 24;
  static constexpr int kStoredOne = 1 << 14;  ///< the greatest stored component, 1

  /// What a file stores: nothing for kDct, 3 x 4 x 4 (axis, order, place) for kKltSeparable, 63 x
  /// 64 for kKltFull; units of 2^-14.
  Basis(TransformKind kind, std::span<const std::int16_t> stored);
  static Basis dct() { return {TransformKind::kDct, {}}; }
  static std::size_t stored_values(TransformKind kind);

  TransformKind kind() const { return kind_; }
  std::span<const std::int16_t> stored() const { return stored_; }
  /// Voxel i of the vector at place k in partition order, times 2^24.
  std::int32_t fixed(unsigned k, unsigned i) const { return fixed_[k * kBlockVoxels + i]; }
  /// The same as a number.
  float value(unsigned k, unsigned i) const { return static_cast<float>(fixed(k, i)) * 0x1p-24f; }

  /// Replaces each block (64 voxels) by its coefficients in partition order. A block's mean is
  /// taken off first, in double precision, so that a block of one value has nothing but DC.
  void forward(std::span<float> blocks, unsigned threads) const;
  /// Voxels of one block from coefficients in partition order.
  std::array<float, kBlockVoxels> inverse(std::span<const float> coefficients) const;

  /// The KLT of the blocks. Where variances agree the vectors are those of the DCT; the largest
  /// component of each is positive. The moments of 8-bit samples are exact, so equal statistics
  /// along the axes give equal matrices.
  static Basis fit(TransformKind kind, std::span<const float> blocks, unsigned threads);

 private:
  TransformKind kind_;
  std::vector<std::int16_t> stored_;
  std::vector<std::int32_t> fixed_;
};

/// Eigenvectors of a symmetric n x n matrix (row-major) as rows, by descending eigenvalue; cyclic
/// Jacobi rotations in double precision.
std::vector<double> eigenvectors(std::vector<double> matrix, unsigned n);

/// One of ten kinds of blocks by the zones that they need; bit t of keeps = zone t in partition
/// order.
struct BlockClass {
  std::string_view name;
  std::uint8_t keeps;
};
inline constexpr unsigned kClasses = 10;
inline constexpr std::array<BlockClass, kClasses> kBlockClasses{{{"zero", 0x00},
                                                                 {"LP", 0x01},
                                                                 {"BPx", 0x03},
                                                                 {"BPy", 0x05},
                                                                 {"BPz", 0x09},
                                                                 {"BPxyz", 0x0f},
                                                                 {"HPxy", 0x1f},
                                                                 {"HPxz", 0x2f},
                                                                 {"HPyz", 0x4f},
                                                                 {"HPxyz", 0xff}}};

/// Energies of the eight zones of a block without DC.
std::array<double, kZones> zone_energies(const float* coefficients);
/// The cheapest class whose truncation costs a mean squared error of at most `tau_squared`
/// (Parseval: no inverse transform). Among the three directions of BP and of HP the best is tried;
/// ties go to the first.
unsigned classify(const std::array<double, kZones>& energies, double tau_squared);

}  // namespace cvr::codecs::tvq
