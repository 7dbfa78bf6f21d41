// The contract of every codec: what it tells about itself, how it encodes, and what its decoder can
// do.
//
// A codec turns a volume source into a payload; the container (container.hpp) puts an envelope
// around it that names codec, version, parameters, extent and type and carries the checksum, so
// that a file decodes without further knowledge. Codecs hold no state: one constant object of each
// lives in the registry. They know no Vulkan, no YAML and no clock, and they never print. Encoding
// gives the same bytes for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codecs/gpu_encoding.hpp"
#include "codecs/gpu_samples.hpp"
#include "codecs/parameters.hpp"
#include "volumes/error.hpp"
#include "volumes/source.hpp"
#include "volumes/volume.hpp"

namespace cvr::codecs {

using volumes::Buffer;
using volumes::Coordinate;
using volumes::Error;
using volumes::ErrorCode;
using volumes::Expected;
using volumes::Extent;
using volumes::fail;
using volumes::SlabSink;
using volumes::Volume;
using volumes::VolumeInfo;
using volumes::VolumeKind;
using volumes::VolumeSource;
using volumes::VoxelType;

/// The smallest part of a volume that can be decoded without decoding more.
enum class Granularity : std::uint8_t { kVolume, kBrick, kBlock, kVoxel };
std::string_view name_of(Granularity granularity);

/// What the bytes of an encoded file are for.
enum class ByteClass : std::uint8_t {
  kHeader,      ///< envelope and per-brick or per-block headers
  kIndex,       ///< brick start tables, chunk tables, offsets
  kOperations,  ///< operation streams, wavelet matrices, palette indices: what is said of each
                ///< voxel
  kStopBits,
  kRank,     ///< rank structures
  kPalette,  ///< labels
  kTables,   ///< frequency tables, label remap tables, window dictionaries
  kData,     ///< the opaque output of a general-purpose compressor
  kPadding,
};
inline constexpr std::size_t kByteClasses = 9;
std::string_view name_of(ByteClass byte_class);

/// Bytes of one class that lie side by side near the front of a payload.
struct FrontPart {
  ByteClass byte_class;
  std::uint64_t bytes = 0;      ///< 0: all of the class
  std::uint32_t alignment = 1;  ///< of its begin
};

struct Traits {
  std::string_view id;       ///< fixed identifier, for instance "csgvr-sb"
  std::uint32_t version;     ///< of the payload format; a decoder refuses others
  std::string_view family;   ///< "general", "neuroglancer", "compresso", "csgv", "csgvr"
  std::string_view summary;  ///< one line for lists
  bool lossless;
  std::span<const VoxelType> types;  ///< accepted voxel types
  Granularity access;
  bool levels_of_detail;   ///< decodes coarser levels without the finer ones
  bool stored_compressed;  ///< usually stored under gzip or xz: the rates at rest are of interest
                           ///< too
  bool gpu_decodable = false;      ///< decoders of label volumes have a gpu_encoding()
  bool gpu_scalars = false;        ///< decoders of scalar volumes have gpu_samples()
  std::vector<FrontPart> front{};  ///< the parts that a payload begins with, in their order
};

/// Why a codec cannot encode volumes of this type and kind: kUnsupported. Lossy codecs take scalars
/// alone, since an approximate label is a wrong one.
Expected<void> accepts(const Traits& traits, const VolumeInfo& info);

/// Bytes by use; the sum is the size of the encoded file exactly.
class ByteBreakdown {
 public:
  std::uint64_t& operator[](ByteClass c) { return bytes_[static_cast<std::size_t>(c)]; }
  std::uint64_t operator[](ByteClass c) const { return bytes_[static_cast<std::size_t>(c)]; }
  ByteBreakdown& operator+=(const ByteBreakdown& other) {
    for (std::size_t i = 0; i < kByteClasses; ++i) bytes_[i] += other.bytes_[i];
    return *this;
  }
  std::uint64_t total() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t n : bytes_) sum += n;
    return sum;
  }

 private:
  std::array<std::uint64_t, kByteClasses> bytes_{};
};

/// A codec's own bytes, without the envelope.
struct Payload {
  Buffer bytes;
  ByteBreakdown breakdown;        ///< sums to bytes.size()
  std::uint64_t published_bytes;  ///< by the accounting of the papers' tables, for instance bricks
                                  ///< + start table
};

/// What a decoder is opened on: the facts of the envelope and a view of the payload, which must
/// outlive the decoder.
struct Stream {
  VolumeInfo info;
  Parameters parameters;
  std::span<const std::byte> payload;
};

/// Optional facet: single voxels without decoding their brick.
///
/// Scalars pass through this door as bits: u8 and u16 zero-extended, i16 as the 16 bits of its
/// two's complement, f32 as its 32 bits.
class VoxelAccess {
 public:
  virtual ~VoxelAccess() = default;
  /// labels[i] = label (or scalar) of the level-`lod` node that contains the finest voxel points[i]
  /// (0 = finest level). Every point must lie inside the extent of the volume. One virtual call for
  /// many points: this loop is what is timed.
  virtual Expected<void> at(std::span<const Coordinate> points, unsigned lod,
                            std::span<std::uint64_t> labels) const = 0;
};

