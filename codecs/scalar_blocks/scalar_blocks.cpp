#include "codecs/scalar_blocks/scalar_blocks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "codecs/bytes.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::scalar_blocks {

namespace {

constexpr std::uint64_t kHeaderBytes = 32;
constexpr std::uint64_t kSlabBytes = std::uint64_t{4} << 20;

/// Where blocks and runs are.
struct Geometry {
  Geometry(const VolumeInfo& info, const Extent& block)
      : extent(info.extent),
        voxel(size_of(info.type)),
        block(block),
        block_bytes(block.voxels() * voxel) {
    const auto blocks_along = [](std::uint64_t voxels, std::uint64_t edge) {
      return (voxels + edge - 1) / edge;
    };
    blocks = {blocks_along(extent.x, block.x), blocks_along(extent.y, block.y),
              blocks_along(extent.z, block.z)};
    layer_blocks = blocks.x * blocks.y;
    layer_runs = (layer_blocks + kRunBlocks - 1) / kRunBlocks;
  }
  std::uint64_t runs() const { return layer_runs * blocks.z; }
  unsigned run_blocks(std::uint64_t run) const {
    return static_cast<unsigned>(
        std::min<std::uint64_t>(kRunBlocks, layer_blocks - run % layer_runs * kRunBlocks));
  }
  /// The first voxel of block `k` of a run.
  Coordinate origin(std::uint64_t run, unsigned k) const {
    const std::uint64_t in_layer = run % layer_runs * kRunBlocks + k;
    return {in_layer % blocks.x * block.x, in_layer / blocks.x * block.y,
            run / layer_runs * block.z};
  }
  /// The voxels of the block at `at` that lie in the volume.
  Extent inside(const Coordinate& at) const {
    return {std::min(block.x, extent.x - at.x), std::min(block.y, extent.y - at.y),
            std::min(block.z, extent.z - at.z)};
  }

  Extent extent;
  std::uint64_t voxel;
  Extent block;
  std::uint64_t block_bytes;
  Extent blocks;
  std::uint64_t layer_blocks, layer_runs;
};

/// Copies the block at `at` out of a slab that begins at plane z0, repeating last voxels outside
/// the volume.
void gather(const Geometry& g, const std::byte* slab, std::uint64_t z0, const Coordinate& at,
            std::byte* out) {
  const Extent in = g.inside(at);
  for (std::uint64_t z = 0; z < g.block.z; ++z) {
    for (std::uint64_t y = 0; y < g.block.y; ++y) {
      const Coordinate row{at.x, at.y + std::min(y, in.y - 1), at.z + std::min(z, in.z - 1) - z0};
      std::memcpy(out, slab + g.extent.index(row) * g.voxel, in.x * g.voxel);
      for (std::uint64_t x = in.x; x < g.block.x; ++x)
        std::memcpy(out + x * g.voxel, out + (in.x - 1) * g.voxel, g.voxel);
      out += g.block.x * g.voxel;
    }
  }
}

/// Copies what lies in the volume of the block at `at` into a slab that begins at plane z0.
void scatter(const Geometry& g, const std::byte* voxels, const Coordinate& at, std::uint64_t z0,
             std::byte* slab) {
  const Extent in = g.inside(at);
  for (std::uint64_t z = 0; z < in.z; ++z) {
    for (std::uint64_t y = 0; y < in.y; ++y) {
      std::memcpy(slab + g.extent.index({at.x, at.y + y, at.z + z - z0}) * g.voxel,
                  voxels + g.block.index({0, y, z}) * g.voxel, in.x * g.voxel);
    }
  }
}

struct ErrorSum {
  double largest = 0, squares = 0;
};

/// Adds the error of one block over the voxels that lie in the volume.
template <class T>
void add_error(const Geometry& g, const Extent& in, const T* truth, const T* decoded,
               ErrorSum& sum) {
  for (std::uint64_t z = 0; z < in.z; ++z) {
    for (std::uint64_t y = 0; y < in.y; ++y) {
      const std::uint64_t row = g.block.index({0, y, z});
      for (std::uint64_t i = row; i < row + in.x; ++i) {
        const double error =
            std::abs(static_cast<double>(truth[i]) - static_cast<double>(decoded[i]));
        sum.largest = std::max(sum.largest, error);
        sum.squares += error * error;
      }
    }
  }
}

/// What one thread works with.
struct Worker {
  std::unique_ptr<BlockCoder> coder;
  Buffer voxels, decoded;

