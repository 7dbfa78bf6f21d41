// The decoder: whole levels by layers of blocks, single chunks, single voxels.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <mutex>
#include <optional>

#include "codecs/neuroglancer/gpu.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::neuroglancer {

namespace {

using volumes::CompressedSegmentation;
using volumes::LabelBox;

struct Level {
  Extent extent;
  Extent grid;  ///< chunks
  std::vector<CompressedSegmentation> chunks;
};

/// The error of the smallest index, whichever thread meets its error first.
class FirstError {
 public:
  void note(std::uint64_t index, const Error& error) {
    const std::scoped_lock lock(mutex_);
    if (error_ && index_ <= index) return;
    index_ = index;
    error_ = error;
  }
  Expected<void> result() const {
    if (error_) return tl::unexpected(*error_);
    return {};
  }

 private:
  std::mutex mutex_;
  std::uint64_t index_ = 0;
  std::optional<Error> error_;
};

class NeuroglancerDecoder final : public Decoder, public VoxelAccess, public BrickAccess {
 public:
  NeuroglancerDecoder(const VolumeInfo& info, const volumes::BlockSize& block, std::uint32_t edge,
                      std::vector<Level> levels, Buffer aligned)
      : info_(info),
        block_(block),
        edge_(edge),
        levels_(std::move(levels)),
        aligned_(std::move(aligned)) {}

  unsigned levels() const override { return static_cast<unsigned>(levels_.size()); }
  const VoxelAccess* voxel_access() const override { return this; }
  const BrickAccess* brick_access() const override { return this; }
  Extent brick_size() const override { return {edge_, edge_, edge_}; }
  Extent brick_grid() const override { return levels_[0].grid; }

  Expected<void> decode(unsigned lod, unsigned threads, SlabSink& sink) const override {
    const Level& level = levels_[lod];
    return volumes::with_label_type(info_.type, [&]<class T>() -> Expected<void> {
      for (std::uint64_t z0 = 0; z0 < level.extent.z;) {
        const std::vector<Layers> pieces = next_slab(level, z0, sink.preferred_depth());
        const std::uint64_t z1 = pieces.back().z1;
        auto* out = reinterpret_cast<T*>(sink.begin(z0, z1));
        FirstError error;
        const std::uint64_t columns = level.grid.x * level.grid.y;
        volumes::parallel_for(threads, pieces.size() * columns, [&](unsigned, std::uint64_t i) {
          const Layers& piece = pieces[i / columns];
          const Coordinate chunk{i % columns % level.grid.x, i % columns / level.grid.x,
                                 piece.chunk};
          const Coordinate origin{chunk.x * edge_, chunk.y * edge_, piece.z0 - z0};
          const LabelBox<T> box{out + level.extent.index(origin),
                                {},
                                level.extent.x,
                                level.extent.x * level.extent.y};
          const auto done =
              level.chunks[level.grid.index(chunk)].decode_layers(piece.begin, piece.end, box);
          if (!done) error.note(i, done.error());
        });
        if (auto ok = error.result(); !ok) return ok;
        sink.end(z0, z1);
        z0 = z1;
      }
      return {};
    });
  }

