// What a file of vq, hvq or tvq holds, in memory; FORMAT.md has the bytes.
//
// One decoder serves all three: a block of 4x4x4 voxels is a code of DC and a code into each of up
// to three books, and
//
//   sum(i) = DC + sum over books of scale * entry[code][i]         in units of 2^-fraction (samples for integers, see Domain for f32)
//
// All of it is integer arithmetic. The three differ in their books:
//   vq    no DC, one book of 64 voxels
//   hvq   DC, a book of 8 octants (2x2x2 voxels each), a book of 64 voxels    (Schneider & Westermann 2003)
//   tvq   DC, books LP, BP, HP of 64 voxels: inverse transforms of code vectors of 7, 24, 32 coefficients    (Fout & Ma 2007)
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "codecs/codec.hpp"
#include "codecs/tvq/transform.hpp"

namespace cvr::codecs::tvq {

inline constexpr unsigned kMaxBooks = 3;
inline constexpr unsigned kMaxBookBits = 14;
inline constexpr unsigned kMaxDcBits = 16;
/// No term of a sum exceeds this, so sums stay below 2^28.
inline constexpr std::int64_t kLargestTerm = std::int64_t{1} << 26;

/// So that projections stay below 2^63.
inline constexpr std::uint32_t kLargestStep = 200000;

struct Scheme {
  std::string_view id;
  bool dc;
  unsigned books;
  std::array<unsigned, kMaxBooks> length;  ///< entries of a code vector: 64 voxels or 8 octants
  std::array<unsigned, kMaxBooks>
      coefficients;  ///< where the file stores coefficients: how many a vector; else 0
  std::array<std::string_view, kMaxBooks + 1> steps;

  bool has_transform() const { return coefficients[0] != 0; }
  /// Whether code 0 of each book adds nothing. Without DC it is the zero block, entry by entry.
  bool zero_vectors() const { return dc; }
};
inline constexpr Scheme kVq{"vq", false, 1, {64, 0, 0}, {0, 0, 0}, {"DC", "+blocks", "", ""}};
inline constexpr Scheme kHvq{"hvq",      true,      2,
                             {8, 64, 0}, {0, 0, 0}, {"DC", "+octants", "+voxels", ""}};
inline constexpr Scheme kTvq{"tvq",        true,        3,
                             {64, 64, 64}, {7, 24, 32}, {"DC", "+LP", "+BP", "+HP"}};

/// How voxels become numbers near the origin and sums become voxels.
///
/// Integers: sum = (voxel - zero) * 2^fraction, voxel = clamp(zero + round(sum / 2^fraction), low,
/// high). f32: sum = (voxel - offset) * 2^(fraction - exponent), voxel = offset + clamp(sum, low,
/// high) * 2^(exponent - fraction), where the product is exact and the addition is the only
/// rounding (but for denormals).
struct Domain {
  VoxelType type = VoxelType::kU8;
  unsigned fraction = 0;
  std::int32_t zero = 0;      ///< the value of zero blocks; 0 for f32
  float offset = 0;           ///< the same for f32; 0 for integers
  std::int32_t exponent = 0;  ///< floor(log2(max - min)) of f32; 0 for integers
  std::int32_t low = 0, high = 0;

  static unsigned fraction_of(VoxelType type) {
    return type == VoxelType::kU8 ? 5 : type == VoxelType::kF32 ? 20 : 4;
  }
};

/// Code vectors of one class, side by side in a book.
struct Chapter {
  std::uint8_t block_class;
  std::uint32_t size;
};

struct Book {
  std::uint32_t size = 1;        ///< code vectors; code 0 is the zero vector (Scheme::zero_vectors)
  std::uint16_t scale = 1;       ///< units an entry
  std::uint8_t entry_bytes = 1;  ///< of an entry on a device: 1 or 2
  std::uint32_t step =
      0;  ///< of coefficients, in 2^-8 units, at most kLargestStep; 0: the file stores the entries
  std::vector<std::int16_t> coefficients;  ///< size x Scheme::coefficients, if step > 0
  std::vector<std::int16_t> entries;       ///< size x Scheme::length
  std::vector<Chapter> chapters;           ///< sizes sum to size - 1; none: one unclassified book

  unsigned bits() const { return static_cast<unsigned>(std::bit_width(size - 1)); }
};

/// What the codes of a sub-volume mean: its own, or that of its place at all time steps.
struct BookSet {
  Basis basis = Basis::dct();
  std::array<Book, kMaxBooks> books;
};

/// A part of one time step.
struct SubVolume {
  Extent blocks;
  unsigned dc_bits = 0;
  std::int32_t dc_base = 0;       ///< units; what every sum starts from, with or without DC codes
  std::uint32_t dc_step = 0;      ///< units a DC code
  std::vector<std::uint16_t> dc;  ///< one per block, x fastest
  std::array<std::vector<std::uint16_t>, kMaxBooks>
      codes;  ///< the same; empty where the book has 0 bits
};

/// Voxels that are not finite, kept bit by bit. Runs ascend and do not touch.
struct ExceptionRun {
  std::uint64_t first;
  std::uint64_t count;
};

struct Encoding {
  Domain domain;
  std::uint32_t edge = 0;  ///< voxels per side of a sub-volume, a multiple of 4; 0: one a time step
  RecordedError error{};
  std::vector<ExceptionRun> exceptions;
  std::vector<std::uint32_t> exception_bits;  ///< one per voxel of the runs
  std::vector<SubVolume> parts;               ///< x fastest, then y, z, time
  std::vector<BookSet> books;  ///< one a part, or one a part of the first time step for all steps

  /// Sub-volumes of a time step.
  Extent grid(const Extent& step) const {
    return edge == 0 ? Extent{1, 1, 1} : ceil_div(step, edge);
  }
  const BookSet& books_of(std::size_t part) const { return books[part % books.size()]; }
};

/// The voxels of the sub-volume at a position of the grid, from the first of its time step.
volumes::Box box_of(const Extent& step, std::uint32_t edge, const Coordinate& part);

/// Fills `entries` from `coefficients`: the inverse transform in integers, rounded to units of
/// `scale`, cut to entry_bytes.
void project(Book& book, unsigned partition, const Basis& basis);

/// Bytes that end the steps of progressive decoding: DC, then each book with its codes.
using StepBytes = std::array<std::uint64_t, kMaxBooks + 1>;

Payload write_payload(const Scheme& scheme, const Encoding& encoding);
/// Where the two doubles of the recorded error lie in a payload.
inline constexpr std::size_t kErrorOffset = 24;
/// Checks all that decoding relies on, entries computed and every code below the size of its book.
Expected<Encoding> read_payload(const Scheme& scheme, const VolumeInfo& info,
                                std::span<const std::byte> payload, StepBytes& steps);

/// Memory of a device that draws from the encoding: `index`, one record of all codes a block, and
/// `books`, the entries. Both in bytes (paper, Fig. 6 and 7).
struct DeviceBytes {
  std::uint64_t index, books;
  std::uint64_t total() const { return index + books; }
};
DeviceBytes device_bytes(const Scheme& scheme, const Encoding& encoding);

}  // namespace cvr::codecs::tvq