/// Optional facet: single bricks, decoded alone.
class BrickAccess {
 public:
  virtual ~BrickAccess() = default;
  virtual Extent brick_size() const = 0;  ///< at the finest level
  virtual Extent brick_grid() const = 0;  ///< bricks along each axis, x fastest
  /// Writes the labels of a brick at a level to `out`, x fastest, in the volume's type. The brick's
  /// extent at that level is ceil(brick_size / 2^lod), cut at the volume's level extent
  /// (level_extent).
  virtual Expected<void> decode_brick(const Coordinate& brick, unsigned lod,
                                      std::byte* out) const = 0;
  /// The label of a brick that has one alone, where that can be told without decoding it; none
  /// where it has several, or where only decoding could tell.
  virtual Expected<std::optional<std::uint64_t>> only_label(const Coordinate& /*brick*/) const {
    return std::nullopt;
  }
};

/// Optional facet of lossy codecs: coarser approximations of the finest level, each from a prefix
/// of the payload.
class ProgressiveAccess {
 public:
  virtual ~ProgressiveAccess() = default;
  virtual unsigned steps()
      const = 0;  ///< at least 2; the last is the whole payload; a step may add nothing
  virtual std::string_view step_name(unsigned step) const = 0;  ///< for instance "DC", "+LP"
  virtual std::uint64_t step_bytes(
      unsigned step) const = 0;  ///< bytes of the payload that steps 0..step need, exactly
  /// Like Decoder::decode(0, ...), from the bytes of steps 0..step alone.
  virtual Expected<void> decode_step(unsigned step, unsigned threads, SlabSink& sink) const = 0;
};

/// How far the decoded finest level is from the original, over all voxels, in units of the voxel
/// values.
struct RecordedError {
  double largest;  ///< largest absolute error
  double mean_squared;
};

/// Opened on one stream; thread-safe for concurrent const calls.
class Decoder {
 public:
  virtual ~Decoder() = default;
  /// Levels of detail that can be decoded; 1 = only the finest.
  virtual unsigned levels() const { return 1; }
  /// Delivers the whole level `lod` < levels() in slabs of ascending z, in the volume's voxel type.
  virtual Expected<void> decode(unsigned lod, unsigned threads, SlabSink& sink) const = 0;
  virtual const VoxelAccess* voxel_access() const { return nullptr; }
  virtual const BrickAccess* brick_access() const { return nullptr; }
  virtual const ProgressiveAccess* progressive_access() const { return nullptr; }
  /// What a lossy encoder measured on its own output and the payload carries: its promise, which
  /// every decoding must keep (to 1e-6 of the value). Of lossless codecs none.
  virtual std::optional<RecordedError> recorded_error() const { return std::nullopt; }
  /// What the operations and stop bits would take if they were coded at the empirical entropy of
  /// the codec's own model (its contexts and alphabets, its tables for nothing), in bytes. None
  /// where the codec has no entropy coder of its own. Decodes the volume.
  virtual Expected<std::optional<std::uint64_t>> entropy_bytes(unsigned threads) const;
  /// What a GPU needs to decode this stream in bricks of `brick` voxels per side; 0: the codec's own
  /// edge, or 32 where it has none. Buffers may view the payload or the decoder. Errors:
  /// kUnsupported (no decoder text), kBadArgument (a codec with bricks serves no other edge; the
  /// others serve powers of two, 2..64), kMalformed (bytes that the texts could not be trusted
  /// with).
  virtual Expected<GpuEncoding> gpu_encoding(std::uint32_t brick, unsigned threads) const;
  /// What a GPU needs to decode single scalars of the finest level after progressive step `step` (0
  /// where there are none). Errors: kUnsupported (labels, or no decoder text).
  virtual Expected<GpuSamples> gpu_samples(unsigned step) const;
};

class Codec {
 public:
  virtual ~Codec() = default;
  virtual const Traits& traits() const = 0;
  virtual std::span<const ParameterSpec> parameters() const = 0;
  /// `source.info().type` is one of traits().types and the extent is not empty (the container
  /// checks both).
  virtual Expected<Payload> encode(const VolumeSource& source, const Parameters& parameters,
                                   unsigned threads) const = 0;
  /// Checks everything that later calls rely on: after success no call of the decoder reads outside
  /// the payload, whatever the bytes are.
  virtual Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const = 0;
  /// The largest absolute error that parameters promise, in voxel values; none where they promise
  /// none. Whether it was kept tells Decoder::recorded_error(): number formats may end before the
  /// promise does.
  virtual std::optional<double> promised_error(const Parameters& parameters) const;
};

/// Extent of level `lod`: ceil(extent / 2^lod), at least 1 an axis.
Extent level_extent(const Extent& finest, unsigned lod);
/// Info of the decoded level: extent shrunk, voxel size grown. A level whose cells lie in two time
/// steps has no steps any more.
VolumeInfo level_info(const VolumeInfo& finest, unsigned lod);

}  // namespace cvr::codecs