  Expected<void> at(std::span<const Coordinate> points, unsigned lod,
                    std::span<std::uint64_t> labels) const override {
    if (lod >= levels_.size()) {
      return fail(ErrorCode::kBadArgument, fmt::format("level of detail: expected 0..{}, found {}",
                                                       levels_.size() - 1, lod));
    }
    const std::uint64_t largest = volumes::with_label_type(
        info_.type, []<class T>() -> std::uint64_t { return std::numeric_limits<T>::max(); });
    const Level& level = levels_[lod];
    std::uint64_t widest = 0;
    const auto look_up = [&](auto divide) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Coordinate c{points[i].x >> lod, points[i].y >> lod, points[i].z >> lod};
        const Coordinate chunk{divide(c.x), divide(c.y), divide(c.z)};
        const Coordinate inside{c.x - chunk.x * edge_, c.y - chunk.y * edge_,
                                c.z - chunk.z * edge_};
        labels[i] = level.chunks[level.grid.index(chunk)].label(inside);
        widest = std::max(widest, labels[i]);
      }
    };
    if (std::has_single_bit(edge_)) {
      look_up([shift = std::countr_zero(edge_)](std::uint64_t n) { return n >> shift; });
    } else {
      look_up([edge = edge_](std::uint64_t n) { return n / edge; });
    }
    if (widest > largest)
      return fail(ErrorCode::kMalformed, fmt::format("a label exceeds {}", largest));
    return {};
  }

  Expected<void> decode_brick(const Coordinate& brick, unsigned lod,
                              std::byte* out) const override {
    if (lod >= levels_.size() || !levels_[0].grid.contains(brick)) {
      return fail(
          ErrorCode::kBadArgument,
          fmt::format("brick {},{},{} at level {}: expected a brick of {} and a level below {}",
                      brick.x, brick.y, brick.z, lod, to_string(levels_[0].grid), levels_.size()));
    }
    const Level& level = levels_[lod];
    const std::uint32_t edge = edge_ >> lod;
    const Extent size = chunk_extent(level.extent, edge, brick);
    return volumes::with_label_type(info_.type, [&]<class T>() -> Expected<void> {
      auto* voxels = reinterpret_cast<T*>(out);
      if (lod == 0) {
        const CompressedSegmentation& chunk = level.chunks[level.grid.index(brick)];
        return chunk.decode_layers(0, chunk.grid().z, volumes::dense_box(voxels, size));
      }
      // A coarser brick is a part of a chunk of its level.
      const Coordinate origin{brick.x * edge, brick.y * edge, brick.z * edge};
      const Coordinate chunk{origin.x / edge_, origin.y / edge_, origin.z / edge_};
      const CompressedSegmentation& stream = level.chunks[level.grid.index(chunk)];
      for (std::uint64_t i = 0; i < size.voxels(); ++i) {
        const Coordinate inside{origin.x % edge_ + i % size.x,
                                origin.y % edge_ + i / size.x % size.y,
                                origin.z % edge_ + i / size.x / size.y};
        const std::uint64_t label = stream.label(inside);
        if (label > std::numeric_limits<T>::max())
          return fail(ErrorCode::kMalformed, "a label exceeds the voxel type");
        voxels[i] = static_cast<T>(label);
      }
      return {};
    });
  }

  Expected<GpuEncoding> gpu_encoding(std::uint32_t brick, unsigned threads) const override {
    std::vector<StoredLevel> stored;
    for (const Level& level : levels_) stored.push_back({level.extent, level.grid, level.chunks});
    return neuroglancer::gpu_encoding(*this, info_, block_, edge_, stored, brick == 0 ? 32 : brick,
                                      threads);
  }

 private:
  /// Layers [begin, end) of blocks of one chunk row; they hold the planes [z0, z1) of the level.
  struct Layers {
    std::uint64_t chunk;
    std::uint64_t begin, end;
    std::uint64_t z0, z1;
  };

  /// The layers of about `depth` planes from z0 on: at least one layer, and no more than the level
  /// has.
  std::vector<Layers> next_slab(const Level& level, std::uint64_t z0, std::uint64_t depth) const {
    std::vector<Layers> pieces;
    for (std::uint64_t z = z0; z < level.extent.z;) {
      const std::uint64_t chunk = z / edge_;
      const std::uint64_t chunk_end = std::min<std::uint64_t>((chunk + 1) * edge_, level.extent.z);
      const std::uint64_t layer = (z - chunk * edge_) / block_.z;
      const std::uint64_t end = std::min(z + block_.z, chunk_end);
      if (!pieces.empty() && end - z0 > depth) break;
      pieces.push_back({chunk, layer, layer + 1, z, end});
      z = end;
    }
    return pieces;
  }

  VolumeInfo info_;
  volumes::BlockSize block_;
  std::uint32_t edge_;
  std::vector<Level> levels_;
  Buffer aligned_;  ///< a copy of the streams where the payload is not aligned to words
};

Expected<void> open_level(Level& level, std::uint32_t edge, const volumes::BlockSize& block,
                          unsigned table_words, std::span<const std::uint64_t> starts,
                          std::span<const std::uint32_t> words) {
  level.chunks.reserve(level.grid.voxels());
  Coordinate chunk;
  std::size_t index = 0;
  for (chunk.z = 0; chunk.z < level.grid.z; ++chunk.z) {
    for (chunk.y = 0; chunk.y < level.grid.y; ++chunk.y) {
      for (chunk.x = 0; chunk.x < level.grid.x; ++chunk.x, ++index) {
        const std::uint64_t begin = starts[index], end = starts[index + 1];
        if (begin > end || end > words.size()) {
          return fail(ErrorCode::kMalformed,
                      fmt::format("chunk table: words {} to {} of {}", begin, end, words.size()));
        }
        auto stream = CompressedSegmentation::open(words.subspan(begin, end - begin),
                                                   chunk_extent(level.extent, edge, chunk), block,
                                                   table_words);
        if (!stream) {
          return fail(stream.error().code, fmt::format("chunk {},{},{}: {}", chunk.x, chunk.y,
                                                       chunk.z, stream.error().message));
        }
        level.chunks.push_back(*stream);
      }
    }
  }
  return {};
}

}  // namespace

