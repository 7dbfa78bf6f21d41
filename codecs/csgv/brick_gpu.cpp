#include "codecs/csgv/brick_gpu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "codecs/label_codes.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::csgv {

namespace {

constexpr std::uint64_t kBricksAPiece = 256;
/// No encoder writes as many words (b = 64: 8 nibbles and a palette entry a node); the texts
/// address bits in 32 bits.
constexpr std::uint64_t kMaxBrickWords = std::uint64_t{1} << 20;

/// The palette of a brick, or an empty span where the words hold none that the texts could read.
std::span<const std::uint32_t> palette_of(std::span<const std::uint32_t> words, unsigned levels) {
  const std::uint64_t header = levels + 1;
  if (words.size() <= header || words.size() > kMaxBrickWords ||
      words[levels] > words.size() - header)
    return {};
  return words.last(words[levels]);
}

}  // namespace

Expected<GpuEncoding> gpu_encoding(const BrickLayout& layout, std::span<const std::uint64_t> remap,
                                   const BrickReader& reader, std::uint32_t brick,
                                   unsigned threads) {
  if (brick != 0 && brick != layout.brick) {
    return fail(
        ErrorCode::kBadArgument,
        fmt::format("brick edge: this stream has bricks of {}, asked for {}", layout.brick, brick));
  }
  GpuEncoding encoding;
  const std::uint64_t groups = layout.groups.voxels();
  encoding.buffers.push_back(
      {"starts", std::as_bytes(std::span(layout.starts, groups + 1)), nullptr});
  encoding.buffers.push_back(
      {"bricks", std::as_bytes(std::span(layout.words, layout.starts[groups])), nullptr});
  encoding.brick = layout.brick;
  encoding.levels = layout.levels;
  encoding.voxel_access = reader.voxels() != nullptr;
  encoding.serial = true;
  encoding.cell_loops =
      8 * (layout.levels +
           6);  // hops, each with loops over levels; longer chains are possible and rare
  encoding.brick_loops =
      nodes_of_level(layout.levels - 1) / 7 + 2 * layout.levels;  // one for eight nodes
  encoding.remap = remap;
  if (auto ok = reader.describe_to_gpu(layout, std::max(1u, threads), encoding); !ok)
    return tl::unexpected(ok.error());
  if (!remap.empty() && encoding.codes.back() >= remap.size())
    return fail(ErrorCode::kMalformed, "a label leaves the remap table");
  return encoding;
}

Expected<void> add_palettes(const BrickLayout& layout, unsigned threads, GpuEncoding& encoding) {
  const std::uint64_t bricks = layout.groups.voxels();
  DistinctLabels distinct(threads);
  std::atomic<bool> whole = true;
  std::vector<std::uint64_t> most(threads,
                                  0);  // words of a worker's largest brick without its palette
  volumes::parallel_for(threads, (bricks + kBricksAPiece - 1) / kBricksAPiece,
                        [&](unsigned worker, std::uint64_t piece) {
                          const std::uint64_t end = std::min(bricks, (piece + 1) * kBricksAPiece);
                          for (std::uint64_t i = piece * kBricksAPiece; i < end; ++i) {
                            const auto words = layout.group_words(i);
                            const auto palette = palette_of(words, layout.levels);
                            if (palette.empty()) whole = false;
                            distinct.add(worker, palette);
                            most[worker] = std::max<std::uint64_t>(most[worker],
                                                                   words.size() - palette.size());
                          }
                        });
  if (!whole)
    return fail(ErrorCode::kMalformed,
                "a brick has no palette, or one that is longer than the brick");
  const std::vector<std::uint64_t> labels = distinct.take();
  encoding.codes.assign(labels.begin(), labels.end());
  encoding.shared_words =
      encoding.voxel_access ? static_cast<std::uint32_t>(std::ranges::max(most)) : 0;
  return {};
}

}  // namespace cvr::codecs::csgv
