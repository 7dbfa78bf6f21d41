// The labels of a volume, ascending, as gaps in Rice codes: [32: labels][5: k][for each: (gap - 1) >> k in unary, the low k bits].
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "codecs/bit_stream.hpp"

namespace cvr::codecs::csgv_ctx {

/// `labels`: ascending, each once, not empty.
inline void write_labels(std::span<const std::uint32_t> labels, BitWriter& out) {
  const auto for_each_gap = [&](auto&& body) {
    std::uint64_t next = 0;
    for (const std::uint32_t label : labels) {
      body(label - next);
      next = std::uint64_t{label} + 1;
    }
  };
  const auto bits_of = [&](unsigned k) {
    std::uint64_t bits = 0;
    for_each_gap([&](std::uint64_t gap) { bits += (gap >> k) + 1 + k; });
    return bits;
  };
  // Sums of gap >> k fall ever more slowly: the first minimum is near the mean gap's k, downhill.
  unsigned best = static_cast<unsigned>(std::bit_width(labels.back() / labels.size()));
  std::uint64_t least = bits_of(best);
  const auto better = [&](unsigned k, std::uint64_t most) {
    const std::uint64_t bits = bits_of(k);
    if (bits > most) return false;
    best = k;
    least = bits;
    return true;
  };
  while (best > 0 && better(best - 1, least)) {
  }
  while (best < 31 && better(best + 1, least - 1)) {
  }
  out.put(static_cast<std::uint32_t>(labels.size()), 32);
  out.put(best, 5);
  for_each_gap([&](std::uint64_t gap) {
    for (std::uint64_t i = 0; i < gap >> best; ++i) out.put(1, 1);
    out.put(0, 1);
    out.put(static_cast<std::uint32_t>(gap & ((std::uint64_t{1} << best) - 1)), best);
  });
}

/// False where the bits are no such list.
inline bool read_labels(BitReader& in, std::vector<std::uint32_t>& labels) {
  labels.clear();
  const std::uint32_t count = in.get(32);
  const unsigned k = in.get(5);
  std::uint64_t next = 0;
  for (std::uint32_t i = 0; i < count && !in.failed(); ++i) {
    std::uint64_t gap = 0;
    while (in.get(1) == 1) ++gap;
    next += (gap << k) + in.get(k);
    if (next > ~std::uint32_t{0}) return false;
    labels.push_back(static_cast<std::uint32_t>(next++));
  }
  return count > 0 && !in.failed();
}

}  // namespace cvr::codecs::csgv_ctx
