// The frame of every CSGV codec: cuts the volume into bricks, encodes and decodes them in parallel,
// keeps the start table.
//
// Payload, little endian:
//   u64      number of remapped labels R (0: labels are stored as they are)
//   R x u64  the labels, ascending; the bricks store their index
//   u32 u32  bytes of the format's tables, zero
//   ...      the tables, padded to 4 bytes
//   u32 x (groups + 1)   start of each group of bricks in words, and the end; groups x fastest; of the published formats each brick is one
//   u32 ...  the groups
// Volumes of u64 are remapped when a label does not fit in 32 bits. By the papers' accounting only
// start table and bricks count.
#pragma once

#include <functional>
#include <memory>

#include "codecs/bytes.hpp"
#include "codecs/codec.hpp"
#include "codecs/csgv/brick_reader.hpp"
#include "codecs/csgv/encoder_strategy.hpp"
#include "codecs/csgv/operations.hpp"

namespace cvr::codecs::csgv {

/// Reads all labels that the bricks of a volume will store, ascending. Takes a pass over the
/// volume.
using StoredLabels = std::function<std::vector<std::uint32_t>()>;

/// What distinguishes the codecs of the CSGV kind: how one group of bricks becomes words, and back.
/// An immutable description for one set of parameters; what it makes does not refer to it.
class BrickFormat {
 public:
  BrickFormat(std::uint32_t brick_edge, const OperationOptions& operation_options,
              std::uint32_t group_edge = 1)
      : brick(brick_edge), group(group_edge), options(operation_options) {}
  virtual ~BrickFormat() = default;

  /// For that many workers. Formats that number the labels of the volume ask for them.
  virtual EncoderStrategy encoder(unsigned threads, const StoredLabels& labels) const = 0;
  /// The tables are those that the encoder has fitted, none of a streaming one. Fails where they
  /// are none that an encoder writes.
  virtual Expected<std::unique_ptr<const BrickReader>> reader(ByteReader& tables) const = 0;

  const std::uint32_t brick;  ///< voxels per side
  const std::uint32_t group;  ///< bricks per side of what has one entry in the start table
  const OperationOptions options;
};

/// Makes the format of a codec from its parameters.
using MakeFormat = std::function<std::unique_ptr<const BrickFormat>(const Parameters&)>;

class BrickCodec final : public Codec {
 public:
  BrickCodec(Traits traits, std::vector<ParameterSpec> parameters, MakeFormat make_format)
      : traits_(std::move(traits)),
        parameters_(std::move(parameters)),
        make_format_(std::move(make_format)) {}
  const Traits& traits() const override { return traits_; }
  std::span<const ParameterSpec> parameters() const override { return parameters_; }
  Expected<Payload> encode(const VolumeSource& source, const Parameters& parameters,
                           unsigned threads) const override;
  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const override;

 private:
  Traits traits_;
  std::vector<ParameterSpec> parameters_;
  MakeFormat make_format_;
};

/// The parameter "brick".
std::uint32_t brick_edge(const Parameters& parameters);
/// "brick": 16, 32 or 64 voxels per side; 32 by default.
ParameterSpec brick_parameter();
/// "delta": whether operations may refer to older palette entries; 0 by default, as in the
/// published evaluation.
ParameterSpec delta_parameter();
/// Traits that all codecs of the two families share.
Traits brick_traits(std::string_view id, std::string_view family, std::string_view summary,
                    Granularity access);

}  // namespace cvr::codecs::csgv
