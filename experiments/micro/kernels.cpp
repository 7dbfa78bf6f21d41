// Kernels below a brick: rank, wavelet access, Morton codes, rANS, palette look-up. Counter: items
// per second. Positions are drawn before the loop; each kernel touches the whole structure in
// random order.
#include <benchmark/benchmark.h>

#include "codecs/entropy/rans.hpp"
#include "experiments/micro/sample.hpp"
#include "shaders/shared/shared.hpp"

namespace cvr::micro {
namespace {

using codecs::entropy::RansDecoder;
using codecs::entropy::RansTable;
using shaders::CsgvrBrick;
using shaders::Words;

constexpr std::size_t kQueries = 4096;

std::vector<std::uint32_t> positions(std::uint32_t below) {
  std::vector<std::uint32_t> drawn(kQueries);
  for (std::size_t i = 0; i < kQueries; ++i)
    drawn[i] = static_cast<std::uint32_t>(random_at(i) % below);
  return drawn;
}

void count_items(benchmark::State& state, std::size_t items_an_iteration) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(items_an_iteration));
}

struct OpenBrick {
  explicit OpenBrick(const char* codec, std::uint32_t side, bool stop_bits)
      : words(encoded_brick(codec, side)) {
    while ((1u << (levels - 1)) < side) ++levels;
    brick = shaders::cvr_csgvr_open({words.data()}, static_cast<std::uint32_t>(words.size()),
                                    levels, stop_bits);
  }
  Words view() const { return {words.data()}; }
  std::uint32_t symbols() const { return words[brick.z_at + CVR_WAVELET_LEVELS]; }
  std::uint32_t w_bits() const { return words[levels + 1]; }

  std::vector<std::uint32_t> words;
  std::uint32_t levels = 1;
  CsgvrBrick brick{};
};

void rank(benchmark::State& state) {
  const OpenBrick open("csgvr", static_cast<std::uint32_t>(state.range(0)), false);
  const auto at = positions(open.w_bits());
  for (auto _ : state) {
    for (const std::uint32_t i : at)
      benchmark::DoNotOptimize(cvr_rank1(open.view(), open.brick.w, i));
  }
  count_items(state, kQueries);
}
BENCHMARK(rank)->Arg(32)->Arg(64);

void wavelet_access(benchmark::State& state) {
  const OpenBrick open("csgvr-sb", static_cast<std::uint32_t>(state.range(0)), true);
  const auto at = positions(open.symbols());
  for (auto _ : state) {
    for (const std::uint32_t i : at) {
      std::uint32_t advances = 0;
      benchmark::DoNotOptimize(cvr_csgvr_operation(open.view(), open.brick, i, advances));
      benchmark::DoNotOptimize(advances);
    }
  }
  count_items(state, kQueries);
}
BENCHMARK(wavelet_access)->Arg(32)->Arg(64);

/// One voxel of the finest level: chain of references, palette index, label. Second argument: stop
/// bits.
void csgvr_at(benchmark::State& state) {
  const auto side = static_cast<std::uint32_t>(state.range(0));
  const bool stop_bits = state.range(1) != 0;
  const OpenBrick open(stop_bits ? "csgvr-sb" : "csgvr", side, stop_bits);
  const auto at = positions(side * side * side);
  std::uint64_t chain = 0;
  for (auto _ : state) {
    for (const std::uint32_t n : at) {
      std::uint32_t index = 0;
      std::uint32_t hops = 0;
      cvr_csgvr_palette_index(open.view(), open.brick, n, open.levels - 1, index, hops);
      benchmark::DoNotOptimize(cvr_csgvr_label(open.view(), open.brick, index));
      chain += hops;
    }
  }
  count_items(state, kQueries);
  state.counters["hops"] =
      static_cast<double>(chain) / static_cast<double>(state.iterations() * kQueries);
}
BENCHMARK(csgvr_at)->ArgsProduct({{32, 64}, {0, 1}});

void palette_lookup(benchmark::State& state) {
  const OpenBrick open("csgvr-sb", 64, true);
  const auto at = positions(open.brick.palette_size);
  for (auto _ : state) {
    for (const std::uint32_t i : at)
      benchmark::DoNotOptimize(cvr_csgvr_label(open.view(), open.brick, i));
  }
  count_items(state, kQueries);
}
BENCHMARK(palette_lookup);

void morton_encode(benchmark::State& state) {
  const auto at = positions(1u << 18);
  for (auto _ : state) {
    for (const std::uint32_t i : at) {
      benchmark::DoNotOptimize(shaders::cvr_morton_encode(i & 63, i >> 6 & 63, i >> 12));
    }
  }
  count_items(state, kQueries);
}
BENCHMARK(morton_encode);

void morton_gather(benchmark::State& state) {
  const auto at = positions(1u << 18);
  for (auto _ : state) {
    for (const std::uint32_t i : at) benchmark::DoNotOptimize(shaders::cvr_morton_gather(i));
  }
  count_items(state, kQueries);
}
BENCHMARK(morton_gather);

/// Symbols in the proportions of a finest level: nearly all "parent".
struct RansSample {
  RansSample() : symbols(1u << 16) {
    std::array<std::uint64_t, 16> counts{};
    for (std::size_t i = 0; i < symbols.size(); ++i) {
      const std::uint64_t r = random_at(i) % 100;
      symbols[i] = static_cast<std::uint8_t>(r < 90 ? 0 : r < 98 ? 1 + r % 3 : 4 + r % 2);
      ++counts[symbols[i]];
    }
    table = RansTable::fit(counts, 0x3f);
    table.encode(symbols, bytes);
  }
  std::vector<std::uint8_t> symbols, bytes;
  RansTable table;
};

void rans_encode(benchmark::State& state) {
  const RansSample sample;
  std::vector<std::uint8_t> out;
  for (auto _ : state) {
    out.clear();
    sample.table.encode(sample.symbols, out);
    benchmark::DoNotOptimize(out.data());
  }
  count_items(state, sample.symbols.size());
}
BENCHMARK(rans_encode);

void rans_decode(benchmark::State& state) {
  const RansSample sample;
  for (auto _ : state) {
    RansDecoder decoder(sample.table, sample.bytes);
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < sample.symbols.size(); ++i) sum += decoder.next();
    benchmark::DoNotOptimize(sum);
  }
  count_items(state, sample.symbols.size());
}
BENCHMARK(rans_decode);

}  // namespace
}  // namespace cvr::micro