  void prepare(const BlockFormat& format, const Geometry& g) {
    if (coder) return;
    coder = format.coder();
    voxels.resize(kRunBlocks * g.block_bytes);
    decoded.resize(kRunBlocks * g.block_bytes);
  }
};

struct EncodedRun {
  std::uint64_t words = 0;
  ErrorSum error;
  std::optional<Error> failure;
};

EncodedRun encode_run(const Geometry& g, VoxelType type, Worker& worker, const std::byte* slab,
                      std::uint64_t z0, std::uint64_t run, std::uint64_t* words) {
  const unsigned count = g.run_blocks(run);
  for (unsigned k = 0; k < count; ++k)
    gather(g, slab, z0, g.origin(run, k), worker.voxels.data() + k * g.block_bytes);
  EncodedRun result;
  const auto used = worker.coder->encode(worker.voxels.data(), count, words);
  if (!used) {
    result.failure = used.error();
    return result;
  }
  result.words = *used;
  const auto decoded =
      worker.coder->decode(std::as_bytes(std::span(words, *used)), 0, count, worker.decoded.data());
  if (!decoded) {
    result.failure = decoded.error();
    return result;
  }
  volumes::with_voxel_type(type, [&]<class T>() {
    for (unsigned k = 0; k < count; ++k) {
      add_error(g, g.inside(g.origin(run, k)),
                reinterpret_cast<const T*>(worker.voxels.data() + k * g.block_bytes),
                reinterpret_cast<const T*>(worker.decoded.data() + k * g.block_bytes),
                result.error);
    }
  });
  return result;
}

class BlocksDecoder final : public Decoder, public VoxelAccess {
 public:
  BlocksDecoder(const Stream& stream, std::unique_ptr<const BlockFormat> format,
                const RecordedError& error)
      : info_(stream.info),
        payload_(stream.payload),
        format_(std::move(format)),
        geometry_(info_, format_->block()),
        error_(error) {}

  Expected<void> decode(unsigned, unsigned threads, SlabSink& sink) const override {
    const Geometry& g = geometry_;
    const std::uint64_t layers = std::max<std::uint64_t>(1, sink.preferred_depth() / g.block.z);
    std::vector<Worker> workers(std::max(threads, 1u));
    for (std::uint64_t layer = 0; layer < g.blocks.z;
         layer += std::min(layers, g.blocks.z - layer)) {
      const std::uint64_t end = layer + std::min(layers, g.blocks.z - layer);
      const std::uint64_t z0 = layer * g.block.z, z1 = std::min(end * g.block.z, g.extent.z);
      std::byte* out = sink.begin(z0, z1);
      const std::uint64_t first = layer * g.layer_runs;
      std::vector<std::optional<Error>> failures(workers.size());
      volumes::parallel_for(
          threads, (end - layer) * g.layer_runs, [&](unsigned w, std::uint64_t i) {
            const std::uint64_t run = first + i;
            const unsigned count = g.run_blocks(run);
            workers[w].prepare(*format_, g);
            const auto done =
                workers[w].coder->decode(words_of(run), 0, count, workers[w].voxels.data());
            if (!done) {
              failures[w] = done.error();
              return;
            }
            for (unsigned k = 0; k < count; ++k)
              scatter(g, workers[w].voxels.data() + k * g.block_bytes, g.origin(run, k), z0, out);
          });
      for (const auto& failure : failures) {
        if (failure) return tl::unexpected(*failure);
      }
      sink.end(z0, z1);
    }
    return {};
  }

  const VoxelAccess* voxel_access() const override { return this; }
  std::optional<RecordedError> recorded_error() const override { return error_; }

