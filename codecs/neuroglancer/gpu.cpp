#include "codecs/neuroglancer/gpu.hpp"

#include <fmt/format.h>

#include <bit>

#include "codecs/bytes.hpp"
#include "codecs/label_codes.hpp"
#include "volumes/pyramid.hpp"

namespace cvr::codecs::neuroglancer {

namespace {

/// The two tables through which a voxel finds its stream; shaders/decode/neuroglancer.glsl reads
/// them.
class StreamTables {
 public:
  void begin_level(const Extent& extent, std::uint32_t edge, bool stored) {
    const Extent grid = ceil_div(extent, edge);
    for (const std::uint64_t value : {std::uint64_t{edge}, extent.x, extent.y, grid.x, grid.y,
                                      chunks_, std::uint64_t{stored}}) {
      levels_.put(narrow<std::uint32_t>(value));
    }
  }
  /// The next chunk's first word in the buffer of its level.
  void add_chunk(std::uint64_t start) {
    starts_.put(start);
    ++chunks_;
  }
  Buffer take_levels() { return levels_.take(); }
  Buffer take_starts() { return starts_.take(); }

 private:
  ByteWriter levels_, starts_;
  std::uint64_t chunks_ = 0;
};

/// The words of the given levels, from the first chunk to the end of the last.
std::span<const std::uint32_t> words_of(std::span<const StoredLevel> levels) {
  const std::uint32_t* begin =
      levels.front().chunks.front().channel().data() - 1;  // the leading word
  const auto last = levels.back().chunks.back().channel();
  return {begin, last.data() + last.size()};
}

/// Appends one level with the largest chunks, of `edge` voxels or a fraction, whose table offsets
/// fit.
Expected<void> append_coarser(const Volume& level, std::uint32_t edge,
                              const volumes::BlockSize& block, unsigned threads, Payload& payload,
                              StreamTables& tables) {
  const std::size_t bytes = payload.bytes.size();
  for (;; edge /= 2) {
    std::vector<std::uint64_t> starts{bytes / 4};
    const auto done =
        append_level(volumes::MemorySource(level), edge, block, threads, payload, starts);
    if (done) {
      tables.begin_level(level.extent(), edge, false);
      for (std::size_t i = 0; i + 1 < starts.size(); ++i) tables.add_chunk(starts[i]);
      return {};
    }
    if (done.error().code != ErrorCode::kTooLarge || edge == 1) return done;
    payload.bytes.resize(bytes);
  }
}

/// The labels of level `lod` of the stream.
Expected<Volume> decode_level(const Decoder& decoder, const VolumeInfo& info, unsigned lod,
                              unsigned threads) {
  volumes::VolumeSink sink(level_info(info, lod));
  if (auto ok = decoder.decode(lod, threads, sink); !ok) return tl::unexpected(ok.error());
  return sink.take();
}

/// Encodes the levels [first, end), each from the one before; `finer` is level first - 1.
Expected<Buffer> encode_coarser(Volume finer, unsigned first, unsigned end, std::uint32_t edge,
                                const volumes::BlockSize& block, unsigned threads,
                                StreamTables& tables) {
  Payload payload{};
  for (unsigned lod = first; lod < end; ++lod) {
    finer = volumes::coarser_level(volumes::MemorySource(finer), threads);
    if (auto ok = append_coarser(finer, edge, block, threads, payload, tables); !ok)
      return tl::unexpected(ok.error());
  }
  return std::move(payload.bytes);
}

GpuBuffer owned(std::string use, Buffer bytes) {
  auto buffer = std::make_shared<const Buffer>(std::move(bytes));
  return {std::move(use), buffer->bytes(), buffer};
}

}  // namespace

Expected<GpuEncoding> gpu_encoding(const Decoder& decoder, const VolumeInfo& info,
                                   const volumes::BlockSize& block, std::uint32_t edge,
                                   std::span<const StoredLevel> stored, std::uint32_t brick,
                                   unsigned threads) {
  if (!is_brick_edge(brick)) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("brick edge: expected a power of two, 2..64, found {}", brick));
  }
  threads = std::max(1u, threads);
  GpuEncoding encoding;
  encoding.decoder = "neuroglancer";
  encoding.brick = brick;
  encoding.levels = static_cast<unsigned>(std::countr_zero(brick)) + 1;
  encoding.voxel_access = true;
  encoding.constants = {{"CVR_NEUROGLANCER_BLOCK_X", block.x},
                        {"CVR_NEUROGLANCER_BLOCK_Y", block.y},
                        {"CVR_NEUROGLANCER_BLOCK_Z", block.z},
                        {"CVR_NEUROGLANCER_TABLE_WORDS", info.type == VoxelType::kU64 ? 2u : 1u}};

  stored = stored.first(std::min<std::size_t>(stored.size(), encoding.levels));
  const auto stored_words = words_of(stored);
  StreamTables tables;
  for (const StoredLevel& level : stored) {
    tables.begin_level(level.extent, edge, true);
    for (const auto& chunk : level.chunks)
      tables.add_chunk(
          static_cast<std::uint64_t>(chunk.channel().data() - 1 - stored_words.data()));
  }
  DistinctLabels labels(threads);
  Buffer coarser;
  if (stored.size() == encoding.levels) {
    LabelSink sink(info, labels);
    if (auto ok = decoder.decode(0, threads, sink); !ok) return tl::unexpected(ok.error());
  } else {
    const auto last = static_cast<unsigned>(stored.size() - 1);
    auto finer = decode_level(decoder, info, last, threads);
    if (!finer) return tl::unexpected(finer.error());
    if (last == 0) {
      labels.add(info.type, finer->bytes());
    } else {
      LabelSink sink(info, labels);
      if (auto ok = decoder.decode(0, threads, sink); !ok) return tl::unexpected(ok.error());
    }
    auto encoded =
        encode_coarser(std::move(*finer), last + 1, encoding.levels, edge, block, threads, tables);
    if (!encoded) return tl::unexpected(encoded.error());
    coarser = std::move(*encoded);
  }
  encoding.buffers.push_back(owned("levels", tables.take_levels()));
  encoding.buffers.push_back(owned("starts", tables.take_starts()));
  encoding.buffers.push_back({"streams", std::as_bytes(stored_words), nullptr});
  encoding.buffers.push_back(owned("coarser", std::move(coarser)));
  assign_codes(labels.take(), encoding);
  return encoding;
}

}  // namespace cvr::codecs::neuroglancer
