// The encoder: cuts each level of the label pyramid into chunks and encodes them side by side.
//
// Chunks finish in any order but are appended in theirs, a batch at a time, so that the bytes do
// not depend on the number of threads and no more than a batch of streams exists twice.
#include "codecs/neuroglancer/neuroglancer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>

#include "codecs/bytes.hpp"
#include "codecs/neuroglancer/format.hpp"
#include "volumes/parallel.hpp"
#include "volumes/pyramid.hpp"

namespace cvr::codecs {

namespace {

using neuroglancer::chunk_extent;
using neuroglancer::PayloadLayout;
using volumes::BlockSize;

/// Chunks that are encoded before their streams are appended.
constexpr std::uint64_t kBatchChunks = 16;

class LevelEncoder {
 public:
  LevelEncoder(const VolumeSource& source, std::uint32_t edge, const BlockSize& block,
               unsigned threads)
      : source_(source),
        extent_(source.info().extent),
        edge_(edge),
        block_(block),
        threads_(threads),
        boxes_(threads) {}

  /// Appends the streams to the payload and their ends (in words) to `ends`.
  Expected<void> encode(Payload& payload, std::vector<std::uint64_t>& ends) {
    const Extent grid = ceil_div(extent_, edge_);
    std::vector<Expected<std::vector<std::uint32_t>>> streams;
    for (std::uint64_t first = 0; first < grid.voxels(); first += kBatchChunks) {
      const std::uint64_t count = std::min(kBatchChunks, grid.voxels() - first);
      streams.assign(count, std::vector<std::uint32_t>());
      const auto position = [&](std::uint64_t i) -> Coordinate { return grid.coordinate(i); };
      volumes::parallel_for(threads_, count, [&](unsigned worker, std::uint64_t i) {
        streams[i] = encode_chunk(position(first + i), boxes_[worker]);
      });
      for (std::uint64_t i = 0; i < count; ++i) {
        if (!streams[i]) return tl::unexpected(streams[i].error());
        const auto sums = volumes::count_words(
            *streams[i], chunk_extent(extent_, edge_, position(first + i)), block_);
        payload.bytes.append(streams[i]->data(), streams[i]->size() * 4);
        payload.breakdown[ByteClass::kHeader] += sums.headers * 4;
        payload.breakdown[ByteClass::kOperations] += sums.values * 4;
        payload.breakdown[ByteClass::kPalette] += sums.tables * 4;
        payload.published_bytes += streams[i]->size() * 4;
        ends.push_back((ends.empty() ? 0 : ends.back()) + streams[i]->size());
        *streams[i] = {};
      }
    }
    return {};
  }

 private:
  Expected<std::vector<std::uint32_t>> encode_chunk(const Coordinate& chunk, Buffer& box) {
    const Coordinate origin{chunk.x * edge_, chunk.y * edge_, chunk.z * edge_};
    const Extent size = chunk_extent(extent_, edge_, chunk);
    return volumes::with_label_type(source_.info().type, [&]<class T>() {
      if (const auto* labels = reinterpret_cast<const T*>(source_.data()); labels != nullptr) {
        const volumes::LabelBox<const T> view{labels + extent_.index(origin), size, extent_.x,
                                              extent_.x * extent_.y};
        return volumes::encode_compressed_segmentation(view, block_);
      }
      box.resize(size.voxels() * sizeof(T));
      {
        const std::scoped_lock lock(reading_);
        source_.read({origin, size}, box.data());
      }
      return volumes::encode_compressed_segmentation(reinterpret_cast<const T*>(box.data()), size,
                                                     block_);
    });
  }