  /// Points in the block of the point before them do not decode it again.
  Expected<void> at(std::span<const Coordinate> points, unsigned lod,
                    std::span<std::uint64_t> scalars) const override {
    if (lod != 0)
      return fail(ErrorCode::kBadArgument,
                  fmt::format("level of detail: expected 0, the only one, found {}", lod));
    const Geometry& g = geometry_;
    const auto coder = format_->coder();
    const bool single = coder->has_voxels();
    Buffer voxels(single ? 0 : g.block_bytes);
    std::uint64_t held_run = ~std::uint64_t{0};
    unsigned held_block = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Coordinate& p = points[i];
      const std::uint64_t in_layer = p.x / g.block.x + g.blocks.x * (p.y / g.block.y);
      const std::uint64_t run = p.z / g.block.z * g.layer_runs + in_layer / kRunBlocks;
      const auto block = static_cast<unsigned>(in_layer % kRunBlocks);
      const auto index =
          static_cast<unsigned>(g.block.index({p.x % g.block.x, p.y % g.block.y, p.z % g.block.z}));
      if (single) {
        scalars[i] = coder->voxel(words_of(run), block, index);
        continue;
      }
      if (run != held_run || block != held_block) {
        if (auto done = coder->decode(words_of(run), block, 1, voxels.data()); !done) return done;
        held_run = run;
        held_block = block;
      }
      scalars[i] = 0;
      std::memcpy(&scalars[i], voxels.data() + index * g.voxel, g.voxel);
    }
    return {};
  }

  /// Where runs begin, from the table or by the fixed size of blocks; checks everything that
  /// words_of() relies on.
  Expected<void> check_sizes() {
    const Geometry& g = geometry_;
    const std::uint64_t table = format_->fixed_size() ? 0 : 8 * (g.runs() + 1);
    const std::uint64_t size = payload_.size() - kHeaderBytes;
    if (size < table)
      return fail(ErrorCode::kTruncated,
                  fmt::format("expected a table of {} runs, found {} bytes", g.runs(), size));
    runs_at_ = kHeaderBytes + table;
    const std::uint64_t words = (payload_.size() - runs_at_) / 8;
    layer_words_ = format_->max_words(g.layer_blocks);
    if (format_->fixed_size()) {
      if (size == 8 * layer_words_ * g.blocks.z) return {};
      return fail(ErrorCode::kTruncated, fmt::format("expected {} bytes of blocks, found {}",
                                                     8 * layer_words_ * g.blocks.z, size));
    }
    for (std::uint64_t run = 0; run < g.runs(); ++run) {
      const std::uint64_t begin = run_start(run), end = run_start(run + 1);
      if (begin > end || end > words || end - begin > format_->max_words(g.run_blocks(run)))
        return fail(ErrorCode::kMalformed,
                    fmt::format("offset {}: expected the end of run {}, found word {}",
                                kHeaderBytes + 8 * (run + 1), run, end));
    }
    if (run_start(0) != 0 || 8 * run_start(g.runs()) != payload_.size() - runs_at_)
      return fail(
          ErrorCode::kMalformed,
          fmt::format(
              "offset {}: expected runs of {} words from the first to the last, found {} to {}",
              kHeaderBytes, words, run_start(0), run_start(g.runs())));
    return {};
  }

 private:
  std::uint64_t run_start(std::uint64_t run) const {
    std::uint64_t start;
    std::memcpy(&start, payload_.data() + kHeaderBytes + 8 * run, sizeof start);
    return start;
  }

  std::span<const std::byte> words_of(std::uint64_t run) const {
    const Geometry& g = geometry_;
    if (!format_->fixed_size()) {
      return payload_.subspan(runs_at_ + 8 * run_start(run),
                              8 * (run_start(run + 1) - run_start(run)));
    }
    const std::uint64_t at =
        run / g.layer_runs * layer_words_ + run % g.layer_runs * format_->bits();
    return payload_.subspan(runs_at_ + 8 * at, 8 * format_->max_words(g.run_blocks(run)));
  }

  VolumeInfo info_;
  std::span<const std::byte> payload_;
  std::unique_ptr<const BlockFormat> format_;
  Geometry geometry_;
  RecordedError error_;
  std::uint64_t runs_at_ = 0, layer_words_ = 0;
};

bool is_range_of(VoxelType type, const ScalarRange& range) {
  return volumes::with_voxel_type(type, [&]<class T>() {
    using Limits = std::numeric_limits<T>;
    return range.minimum >= static_cast<double>(Limits::lowest()) &&
           range.maximum <= static_cast<double>(Limits::max()) && range.minimum <= range.maximum;
  });
}

}  // namespace