Expected<std::unique_ptr<Decoder>> open_decoder(const Stream& stream) {
  const auto levels = static_cast<unsigned>(stream.parameters.integer("levels"));
  const std::uint64_t payload_size = stream.payload.size();
  if (payload_size < PayloadLayout::kHeaderBytes + PayloadLayout::kTableEntryBytes) {
    return fail(ErrorCode::kTruncated,
                fmt::format("expected a header and a chunk table, found {} bytes", payload_size));
  }
  std::uint32_t header[2];
  std::memcpy(header, stream.payload.data(), sizeof header);
  const std::uint32_t edge = header[0];
  const auto given = static_cast<std::uint32_t>(stream.parameters.integer("chunk"));
  if (edge == 0 || edge > kMaxChunk || (given != 0 && edge != given) ||
      !chunk_suits_levels(edge, levels)) {
    return fail(ErrorCode::kMalformed,
                fmt::format("offset 0: {} is no chunk edge of these parameters", edge));
  }
  if (header[1] != levels)
    return fail(ErrorCode::kMalformed,
                fmt::format("offset 4: expected {} levels, found {}", levels, header[1]));

  // Each chunk takes a table entry: too many chunks for the payload are found before anything is
  // allocated for them.
  std::uint64_t entries =
      (payload_size - PayloadLayout::kHeaderBytes) / PayloadLayout::kTableEntryBytes;
  std::uint64_t chunks = 0;
  std::vector<Level> opened(levels);
  for (unsigned k = 0; k < levels; ++k) {
    opened[k].extent = level_extent(stream.info.extent, k);
    opened[k].grid = ceil_div(opened[k].extent, edge);
    const Extent& grid = opened[k].grid;
    if (grid.x >= entries || grid.y >= entries / grid.x ||
        grid.z >= entries / (grid.x * grid.y) + 1 || chunks + grid.voxels() + 1 > entries) {
      return fail(ErrorCode::kTruncated,
                  fmt::format("offset 8: expected a table of {} chunks or more, found {} bytes",
                              to_string(grid), payload_size - PayloadLayout::kHeaderBytes));
    }
    chunks += grid.voxels();
  }
  std::vector<std::uint64_t> starts(chunks + 1);
  const std::uint64_t streams_at =
      PayloadLayout::kHeaderBytes + starts.size() * PayloadLayout::kTableEntryBytes;
  std::memcpy(starts.data(), stream.payload.data() + PayloadLayout::kHeaderBytes,
              streams_at - PayloadLayout::kHeaderBytes);
  const std::uint64_t stream_bytes = payload_size - streams_at;
  if (starts.front() != 0 || stream_bytes % 4 != 0 || starts.back() != stream_bytes / 4) {
    return fail(starts.front() == 0 && starts.back() > stream_bytes / 4 ? ErrorCode::kTruncated
                                                                        : ErrorCode::kMalformed,
                fmt::format("offset 8: the chunk table announces {} words, found {} bytes",
                            starts.back(), stream_bytes));
  }
  Buffer aligned;
  const std::byte* first = stream.payload.data() + streams_at;
  if (reinterpret_cast<std::uintptr_t>(first) % alignof(std::uint32_t) != 0) {
    aligned.append(first, stream_bytes);
    first = aligned.data();
  }
  const std::span words(reinterpret_cast<const std::uint32_t*>(first), stream_bytes / 4);
  const unsigned table_words = stream.info.type == VoxelType::kU64 ? 2 : 1;
  std::span<const std::uint64_t> rest(starts);
  for (Level& level : opened) {
    if (auto ok = open_level(level, edge, block_size(stream.parameters), table_words, rest, words);
        !ok) {
      return tl::unexpected(ok.error());
    }
    rest = rest.subspan(level.grid.voxels());
  }
  return std::make_unique<NeuroglancerDecoder>(stream.info, block_size(stream.parameters), edge,
                                               std::move(opened), std::move(aligned));
}

}  // namespace cvr::codecs::neuroglancer
