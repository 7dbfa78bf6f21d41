// The encoding half of the brick frame: slabs of brick layers are drawn from the source, their
// bricks encoded in parallel into the workers' own memory and appended in brick order, so that the
// bytes do not depend on the number of threads.
#include <algorithm>
#include <mutex>

#include "codecs/csgv/brick_codec.hpp"
#include "codecs/csgv/label_remap.hpp"
#include "codecs/label_codes.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::csgv {

namespace {

using volumes::parallel_for;
using volumes::SlabReader;

constexpr std::size_t kGroupsAtOnce = 256;  ///< of kept ones, written before they are appended

struct Worker {
  Worker(std::uint32_t b, std::unique_ptr<PackWorkspace> workspace)
      : grid(b), operations(b), pack(std::move(workspace)) {}
  LabelGrid grid;
  OperationStream operations;
  std::unique_ptr<PackWorkspace> pack;
  std::size_t finished = 0;          ///< groups, by this worker
  std::vector<std::uint32_t> words;  ///< groups of the current slab
  ByteBreakdown bytes;
};

class BrickEncoder {
 public:
  BrickEncoder(const VolumeSource& source, std::uint32_t brick, BrickFormat& format,
               unsigned threads)
      : source_(source),
        reader_(source),
        remap_(source, threads),
        format_(format),
        threads_(std::max(1u, threads)),
        layout_(source.info().extent, brick, format.group()) {
    for (unsigned i = 0; i < threads_; ++i)
      workers_.push_back(std::make_unique<Worker>(brick, format.pack_workspace()));
  }

  void number_labels();
  void sample();
  void keep();
  Expected<Payload> run();

 private:
  template <class T, class Body>
  void with_brick(const T* slab, std::uint64_t first_layer, const Coordinate& at, Worker& worker,
                  Body&& body);
  template <class Body>
  void for_each_slab(unsigned stride, Body&& body);
  template <class T>
  void pack_group(const T* slab, std::uint64_t layer, std::uint64_t i, Worker& worker);
  template <class Body>
  void for_each_piece(Body&& append);
  unsigned sampling_stride() const;
  void write_front(ByteWriter& out, ByteBreakdown& bytes) const;