Expected<Payload> ScalarBlocksCodec::encode(const VolumeSource& source,
                                            const Parameters& parameters, unsigned threads) const {
  const VolumeInfo& info = source.info();
  const auto range = finite_range(source, threads);
  if (!range) return tl::unexpected(range.error());
  const auto block_format = format(info.type, parameters, *range);
  const Geometry g(info, block_format->block());

  Payload payload{};
  const std::uint64_t table = block_format->fixed_size() ? 0 : 8 * (g.runs() + 1);
  payload.bytes.resize(kHeaderBytes + table);
  if (block_format->fixed_size())
    payload.bytes.reserve(kHeaderBytes + 8 * block_format->max_words(g.layer_blocks) * g.blocks.z);

  const std::uint64_t layer_bytes = g.extent.x * g.extent.y * g.block.z * g.voxel;
  const std::uint64_t layers = std::max<std::uint64_t>(1, kSlabBytes / layer_bytes);
  const std::uint64_t run_words = block_format->max_words(kRunBlocks);
  volumes::SlabReader reader(source);
  std::vector<Worker> workers(std::max(threads, 1u));
  ErrorSum error;
  std::uint64_t words_before = 0;
  for (std::uint64_t layer = 0; layer < g.blocks.z; layer += layers) {
    const std::uint64_t end = std::min(layer + layers, g.blocks.z);
    const std::uint64_t z0 = layer * g.block.z, first = layer * g.layer_runs;
    const std::byte* slab = reader.read(z0, std::min(end * g.block.z, g.extent.z));
    const std::uint64_t runs = (end - layer) * g.layer_runs;
    std::vector<std::uint64_t> words(runs * run_words);
    std::vector<EncodedRun> encoded(runs);
    volumes::parallel_for(threads, runs, [&](unsigned w, std::uint64_t i) {
      workers[w].prepare(*block_format, g);
      encoded[i] =
          encode_run(g, info.type, workers[w], slab, z0, first + i, words.data() + i * run_words);
    });
    for (std::uint64_t i = 0; i < runs; ++i) {
      if (encoded[i].failure) return tl::unexpected(*encoded[i].failure);
      if (table != 0)
        std::memcpy(payload.bytes.data() + kHeaderBytes + 8 * (first + i), &words_before,
                    sizeof words_before);
      payload.bytes.append(words.data() + i * run_words, 8 * encoded[i].words);
      words_before += encoded[i].words;
      error.largest = std::max(error.largest, encoded[i].error.largest);
      error.squares += encoded[i].error.squares;
    }
  }
  if (table != 0)
    std::memcpy(payload.bytes.data() + kHeaderBytes + table - 8, &words_before,
                sizeof words_before);
  const std::array header{error.largest, error.squares / static_cast<double>(g.extent.voxels()),
                          range->minimum, range->maximum};
  static_assert(sizeof header == kHeaderBytes);
  std::memcpy(payload.bytes.data(), header.data(), sizeof header);
  payload.breakdown[ByteClass::kHeader] = kHeaderBytes;
  payload.breakdown[ByteClass::kIndex] = table;
  payload.breakdown[ByteClass::kData] = 8 * words_before;
  payload.published_bytes = payload.bytes.size();
  return payload;
}

Expected<std::unique_ptr<Decoder>> ScalarBlocksCodec::open(const Stream& stream) const {
  ByteReader in(stream.payload);
  const RecordedError error{in.get<double>(), in.get<double>()};
  const ScalarRange range{in.get<double>(), in.get<double>()};
  if (in.failed())
    return fail(ErrorCode::kTruncated, fmt::format("expected a header of {} bytes, found {}",
                                                   kHeaderBytes, stream.payload.size()));
  if (!(std::isfinite(error.largest) && error.largest >= 0 && std::isfinite(error.mean_squared) &&
        error.mean_squared >= 0))
    return fail(ErrorCode::kMalformed, "offset 0: expected errors of 0 or more");
  if (!is_range_of(stream.info.type, range))
    return fail(ErrorCode::kMalformed,
                fmt::format("offset 16: expected a range of {}, found {} to {}",
                            name_of(stream.info.type), range.minimum, range.maximum));
  auto decoder = std::make_unique<BlocksDecoder>(
      stream, format(stream.info.type, stream.parameters, range), error);
  if (auto checked = decoder->check_sizes(); !checked) return tl::unexpected(checked.error());
  return decoder;
}

}  // namespace cvr::codecs::scalar_blocks
