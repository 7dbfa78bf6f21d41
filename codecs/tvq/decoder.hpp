// The decoder that the three codecs share.
#pragma once

#include "codecs/tvq/format.hpp"
#include "codecs/tvq/tvq.hpp"

namespace cvr::codecs::tvq {

/// A decoder of what is in memory. Error: kTooLarge where words of the device image have no 32-bit
/// addresses.
Expected<std::unique_ptr<Decoder>> make_decoder(const Scheme& scheme, const VolumeInfo& info,
                                                const Encoding& encoding, const StepBytes& steps);
Expected<std::unique_ptr<Decoder>> open(const Scheme& scheme, const Stream& stream);

}  // namespace cvr::codecs::tvq