  const VolumeSource& source_;
  Extent extent_;
  std::uint32_t edge_;
  BlockSize block_;
  unsigned threads_;
  std::vector<Buffer> boxes_;  ///< one per worker, for sources that are not in memory
  std::mutex reading_;
};

/// `levels[k]` is the source of level k.
Expected<Payload> encode_levels(std::span<const VolumeSource* const> levels, std::uint32_t edge,
                                const BlockSize& block, unsigned threads) {
  std::uint64_t chunks = 0;
  for (const VolumeSource* level : levels) chunks += ceil_div(level->info().extent, edge).voxels();
  Payload payload{};
  const std::uint64_t streams_at =
      PayloadLayout::kHeaderBytes + (chunks + 1) * PayloadLayout::kTableEntryBytes;
  payload.bytes.resize(streams_at);
  std::vector<std::uint64_t> starts{0};
  starts.reserve(chunks + 1);
  for (const VolumeSource* level : levels) {
    if (auto ok = neuroglancer::append_level(*level, edge, block, threads, payload, starts); !ok)
      return tl::unexpected(ok.error());
  }
  const std::uint32_t header[2] = {edge, narrow<std::uint32_t>(levels.size())};
  static_assert(sizeof header == PayloadLayout::kHeaderBytes);
  std::memcpy(payload.bytes.data(), header, sizeof header);
  std::memcpy(payload.bytes.data() + sizeof header, starts.data(),
              starts.size() * sizeof starts[0]);
  payload.breakdown[ByteClass::kHeader] += sizeof header;
  payload.breakdown[ByteClass::kIndex] += streams_at - sizeof header;
  return payload;
}

class NeuroglancerCodec final : public Codec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits{
        .id = "neuroglancer",
        .version = 1,
        .family = "neuroglancer",
        .summary = "chunks of Neuroglancer's compressed_segmentation",
        .lossless = true,
        .types = volumes::kLabelTypes,
        .access = Granularity::kVoxel,
        .levels_of_detail = true,
        .stored_compressed = true,
        .gpu_decodable = true,
        .front = {{ByteClass::kHeader, PayloadLayout::kHeaderBytes}, {ByteClass::kIndex}}};
    return kTraits;
  }

  std::span<const ParameterSpec> parameters() const override {
    static const std::array kParameters{
        ParameterSpec{.name = "block",
                      .type = ParameterType::kTriple,
                      .default_value = "8,8,8",
                      .minimum = 1,
                      .maximum = volumes::kMaxBlockEdge,
                      .description = "voxels of a block along each axis"},
        ParameterSpec{.name = "chunk",
                      .type = ParameterType::kInteger,
                      .default_value = "0",
                      .minimum = 0,
                      .maximum = neuroglancer::kMaxChunk,
                      .description = "voxels of a chunk along each axis; 0: 512, halved until all "
                                     "table offsets fit 24 bits"},
        ParameterSpec{
            .name = "levels",
            .type = ParameterType::kInteger,
            .default_value = "1",
            .minimum = 1,
            .maximum = neuroglancer::kMaxLevels,
            .description = "levels of the label pyramid, each stored as a scale of its own"}};
    return kParameters;
  }

  Expected<Payload> encode(const VolumeSource& source, const Parameters& parameters,
                           unsigned threads) const override {
    const auto levels = static_cast<unsigned>(parameters.integer("levels"));
    const auto given = static_cast<std::uint32_t>(parameters.integer("chunk"));
    std::uint32_t edge = given != 0 ? given : neuroglancer::kAutomaticChunk;
    if (!neuroglancer::chunk_suits_levels(edge, levels)) {
      return fail(
          ErrorCode::kBadArgument,
          fmt::format("parameter 'chunk': expected a multiple of {} for {} levels, found {}",
                      1u << (levels - 1), levels, edge));
    }
    std::vector<Volume> coarser;
    std::vector<volumes::MemorySource> sources;
    coarser.reserve(levels);
    sources.reserve(levels);
    std::vector<const VolumeSource*> pointers{&source};
    for (unsigned level = 1; level < levels; ++level) {
      coarser.push_back(volumes::coarser_level(*pointers.back(), threads));
      sources.emplace_back(coarser.back());
      pointers.push_back(&sources.back());
    }
    const BlockSize block = neuroglancer::block_size(parameters);
    for (;; edge /= 2) {
      auto payload = encode_levels(pointers, edge, block, std::max(threads, 1u));
      const bool too_large = !payload && payload.error().code == ErrorCode::kTooLarge;
      if (!too_large) return payload;
      const bool can_halve =
          given == 0 && edge > 1 && neuroglancer::chunk_suits_levels(edge / 2, levels);
      if (!can_halve) {
        return fail(ErrorCode::kTooLarge,
                    fmt::format("parameter 'chunk': chunks of {} voxels per axis do not fit: {}",
                                edge, payload.error().message));
      }
    }
  }

  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const override {
    return neuroglancer::open_decoder(stream);
  }
};

}  // namespace

Expected<void> neuroglancer::append_level(const VolumeSource& level, std::uint32_t edge,
                                          const BlockSize& block, unsigned threads,
                                          Payload& payload, std::vector<std::uint64_t>& ends) {
  return LevelEncoder(level, edge, block, threads).encode(payload, ends);
}

const Codec& neuroglancer_codec() {
  static const NeuroglancerCodec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
