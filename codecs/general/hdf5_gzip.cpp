// hdf5-gzip: what an HDF5 file with gzip costs. Chunks are compressed side by side with zlib, in
// the way of libhdf5's own filters (shuffle, then deflate), and written into a file image in order.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "codecs/general/general.hpp"
#include "codecs/general/hdf5_image.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs {

namespace {

using general::ChunkedDataset;
using general::ChunkPlace;

/// Chunks that are compressed before they are written.
constexpr std::uint64_t kBatchChunks = 256;
constexpr std::uint64_t kMaxChunkBytes = std::uint64_t{16} << 20;
/// HDF5 stores chunk edges as 32 bits.
constexpr std::int64_t kMaxChunkEdge = 65536;

/// The chunks that h5py chooses for a dataset without a wish; the rule is in FORMAT.md.
Extent automatic_chunk(const VolumeInfo& info) {
  constexpr double kBase = 16 * 1024, kSmallest = 8 * 1024, kLargest = 1024 * 1024;
  std::array<double, 3> edges{static_cast<double>(info.extent.z),
                              static_cast<double>(info.extent.y),
                              static_cast<double>(info.extent.x)};
  const auto size = static_cast<double>(size_of(info.type));
  const auto bytes = [&] { return edges[0] * edges[1] * edges[2] * size; };
  const double target =
      std::clamp(kBase * std::exp2(std::log10(bytes() / (1024.0 * 1024.0))), kSmallest, kLargest);
  for (std::size_t axis = 0;; axis = (axis + 1) % 3) {
    const double now = bytes();
    const bool close = now < target || std::abs(now - target) / target < 0.5;
    if ((close && now < kLargest) || now == size) break;
    edges[axis] = std::ceil(edges[axis] / 2);
  }
  return {static_cast<std::uint64_t>(edges[2]), static_cast<std::uint64_t>(edges[1]),
          static_cast<std::uint64_t>(edges[0])};
}

Expected<ChunkedDataset> dataset_of(const VolumeInfo& info, const Parameters& parameters) {
  const auto wish = parameters.triple("chunk");
  ChunkedDataset dataset{info,
                         {},
                         parameters.integer("shuffle") != 0,
                         static_cast<unsigned>(parameters.integer("level"))};
  if (wish[0] == 0 && wish[1] == 0 && wish[2] == 0) {
    dataset.chunk = automatic_chunk(info);
    return dataset;
  }
  if (wish[0] == 0 || wish[1] == 0 || wish[2] == 0) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("parameter 'chunk': expected 0,0,0 or three edges, found {},{},{}",
                            wish[0], wish[1], wish[2]));
  }
  const Extent& e = info.extent;
  dataset.chunk = {std::min<std::uint64_t>(wish[0], e.x), std::min<std::uint64_t>(wish[1], e.y),
                   std::min<std::uint64_t>(wish[2], e.z)};
  if (dataset.chunk_bytes() > kMaxChunkBytes) {
    return fail(ErrorCode::kTooLarge,
                fmt::format("parameter 'chunk': expected at most {} bytes per chunk, found {}",
                            kMaxChunkBytes, dataset.chunk_bytes()));
  }
  return dataset;
}

/// Byte i of every voxel, then byte i + 1 of every voxel, ...
void shuffle(std::span<const std::byte> in, std::size_t voxel, std::byte* out) {
  const std::size_t count = in.size() / voxel;
  for (std::size_t byte = 0; byte < voxel; ++byte) {
    for (std::size_t i = 0; i < count; ++i) *out++ = in[i * voxel + byte];
  }
}
void unshuffle(std::span<const std::byte> in, std::size_t voxel, std::byte* out) {
  const std::size_t count = in.size() / voxel;
  for (std::size_t byte = 0; byte < voxel; ++byte) {
    for (std::size_t i = 0; i < count; ++i) out[i * voxel + byte] = in[byte * count + i];
  }
}

/// The part of a chunk that lies inside the volume.
Extent valid_part(const ChunkedDataset& dataset, const Coordinate& position) {
  const Extent& e = dataset.info.extent;
  const Extent& c = dataset.chunk;
  return {std::min(c.x, e.x - position.x * c.x), std::min(c.y, e.y - position.y * c.y),
          std::min(c.z, e.z - position.z * c.z)};
}

/// Calls copy(voxels of the slab, voxels of the chunk, bytes) for every row of the chunk; the slab
/// starts at the chunk's first plane.
template <class Copy>
void for_each_row(const ChunkedDataset& dataset, const Coordinate& position, Copy&& copy) {
  const std::uint64_t voxel = size_of(dataset.info.type);
  const Extent part = valid_part(dataset, position);
  const Extent& e = dataset.info.extent;
  const Extent& c = dataset.chunk;
  for (std::uint64_t z = 0; z < part.z; ++z) {
    for (std::uint64_t y = 0; y < part.y; ++y) {
      const Coordinate in_slab{position.x * c.x, position.y * c.y + y, z};
      copy(e.index(in_slab) * voxel, c.index({0, y, z}) * voxel, part.x * voxel);
    }
  }
}

