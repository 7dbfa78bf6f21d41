#include "codecs/registry.hpp"

#include <array>

#include "codecs/astc/astc.hpp"
#include "codecs/bc4/bc4.hpp"
#include "codecs/compresso/compresso.hpp"
#include "codecs/csgv/csgv.hpp"
#include "codecs/csgv_ctx/csgv_ctx.hpp"
#include "codecs/csgvr/csgvr.hpp"
#include "codecs/general/general.hpp"
#include "codecs/neuroglancer/neuroglancer.hpp"
#include "codecs/raw/raw.hpp"
#include "codecs/tvq/tvq.hpp"
#include "codecs/zfp/zfp.hpp"

namespace cvr::codecs {

std::span<const Codec* const> all_codecs() {
  static const std::array kCodecs{
      &raw_codec(),
      &zstd_codec(),
      &lzma_codec(),
      &hdf5_gzip_codec(),
      &neuroglancer_codec(),
      &compresso_codec(),
      &compresso_lzma_codec(),
      &csgv_nibble_codec(),
      &csgv_rans_codec(),
      &csgv_ctx_codec(),
      &csgvr_nibble_codec(),
      &csgvr_codec(),
      &csgvr_sb_codec(),
      &csgvr_c_codec(),
      &vq_codec(),
      &hvq_codec(),
      &tvq_codec(),
      &zfp_codec(),
      &astc_codec(),
      &bc4_codec(),
  };
  return kCodecs;
}

const Codec* find_codec(std::string_view id) {
  for (const Codec* codec : all_codecs()) {
    if (codec->traits().id == id) return codec;
  }
  return nullptr;
}

}  // namespace cvr::codecs