  const VolumeSource& source_;
  SlabReader reader_;
  LabelRemap remap_;
  BrickFormat& format_;
  unsigned threads_;
  BrickLayout layout_;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::vector<std::uint32_t> narrowed_;
  /// Which worker keeps a group, and as which of its groups.
  struct Kept {
    unsigned worker;
    std::size_t n;
  };
  std::vector<Kept> kept_;  ///< groups in their order
};

/// Finds the operations of the brick `at`, of a slab that begins with that layer, and calls
/// body(brick).
template <class T, class Body>
void BrickEncoder::with_brick(const T* slab, std::uint64_t first_layer, const Coordinate& at,
                              Worker& worker, Body&& body) {
  const Extent& e = layout_.extent;
  const std::uint64_t b = layout_.brick;
  const OperationOptions options = format_.options();
  const Validity validity(layout_.brick, layout_.brick_extent(at));
  worker.grid.build(slab + (at.x * b + e.x * (at.y * b + e.y * (at.z - first_layer) * b)), e.x,
                    e.x * e.y, validity);
  if (options.keep_outside) worker.grid.fill_outside(validity);
  if (format_.wants_operations()) worker.operations.encode(worker.grid, validity, options);
  body(SourceBrick{worker.grid, validity, worker.operations});
}

/// Draws slabs of brick layers; body(call with a body for each brick, first layer, layers).
template <class Body>
void BrickEncoder::for_each_slab(unsigned stride, Body&& body) {
  const Extent& e = layout_.extent;
  const std::uint64_t layers_a_slab =
      stride > 1 ? stride : std::max<std::uint64_t>(kSlabDepth / layout_.brick, layout_.group);
  for (std::uint64_t layer = 0; layer < layout_.grid.z; layer += layers_a_slab) {
    // With a stride only the first layer of a slab is asked for.
    const std::uint64_t layers = stride > 1 ? 1 : std::min(layers_a_slab, layout_.grid.z - layer);
    const std::uint64_t z0 = layer * layout_.brick;
    const std::uint64_t z1 = std::min(z0 + layers * layout_.brick, e.z);
    const std::byte* slab = reader_.read(z0, z1);
    const std::uint64_t voxels = e.x * e.y * (z1 - z0);
    switch (source_.info().type) {
      case VoxelType::kU8:
        body(reinterpret_cast<const std::uint8_t*>(slab), layer, layers);
        break;
      case VoxelType::kU16:
        body(reinterpret_cast<const std::uint16_t*>(slab), layer, layers);
        break;
      case VoxelType::kU64:
        narrowed_.resize(voxels);
        remap_.apply({reinterpret_cast<const std::uint64_t*>(slab), voxels}, narrowed_.data());
        body(static_cast<const std::uint32_t*>(narrowed_.data()), layer, layers);
        break;
      default:
        body(reinterpret_cast<const std::uint32_t*>(slab), layer, layers);
        break;
    }
  }
}

/// The format's stride, halved until enough bricks are seen, doubled until they are not too many.
unsigned BrickEncoder::sampling_stride() const {
  const Sampling sampling = format_.sampling();
  unsigned stride = sampling.stride;
  const auto seen = [&] { return volumes::ceil_div(layout_.grid, stride).voxels(); };
  while (stride > 1 && seen() < sampling.few) stride /= 2;
  while (seen() > sampling.most) stride *= 2;
  return stride;
}

/// Tells the format all labels that are stored.
void BrickEncoder::number_labels() {
  if (!format_.wants_labels()) return;
  std::vector<std::uint32_t> stored;
  if (const std::size_t remapped = remap_.labels().size(); remapped > 0) {
    for (std::uint32_t i = 0; i < remapped; ++i) stored.push_back(i);
  } else {
    const Extent& e = layout_.extent;
    DistinctLabels distinct(threads_);
    for (std::uint64_t z = 0; z < e.z; z += kSlabDepth) {
      const std::uint64_t depth = std::min(kSlabDepth, e.z - z);
      const std::uint64_t bytes = e.x * e.y * depth * size_of(source_.info().type);
      distinct.add(source_.info().type, {reader_.read(z, z + depth), bytes});
    }
    const std::vector<std::uint64_t> labels = distinct.take();
    stored.assign(labels.begin(), labels.end());
  }
  format_.set_labels(std::move(stored));
}

void BrickEncoder::sample() {
  std::vector<std::unique_ptr<BrickStatistics>> statistics;
  for (unsigned i = 0; i < threads_; ++i) statistics.push_back(format_.statistics());
  if (statistics[0] == nullptr) return;
  const unsigned stride = sampling_stride();
  for_each_slab(stride, [&](const auto* slab, std::uint64_t layer, std::uint64_t layers) {
    const Extent sampled = volumes::ceil_div({layout_.grid.x, layout_.grid.y, layers}, stride);
    parallel_for(threads_, sampled.voxels(), [&](unsigned w, std::uint64_t i) {
      const Coordinate at{i % sampled.x * stride, i / sampled.x % sampled.y * stride,
                          layer + i / (sampled.x * sampled.y) * stride};
      with_brick(slab, layer, at, *workers_[w],
                 [&](const SourceBrick& brick) { statistics[w]->add(brick); });
    });
  });
  for (unsigned i = 1; i < threads_; ++i) statistics[0]->merge(*statistics[i]);
  format_.fit(*statistics[0]);
}

void BrickEncoder::write_front(ByteWriter& out, ByteBreakdown& bytes) const {
  out.put(static_cast<std::uint64_t>(remap_.labels().size()));
  out.append(std::as_bytes(std::span(remap_.labels())));
  ByteWriter tables;
  format_.write_tables(tables);
  const Buffer table_bytes = tables.take();
  out.put(narrow<std::uint32_t>(table_bytes.size()));
  out.put(std::uint32_t{0});
  out.append(table_bytes.bytes());
  bytes[ByteClass::kTables] = out.size() - 16;
  bytes[ByteClass::kHeader] = 16;
  out.align(4);
  bytes[ByteClass::kPadding] = out.size() - 16 - bytes[ByteClass::kTables];
}

/// Packs the i-th group of a slab of whole groups that begins with a layer of bricks.
template <class T>
void BrickEncoder::pack_group(const T* slab, std::uint64_t layer, std::uint64_t i, Worker& worker) {
  const Extent& groups = layout_.groups;
  const Coordinate group{i % groups.x, i / groups.x % groups.y,
                         layer / layout_.group + i / (groups.x * groups.y)};
  const Extent bricks = layout_.bricks_of_group(group);
  for (std::uint64_t k = 0; k < bricks.voxels(); ++k) {
    const Coordinate brick{group.x * layout_.group + k % bricks.x,
                           group.y * layout_.group + k / bricks.x % bricks.y,
                           group.z * layout_.group + k / (bricks.x * bricks.y)};
    with_brick(slab, layer, brick, worker, [&](const SourceBrick& found) {
      format_.pack(found, *worker.pack, worker.words, worker.bytes);
    });
  }
  format_.finish_group(*worker.pack, worker.words, worker.bytes);
  ++worker.finished;
}

/// Shows all bricks to a format that keeps them.
void BrickEncoder::keep() {
  if (!format_.keeps_bricks()) return;
  for_each_slab(1, [&](const auto* slab, std::uint64_t layer, std::uint64_t layers) {
    const std::size_t first = kept_.size();
    kept_.resize(first + layout_.groups.x * layout_.groups.y *
                             ((layers + layout_.group - 1) / layout_.group));
    parallel_for(threads_, kept_.size() - first, [&](unsigned w, std::uint64_t i) {
      kept_[first + i] = {w, workers_[w]->finished};
      pack_group(slab, layer, i, *workers_[w]);
    });
  });
  std::vector<PackWorkspace*> workspaces;
  for (const auto& worker : workers_) workspaces.push_back(worker->pack.get());
  format_.fit_kept(workspaces);
}

/// Calls append(words) for each group in its order: of a slab after the other, or of what has been
/// kept.
template <class Body>
void BrickEncoder::for_each_piece(Body&& append) {
  struct Piece {
    unsigned worker;
    std::size_t at, words;
  };
  std::vector<Piece> pieces;
  const auto write = [&](std::size_t count, auto&& write_piece) {
    for (const auto& worker : workers_) worker->words.clear();
    pieces.resize(count);
    parallel_for(threads_, count, [&](unsigned w, std::uint64_t i) {
      const std::size_t at = workers_[w]->words.size();
      write_piece(w, i);
      pieces[i] = {w, at, workers_[w]->words.size() - at};
    });
    for (const Piece& piece : pieces)
      append(std::span<const std::uint32_t>(workers_[piece.worker]->words)
                 .subspan(piece.at, piece.words));
  };
  if (!format_.keeps_bricks()) {
    for_each_slab(1, [&](const auto* slab, std::uint64_t layer, std::uint64_t layers) {
      write(layout_.groups.x * layout_.groups.y * ((layers + layout_.group - 1) / layout_.group),
            [&](unsigned w, std::uint64_t i) { pack_group(slab, layer, i, *workers_[w]); });
    });
    return;
  }
  std::vector<std::unique_ptr<PackWorkspace>> scratch;
  for (unsigned w = 0; w < threads_; ++w) scratch.push_back(format_.write_workspace());
  for (std::size_t first = 0; first < kept_.size(); first += kGroupsAtOnce) {
    write(std::min(kGroupsAtOnce, kept_.size() - first), [&](unsigned w, std::uint64_t i) {
      const Kept& kept = kept_[first + i];
      format_.write_kept(*workers_[kept.worker]->pack, kept.n, *scratch[w], workers_[w]->words,
                         workers_[w]->bytes);
    });
  }
}

Expected<Payload> BrickEncoder::run() {
  const std::uint64_t groups = layout_.groups.voxels();
  ByteBreakdown bytes;
  ByteWriter front;
  write_front(front, bytes);
  Payload payload{front.take(), {}, 0};
  const std::uint64_t table_at = payload.bytes.size();
  payload.bytes.resize(table_at + (groups + 1) * sizeof(std::uint32_t));
  bytes[ByteClass::kIndex] = (groups + 1) * sizeof(std::uint32_t);

  std::uint64_t next = 0;  // in the start table
  std::uint64_t words = 0;
  const auto set_start = [&](std::uint64_t i, std::uint64_t start) {
    const auto stored = static_cast<std::uint32_t>(start);
    std::memcpy(payload.bytes.data() + table_at + i * sizeof stored, &stored, sizeof stored);
  };
  for_each_piece([&](std::span<const std::uint32_t> piece) {
    set_start(next++, words);
    payload.bytes.append(piece.data(), piece.size_bytes());
    words += piece.size();
  });
  set_start(groups, words);
  if (words > ~std::uint32_t{0}) {
    return fail(ErrorCode::kTooLarge,
                "the encoded bricks exceed 2^32 words, the range of the start table");
  }
  for (const auto& worker : workers_) bytes += worker->bytes;
  payload.breakdown = bytes;
  payload.published_bytes = payload.bytes.size() - table_at;
  return payload;
}

/// 8 a word, first in the low nibble.
void append_nibbles(std::span<const std::uint8_t> symbols, std::vector<std::uint32_t>& words) {
  const std::size_t at = words.size();
  words.resize(at + (symbols.size() + 7) / 8);
  const auto pack8 = [](std::uint64_t bytes) {
    bytes = (bytes | bytes >> 4) & 0x00ff00ff00ff00ffu;
    bytes = (bytes | bytes >> 8) & 0x0000ffff0000ffffu;
    return static_cast<std::uint32_t>(bytes | bytes >> 16);
  };
  std::size_t i = 0;
  for (; i + 8 <= symbols.size(); i += 8) {
    std::uint64_t bytes;
    std::memcpy(&bytes, symbols.data() + i, sizeof bytes);
    words[at + i / 8] = pack8(bytes);
  }
  if (i < symbols.size()) {
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, symbols.data() + i, symbols.size() - i);
    words[at + i / 8] = pack8(bytes);
  }
}

}  // namespace

