#include "codecs/csgv_ctx/gpu_tables.hpp"

namespace cvr::codecs::csgv_ctx {

void describe_tables(const ContextModel&, std::span<const std::uint32_t> labels, unsigned label_bits, GpuEncoding& encoding) {
  encoding.decoder = "csgv_ctx";
  encoding.constants = {{"CVR_CTX_LABEL_BITS", label_bits}};
  encoding.codes.assign(labels.begin(), labels.end());
}

}  // namespace cvr::codecs::csgv_ctx
