#include "codecs/csgv_ctx/gpu_tables.hpp"

#include <bit>

namespace cvr::codecs::csgv_ctx {

namespace {

static_assert(kStaticBits == 14 && kDynamicBits == CVR_CTX_DYNAMIC_BITS &&
              kProbabilityBits == CVR_CTX_PROBABILITY_BITS && kMostDynamic == CVR_CTX_MOST_ASKED &&
              kWide == CVR_CTX_WIDE && kWideBits == CVR_CTX_WIDE_BITS &&
              kNumberKinds == CVR_CTX_NUMBER_KINDS);

/// The symbol of each slot, a nibble each.
void append_slots(const Distribution& distribution, std::vector<std::uint32_t>& words) {
  for (std::uint32_t slot = 0; slot < kProbabilitySum; slot += 8) {
    std::uint32_t word = 0;
    for (unsigned i = 0; i < 8; ++i) word |= distribution.symbol(slot + i) << (4 * i);
    words.push_back(word);
  }
}

GpuBuffer owned_buffer(const char* use, std::span<const std::uint32_t> words) {
  auto owned = std::make_shared<volumes::Buffer>();
  owned->append(words.data(), words.size_bytes());
  return {use, owned->bytes(), owned};
}

}  // namespace

void describe_tables(const ContextModel& model, std::span<const std::uint32_t> labels,
                     std::uint32_t group, unsigned label_bits, GpuEncoding& encoding) {
  std::vector<std::uint32_t> words(model.classes().begin(), model.classes().end());
  const auto rows_at = static_cast<std::uint32_t>(words.size());
  for (std::size_t i = 0; i < model.rows().size(); i += 4) {
    std::uint32_t word = 0;
    for (std::size_t k = i; k < std::min(i + 4, model.rows().size()); ++k)
      word |= std::uint32_t{model.rows()[k]} << (8 * (k - i));
    words.push_back(word);
  }
  const auto slots_at = static_cast<std::uint32_t>(words.size());
  for (const Distribution& d : model.distributions()) append_slots(d, words);
  const auto symbols_at = static_cast<std::uint32_t>(words.size());
  for (const Distribution& d : model.distributions()) {
    for (unsigned s = 0; s < kSymbols; ++s)
      words.push_back(d.start[s] | std::uint32_t{d.frequency[s]} << 16);
  }
  encoding.decoder = "csgv_ctx";
  encoding.together = true;
  encoding.constants = {
      {"CVR_CTX_GROUP_SHIFT", static_cast<std::uint32_t>(std::countr_zero(group))},
      {"CVR_CTX_LABEL_BITS", label_bits},
      {"CVR_CTX_ROWS_AT", rows_at},
      {"CVR_CTX_SLOTS_AT", slots_at},
      {"CVR_CTX_SYMBOLS_AT", symbols_at},
      {"CVR_CTX_NUMBERS", model.first_number()}};
  encoding.codes.assign(labels.begin(), labels.end());
  encoding.buffers.push_back(owned_buffer("labels", labels));
  encoding.buffers.push_back(owned_buffer("tables", words));
}

}  // namespace cvr::codecs::csgv_ctx
