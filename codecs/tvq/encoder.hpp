// The encoder that the three codecs share.
#pragma once

#include "codecs/tvq/decoder.hpp"
#include "codecs/tvq/train.hpp"

namespace cvr::codecs::tvq {

struct EncoderSettings {
  Options options;
  ZeroValue zero = ZeroValue::kZero;
  bool mask = false;
  std::uint32_t edge = 0;
};

/// Surveys the source, trains and codes one sub-volume after the other, decodes the result and writes its error into it.
Expected<Payload> encode(const Scheme& scheme, const VolumeSource& source, const EncoderSettings& settings, unsigned threads);

/// One sub-volume from samples (64 a block). `voxels`: those inside the volume, which the rate is measured in.
SubVolume encode_part(const Scheme& scheme, const Domain& domain, const Extent& blocks, std::vector<float> samples, std::uint64_t voxels,
                      const Options& options, unsigned threads);

}  // namespace cvr::codecs::tvq