/// One worker's compressor and chunk buffers.
class ChunkCompressor {
 public:
  explicit ChunkCompressor(const ChunkedDataset& dataset)
      : dataset_(dataset),
        chunk_(dataset.chunk_bytes()),
        shuffled_(dataset.shuffle ? dataset.chunk_bytes() : 0) {
    if (deflateInit(&stream_, static_cast<int>(dataset.level)) != Z_OK) throw std::bad_alloc();
    packed_.resize(deflateBound(&stream_, chunk_.size()));
  }
  ~ChunkCompressor() { deflateEnd(&stream_); }
  ChunkCompressor(const ChunkCompressor&) = delete;
  ChunkCompressor& operator=(const ChunkCompressor&) = delete;

  void compress(const std::byte* slab, const Coordinate& position, Buffer& out) {
    // What lies outside the volume has the fill value 0.
    if (valid_part(dataset_, position) != dataset_.chunk)
      std::memset(chunk_.data(), 0, chunk_.size());
    for_each_row(dataset_, position,
                 [&](std::uint64_t from, std::uint64_t to, std::uint64_t bytes) {
                   std::memcpy(chunk_.data() + to, slab + from, bytes);
                 });
    const Buffer* filtered = &chunk_;
    if (dataset_.shuffle) {
      shuffle(chunk_.bytes(), size_of(dataset_.info.type), shuffled_.data());
      filtered = &shuffled_;
    }
    deflateReset(&stream_);
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(filtered->data()));
    stream_.avail_in = static_cast<uInt>(filtered->size());
    stream_.next_out = reinterpret_cast<Bytef*>(packed_.data());
    stream_.avail_out = static_cast<uInt>(packed_.size());
    if (deflate(&stream_, Z_FINISH) != Z_STREAM_END)
      throw std::logic_error("deflateBound was too small");
    out = Buffer();
    out.append(packed_.data(), stream_.total_out);
  }

 private:
  const ChunkedDataset& dataset_;
  z_stream stream_{};
  Buffer chunk_, shuffled_, packed_;
};

class Hdf5GzipDecoder final : public Decoder {
 public:
  Hdf5GzipDecoder(const ChunkedDataset& dataset, std::span<const std::byte> image,
                  std::vector<ChunkPlace> places)
      : dataset_(dataset), image_(image), places_(std::move(places)) {}

  Expected<void> decode(unsigned, unsigned threads, SlabSink& sink) const override {
    const Extent grid = dataset_.grid();
    const std::uint64_t columns = grid.x * grid.y, chunk_z = dataset_.chunk.z;
    const std::uint64_t depth = std::max<std::uint64_t>(1, sink.preferred_depth() / chunk_z);
    std::vector<Scratch> scratch(std::max(threads, 1u));
    for (std::uint64_t first = 0; first < grid.z; first += std::min(depth, grid.z - first)) {
      const std::uint64_t last = first + std::min(depth, grid.z - first);
      const std::uint64_t z0 = first * chunk_z,
                          z1 = std::min(last * chunk_z, dataset_.info.extent.z);
      std::byte* out = sink.begin(z0, z1);
      std::atomic<std::uint64_t> bad{places_.size()};
      volumes::parallel_for(
          threads, (last - first) * columns, [&](unsigned worker, std::uint64_t i) {
            const std::uint64_t index = first * columns + i;
            const Coordinate position{index % grid.x, index / grid.x % grid.y, index / columns};
            const std::uint64_t plane =
                dataset_.info.extent.x * dataset_.info.extent.y * size_of(dataset_.info.type);
            if (decode_chunk(position, places_[index], scratch[worker],
                             out + (position.z * chunk_z - z0) * plane))
              return;
            for (std::uint64_t smallest = bad;
                 index < smallest && !bad.compare_exchange_weak(smallest, index);) {
            }
          });
      if (bad < places_.size()) {
        return fail(ErrorCode::kMalformed,
                    fmt::format("offset {}: expected a chunk of {} bytes in zlib's format",
                                places_[bad].offset, dataset_.chunk_bytes()));
      }
      sink.end(z0, z1);
    }
    return {};
  }

 private:
  struct Scratch {
    Buffer chunk, unshuffled;
  };

