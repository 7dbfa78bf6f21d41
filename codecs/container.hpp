// The envelope around every payload: a file names its codec, version, parameters, extent and type,
// and carries a checksum.
//
// Layout, little endian, packed:
//   0   8 bytes  magic "CVRBENCH"
//   8   u32      container version: 1; 2 of a series; 3 of a volume whose offset is not zero
//   12  u32      header size H in bytes: where the payload starts
//   16  u64      payload size P; the file is H + P bytes long
//   24  u64      XXH3-64 of the payload
//   32  u64      XXH3-64 of the header with this field zero
//   40  u32      codec version
//   44  u8 u8 u16  voxel type, volume kind, zero
//   48  3 x u64  extent x, y, z
//   72  3 x f64  voxel size x, y, z
//       u64      of versions 2 and 3: time steps, of version 2 at least 2, which divide extent z
//       3 x f64  of version 3: offset x, y, z
//   96  (of version 2: 104, of version 3: 128) three strings (u16 length, bytes): codec id,
//   parameters in canonical form, voxel unit; zeros up
//       to a multiple of 8
//   H-80  u64      published bytes (see Payload)
//   H-72  9 x u64  the breakdown in the order of ByteClass; the whole header counts as kHeader;
//   sums to H + P
#pragma once

#include <memory>
#include <string>

#include "codecs/codec.hpp"

namespace cvr::codecs {

struct Encoded {
  Buffer bytes;                   ///< the whole file
  ByteBreakdown breakdown;        ///< sums to bytes.size()
  std::uint64_t published_bytes;  ///< see Payload
};

/// An encoded file, its envelope read and its checksums verified. Views the bytes it was opened on.
struct OpenedFile {
  const Codec* codec;
  Stream stream;
  std::uint64_t header_bytes;
  std::uint64_t published_bytes;
  ByteBreakdown breakdown;  ///< sums to the size of the file
};

/// A part of an encoded file with a name of its own.
struct Section {
  std::string name;
  std::uint64_t begin, end;  ///< bytes of the file
};
/// The envelope; then the steps of a progressive codec, or the parts that its traits say a payload
/// begins with, and the rest. Without gaps.
std::vector<Section> sections_of(const OpenedFile& file, const Decoder& decoder);

/// Encodes a source into a whole file. Fails when the codec does not accept the type, the extent is
/// empty or an axis exceeds 2^40 voxels, or the codec itself fails.
Expected<Encoded> encode(const Codec& codec, const VolumeSource& source,
                         const Parameters& parameters, unsigned threads);

/// Reads the envelope; verifies both checksums. `bytes` must lie at a multiple of 8, as every
/// allocation does: words are read in place.
Expected<OpenedFile> open_file(std::span<const std::byte> bytes);

/// Opens the decoder of a file. `bytes` must outlive it.
Expected<std::unique_ptr<Decoder>> open_decoder(const OpenedFile& file);

/// The whole level `lod` in memory.
Expected<Volume> decode(std::span<const std::byte> bytes, unsigned lod, unsigned threads);

/// Decodes everything that can be decoded, at all levels, and throws it away: proves that a file is
/// whole.
Expected<void> validate(std::span<const std::byte> bytes, unsigned threads);

}  // namespace cvr::codecs
