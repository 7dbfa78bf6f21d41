// What a parallel loop costs to start: volumes::parallel_for, and a thread started per call beside
// it. Argument: threads, and microseconds of work in each of 8 indices.
#include <benchmark/benchmark.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "volumes/parallel.hpp"

namespace cvr::micro {
namespace {

constexpr std::uint64_t kIndices = 8;

void work(std::int64_t microseconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(microseconds);
  while (microseconds > 0 && std::chrono::steady_clock::now() < end) continue;
}

void loop_of_the_pool(benchmark::State& state) {
  for (auto _ : state) {
    volumes::parallel_for(static_cast<unsigned>(state.range(0)), kIndices,
                          [&](unsigned, std::uint64_t) { work(state.range(1)); });
  }
}
BENCHMARK(loop_of_the_pool)->ArgsProduct({{2, 4, 8}, {0, 10, 100}})->UseRealTime();

void loop_of_new_threads(benchmark::State& state) {
  for (auto _ : state) {
    std::atomic<std::uint64_t> next = 0;
    const auto serve = [&] {
      while (next++ < kIndices) work(state.range(1));
    };
    std::vector<std::jthread> threads;
    for (std::int64_t i = 1; i < state.range(0); ++i) threads.emplace_back(serve);
    serve();
  }
}
BENCHMARK(loop_of_new_threads)->ArgsProduct({{2, 4, 8}, {0, 10, 100}})->UseRealTime();

}  // namespace
}  // namespace cvr::micro
