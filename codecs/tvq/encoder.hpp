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
  bool shared_books = false;  ///< of a series: one set of books for all time steps of a place
};

/// Surveys the source, trains and codes one sub-volume after the other, decodes the result and
/// writes its error into it. Of a series one time step of a sub-volume is in memory at a time,
/// apart from the codes.
Expected<Payload> encode(const Scheme& scheme, const VolumeSource& source,
                         const EncoderSettings& settings, unsigned threads);

}  // namespace cvr::codecs::tvq