  bool decode_chunk(const Coordinate& position, const ChunkPlace& place, Scratch& scratch,
                    std::byte* slab) const {
    scratch.chunk.resize(dataset_.chunk_bytes());
    uLongf produced = scratch.chunk.size();
    uLong consumed = place.size;
    const int result =
        uncompress2(reinterpret_cast<Bytef*>(scratch.chunk.data()), &produced,
                    reinterpret_cast<const Bytef*>(image_.data() + place.offset), &consumed);
    if (result != Z_OK || produced != scratch.chunk.size() || consumed != place.size) return false;
    const Buffer* voxels = &scratch.chunk;
    if (dataset_.shuffle) {
      scratch.unshuffled.resize(scratch.chunk.size());
      unshuffle(scratch.chunk.bytes(), size_of(dataset_.info.type), scratch.unshuffled.data());
      voxels = &scratch.unshuffled;
    }
    for_each_row(dataset_, position,
                 [&](std::uint64_t to, std::uint64_t from, std::uint64_t bytes) {
                   std::memcpy(slab + to, voxels->data() + from, bytes);
                 });
    return true;
  }

  ChunkedDataset dataset_;
  std::span<const std::byte> image_;
  std::vector<ChunkPlace> places_;
};

class Hdf5GzipCodec final : public Codec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits{.id = "hdf5-gzip",
                                .version = 1,
                                .family = "general",
                                .summary = "an HDF5 file image, chunked, gzip",
                                .lossless = true,
                                .types = volumes::kVoxelTypes,
                                .access = Granularity::kBlock,
                                .levels_of_detail = false,
                                .stored_compressed = false};
    return kTraits;
  }

  std::span<const ParameterSpec> parameters() const override {
    static const std::array kParameters{
        ParameterSpec{.name = "level",
                      .type = ParameterType::kInteger,
                      .default_value = "4",
                      .minimum = 0,
                      .maximum = 9,
                      .description = "gzip level"},
        ParameterSpec{.name = "chunk",
                      .type = ParameterType::kTriple,
                      .default_value = "0,0,0",
                      .minimum = 0,
                      .maximum = kMaxChunkEdge,
                      .description = "voxels of a chunk; 0,0,0: as h5py chooses them"},
        ParameterSpec{.name = "shuffle",
                      .type = ParameterType::kInteger,
                      .default_value = "0",
                      .minimum = 0,
                      .maximum = 1,
                      .description = "1: reorder bytes by significance before gzip"}};
    return kParameters;
  }

  Expected<Payload> encode(const VolumeSource& source, const Parameters& parameters,
                           unsigned threads) const override {
    const auto dataset = dataset_of(source.info(), parameters);
    if (!dataset) return tl::unexpected(dataset.error());
    const Extent grid = dataset->grid();
    const std::uint64_t columns = grid.x * grid.y;
    std::vector<std::unique_ptr<ChunkCompressor>> compressors(std::max(threads, 1u));
    for (auto& compressor : compressors) compressor = std::make_unique<ChunkCompressor>(*dataset);
    general::Hdf5ImageWriter writer(*dataset);
    std::vector<Buffer> packed(std::min(kBatchChunks, columns));
    volumes::SlabReader reader(source);
    Payload payload{};
    for (std::uint64_t z = 0; z < grid.z; ++z) {
      const std::byte* slab = reader.read(
          z * dataset->chunk.z, std::min((z + 1) * dataset->chunk.z, source.info().extent.z));
      for (std::uint64_t first = 0; first < columns; first += packed.size()) {
        const std::uint64_t count = std::min<std::uint64_t>(packed.size(), columns - first);
        const auto position = [&](std::uint64_t i) -> Coordinate {
          return {(first + i) % grid.x, (first + i) / grid.x, z};
        };
        volumes::parallel_for(threads, count, [&](unsigned worker, std::uint64_t i) {
          compressors[worker]->compress(slab, position(i), packed[i]);
        });
        for (std::uint64_t i = 0; i < count; ++i) {
          writer.write_chunk(position(i), packed[i].bytes());
          payload.breakdown[ByteClass::kData] += packed[i].size();
        }
      }
    }
    payload.bytes = writer.finish();
    payload.breakdown[ByteClass::kIndex] =
        payload.bytes.size() - payload.breakdown[ByteClass::kData];
    payload.published_bytes = payload.bytes.size();
    return payload;
  }

  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const override {
    const auto dataset = dataset_of(stream.info, stream.parameters);
    if (!dataset) return tl::unexpected(dataset.error());
    auto places = general::locate_chunks(stream.payload, *dataset);
    if (!places) return tl::unexpected(places.error());
    return std::make_unique<Hdf5GzipDecoder>(*dataset, stream.payload, std::move(*places));
  }
};

}  // namespace

const Codec& hdf5_gzip_codec() {
  static const Hdf5GzipCodec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
