// The stages of one whole brick: multigrid, operations, reconstruction. Counter: voxels per second.
#include <benchmark/benchmark.h>

#include "codecs/csgv/brick_reader.hpp"
#include "codecs/csgv/label_grid.hpp"
#include "codecs/csgv/nibbles.hpp"
#include "codecs/csgv/operations.hpp"
#include "codecs/csgv/reconstruct.hpp"
#include "experiments/micro/sample.hpp"

namespace cvr::micro {
namespace {

using namespace codecs::csgv;

void count_voxels(benchmark::State& state, std::uint32_t side) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(side) * side * side);
}

void multigrid(benchmark::State& state) {
  const auto side = static_cast<std::uint32_t>(state.range(0));
  const volumes::Volume volume = cells(side);
  const Validity validity(side, {side, side, side});
  LabelGrid grid(side);
  for (auto _ : state) {
    grid.build(volume.voxels<std::uint32_t>().data(), side, std::uint64_t{side} * side, validity);
    benchmark::DoNotOptimize(grid.labels(0));
    benchmark::ClobberMemory();
  }
  count_voxels(state, side);
}
BENCHMARK(multigrid)->Arg(32)->Arg(64);

/// Second argument: stop bits.
void operations(benchmark::State& state) {
  const auto side = static_cast<std::uint32_t>(state.range(0));
  const volumes::Volume volume = cells(side);
  const Validity validity(side, {side, side, side});
  LabelGrid grid(side);
  grid.build(volume.voxels<std::uint32_t>().data(), side, std::uint64_t{side} * side, validity);
  OperationStream stream(side);
  const OperationOptions options{
      .stop_bits = state.range(1) != 0, .keep_outside = false, .delta = false};
  for (auto _ : state) {
    stream.encode(grid, validity, options);
    benchmark::DoNotOptimize(stream.symbols().data());
    benchmark::ClobberMemory();
  }
  count_voxels(state, side);
}
BENCHMARK(operations)->ArgsProduct({{32, 64}, {0, 1}});

/// From the nibbles of csgv-nibble to the finest level, in Morton order.
void reconstruct(benchmark::State& state) {
  const auto side = static_cast<std::uint32_t>(state.range(0));
  const std::vector<std::uint32_t> words = encoded_brick("csgv-nibble", side);
  const Validity validity(side, {side, side, side});
  BrickWorkspace workspace(side);
  const unsigned levels = workspace.grid.levels();
  const std::uint32_t palette_size = words[levels];
  for (auto _ : state) {
    NibbleReader reader(words.data() + levels + 1, words.size() - levels - 1 - palette_size);
    Reconstruction run(reader, {words.data() + words.size() - 1, palette_size}, workspace.grid,
                       validity, {.stop_bits = true, .keep_outside = false, .delta = false});
    if (BrickError error =
            run.run(levels - 1, workspace.active[0].data(), workspace.active[1].data())) {
      state.SkipWithError(error);
      return;
    }
    benchmark::DoNotOptimize(workspace.grid.labels(levels - 1));
    benchmark::ClobberMemory();
  }
  count_voxels(state, side);
}
BENCHMARK(reconstruct)->Arg(32)->Arg(64);

/// A whole brick through the decoder of a codec, voxels x fastest.
void decode_brick(benchmark::State& state, const char* codec_id) {
  constexpr std::uint32_t kSide = 64;
  const codecs::Codec& codec = *codecs::find_codec(codec_id);
  const std::vector<std::string> assignments{"brick=64"};
  const auto parameters = codecs::Parameters::parse(codec.parameters(), assignments).value();
  volumes::Volume volume = cells(kSide);
  const auto payload = codec.encode(volumes::MemorySource(volume), parameters, 1).value();
  const auto decoder = codec.open({volume.info(), parameters, payload.bytes.bytes()}).value();
  for (auto _ : state) {
    if (!decoder->brick_access()->decode_brick({0, 0, 0}, 0, volume.data())) {
      state.SkipWithError("the brick does not decode");
      return;
    }
    benchmark::ClobberMemory();
  }
  count_voxels(state, kSide);
}
BENCHMARK_CAPTURE(decode_brick, csgv_nibble, "csgv-nibble");
BENCHMARK_CAPTURE(decode_brick, csgv_rans, "csgv-rans");
BENCHMARK_CAPTURE(decode_brick, csgvr_sb, "csgvr-sb");

}  // namespace
}  // namespace cvr::micro