BrickLayout::BrickLayout(const Extent& volume, std::uint32_t brick_edge, std::uint32_t group_edge)
    : brick(brick_edge),
      group(group_edge),
      levels(levels_of_brick(brick_edge)),
      extent(volume),
      grid(volumes::ceil_div(volume, brick_edge)),
      groups(volumes::ceil_div(grid, group_edge)) {}

Extent BrickLayout::bricks_of_group(const Coordinate& g) const {
  const auto cut = [this](std::uint64_t at, std::uint64_t size) {
    return std::min<std::uint64_t>(group, size - at * group);
  };
  return {cut(g.x, grid.x), cut(g.y, grid.y), cut(g.z, grid.z)};
}

std::uint32_t BrickLayout::member(const Coordinate& c) const {
  const Extent bricks = bricks_of_group(group_at(c));
  return static_cast<std::uint32_t>(c.x % group +
                                    bricks.x * (c.y % group + bricks.y * (c.z % group)));
}

StoredBrick BrickLayout::stored(const Coordinate& c) const {
  const Coordinate g = group_at(c);
  return {group_words(group_index(g)), member(c),
          static_cast<std::uint32_t>(bricks_of_group(g).voxels())};
}

BrickExtent BrickLayout::brick_extent(const Coordinate& c) const {
  const auto cut = [this](std::uint64_t at, std::uint64_t size) {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(brick, size - at * brick));
  };
  return {cut(c.x, extent.x), cut(c.y, extent.y), cut(c.z, extent.z)};
}

void append_nibble_brick(const OperationStream& operations, std::vector<std::uint32_t>& words,
                         ByteBreakdown& bytes) {
  append_level_starts(operations, words);
  const std::size_t operations_at = words.size();
  append_nibbles(operations.symbols(), words);
  bytes[ByteClass::kHeader] += 4 * (operations.levels() + 1);
  bytes[ByteClass::kOperations] += 4 * (words.size() - operations_at);
  append_palette(operations, words);
  bytes[ByteClass::kPalette] += 4 * operations.palette().size();
}

Expected<Payload> BrickCodec::encode(const VolumeSource& source, const Parameters& parameters,
                                     unsigned threads) const {
  const auto format = make_format_(parameters);
  BrickEncoder encoder(source, static_cast<std::uint32_t>(parameters.integer("brick")), *format,
                       threads);
  encoder.number_labels();
  encoder.sample();
  encoder.keep();
  return encoder.run();
}

}  // namespace cvr::codecs::csgv
