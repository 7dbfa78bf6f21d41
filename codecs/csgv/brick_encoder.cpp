// The encoding half of the brick frame: slabs of brick layers are drawn from the source, their bricks encoded in parallel into
// the workers' own memory and appended in brick order, so that the bytes do not depend on the number of threads.
#include <algorithm>
#include <mutex>
#include <unordered_map>

#include "codecs/csgv/brick_codec.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::csgv {

namespace {

using volumes::parallel_for;
using volumes::SlabReader;

constexpr std::uint64_t kSlabDepth = 64;
constexpr std::uint64_t kFewBricks = 64;  ///< a pre-pass over fewer would not see enough symbols

/// Replaces labels above 32 bits by their rank among all labels.
class LabelRemap {
 public:
  /// Reads the whole volume once, and a second time if a label needs more than 32 bits.
  explicit LabelRemap(const VolumeSource& source) {
    if (source.info().type != VoxelType::kU64) return;
    std::uint64_t all_bits = 0;
    for_each_slab(source, [&](std::span<const std::uint64_t> voxels) {
      for (const std::uint64_t label : voxels) all_bits |= label;
    });
    if (all_bits >> 32 == 0) return;
    for_each_slab(source, [&](std::span<const std::uint64_t> voxels) {
      std::uint64_t last = ~voxels[0];
      for (const std::uint64_t label : voxels) {
        if (label == last) continue;
        index_.try_emplace(label, 0);
        last = label;
      }
    });
    labels_.reserve(index_.size());
    for (const auto& [label, index] : index_) labels_.push_back(label);
    std::ranges::sort(labels_);
    std::uint32_t next = 0;
    for (const std::uint64_t label : labels_) index_[label] = next++;
  }

  const std::vector<std::uint64_t>& labels() const { return labels_; }

  /// Narrows labels to the stored 32 bits.
  void apply(std::span<const std::uint64_t> voxels, std::uint32_t* out) const {
    if (labels_.empty()) {
      std::ranges::transform(voxels, out, [](std::uint64_t label) { return static_cast<std::uint32_t>(label); });
      return;
    }
    std::uint64_t last = voxels[0];
    std::uint32_t index = index_.at(last);
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      if (voxels[i] != last) {
        last = voxels[i];
        index = index_.at(last);
      }
      out[i] = index;
    }
  }

 private:
  template <class Body>
  static void for_each_slab(const VolumeSource& source, Body&& body) {
    SlabReader reader(source);
    const Extent& e = source.info().extent;
    for (std::uint64_t z = 0; z < e.z; z += kSlabDepth) {
      const std::uint64_t depth = std::min(kSlabDepth, e.z - z);
      body(std::span(reinterpret_cast<const std::uint64_t*>(reader.read(z, z + depth)), e.x * e.y * depth));
    }
  }

  std::unordered_map<std::uint64_t, std::uint32_t> index_;
  std::vector<std::uint64_t> labels_;
};

struct Worker {
  Worker(std::uint32_t b) : grid(b), operations(b) {}
  LabelGrid grid;
  OperationStream operations;
  PackWorkspace pack;
  std::vector<std::uint32_t> words;  ///< bricks of the current slab
  ByteBreakdown bytes;
};

class BrickEncoder {
 public:
  BrickEncoder(const VolumeSource& source, std::uint32_t brick, BrickFormat& format, unsigned threads)
      : source_(source), reader_(source), remap_(source), format_(format), threads_(std::max(1u, threads)), brick_(brick) {
    layout_.brick = brick;
    layout_.levels = levels_of_brick(brick);
    layout_.extent = source.info().extent;
    layout_.grid = volumes::ceil_div(layout_.extent, brick);
    for (unsigned i = 0; i < threads_; ++i) workers_.push_back(std::make_unique<Worker>(brick));
  }

  void sample();
  Expected<Payload> run();

 private:
  template <class T, class Body>
  void for_each_brick(const T* slab, std::uint64_t first_layer, std::uint64_t layers, unsigned stride, Body&& body);
  template <class Body>
  void for_each_slab(unsigned stride, Body&& body);
  unsigned sampling_stride() const;
  void write_front(ByteWriter& out, ByteBreakdown& bytes) const;

  const VolumeSource& source_;
  SlabReader reader_;
  LabelRemap remap_;
  BrickFormat& format_;
  unsigned threads_;
  std::uint32_t brick_;
  BrickLayout layout_{};
  std::vector<std::unique_ptr<Worker>> workers_;
  std::vector<std::uint32_t> narrowed_;
};

/// Encodes the operations of every `stride`-th brick of the layers into its worker, then calls body(worker, brick in slab).
template <class T, class Body>
void BrickEncoder::for_each_brick(const T* slab, std::uint64_t first_layer, std::uint64_t layers, unsigned stride, Body&& body) {
  const Extent& e = layout_.extent;
  const Extent& g = layout_.grid;
  const Extent sampled = volumes::ceil_div({g.x, g.y, layers}, stride);
  const OperationOptions options = format_.options();
  parallel_for(threads_, sampled.voxels(), [&](unsigned w, std::uint64_t i) {
    const Coordinate in_slab{i % sampled.x * stride, i / sampled.x % sampled.y * stride, i / (sampled.x * sampled.y) * stride};
    const Coordinate at{in_slab.x, in_slab.y, first_layer + in_slab.z};
    const Validity validity(brick_, layout_.brick_extent(at));
    Worker& worker = *workers_[w];
    worker.grid.build(slab + (at.x * brick_ + e.x * (at.y * brick_ + e.y * in_slab.z * brick_)), e.x, e.x * e.y, validity);
    if (options.keep_outside) worker.grid.fill_outside(validity);
    worker.operations.encode(worker.grid, validity, options);
    body(w, in_slab.x + g.x * (in_slab.y + g.y * in_slab.z));
  });
}

/// Draws slabs of brick layers; body(call with a body for each brick, first layer, layers).
template <class Body>
void BrickEncoder::for_each_slab(unsigned stride, Body&& body) {
  const Extent& e = layout_.extent;
  const std::uint64_t layers_a_slab = stride > 1 ? stride : std::max<std::uint64_t>(kSlabDepth / brick_, 1);
  for (std::uint64_t layer = 0; layer < layout_.grid.z; layer += layers_a_slab) {
    // With a stride only the first layer of a slab is asked for.
    const std::uint64_t layers = stride > 1 ? 1 : std::min(layers_a_slab, layout_.grid.z - layer);
    const std::uint64_t z0 = layer * brick_;
    const std::uint64_t z1 = std::min(z0 + layers * brick_, e.z);
    const std::byte* slab = reader_.read(z0, z1);
    const std::uint64_t voxels = e.x * e.y * (z1 - z0);
    switch (source_.info().type) {
      case VoxelType::kU8: body(reinterpret_cast<const std::uint8_t*>(slab), layer, layers); break;
      case VoxelType::kU16: body(reinterpret_cast<const std::uint16_t*>(slab), layer, layers); break;
      case VoxelType::kU64:
        narrowed_.resize(voxels);
        remap_.apply({reinterpret_cast<const std::uint64_t*>(slab), voxels}, narrowed_.data());
        body(static_cast<const std::uint32_t*>(narrowed_.data()), layer, layers);
        break;
      default: body(reinterpret_cast<const std::uint32_t*>(slab), layer, layers); break;
    }
  }
}

/// The format's stride, halved until enough bricks are seen.
unsigned BrickEncoder::sampling_stride() const {
  unsigned stride = format_.sampling();
  while (stride > 1 && volumes::ceil_div(layout_.grid, stride).voxels() < kFewBricks) stride /= 2;
  return stride;
}

void BrickEncoder::sample() {
  const unsigned stride = sampling_stride();
  if (stride == 0) return;
  SymbolCounts counts{};
  std::mutex counts_mutex;
  for_each_slab(stride, [&](const auto* slab, std::uint64_t layer, std::uint64_t layers) {
    for_each_brick(slab, layer, layers, stride, [&](unsigned w, std::uint64_t) {
      const OperationStream& operations = workers_[w]->operations;
      const std::uint32_t finest = operations.level_start(layout_.levels - 1);
      std::array<std::array<std::uint32_t, 16>, 2> here{};
      const auto symbols = operations.symbols();
      for (const std::uint8_t symbol : symbols.first(finest)) ++here[0][symbol];
      for (const std::uint8_t symbol : symbols.subspan(finest)) ++here[1][symbol];
      const std::scoped_lock lock(counts_mutex);
      for (unsigned part = 0; part < 2; ++part) {
        for (unsigned s = 0; s < 16; ++s) counts[part][s] += here[part][s];
      }
    });
  });
  format_.fit(counts);
}

void BrickEncoder::write_front(ByteWriter& out, ByteBreakdown& bytes) const {
  out.put(static_cast<std::uint64_t>(remap_.labels().size()));
  for (const std::uint64_t label : remap_.labels()) out.put(label);
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

Expected<Payload> BrickEncoder::run() {
  const std::uint64_t bricks = layout_.grid.voxels();
  ByteBreakdown bytes;
  ByteWriter front;
  write_front(front, bytes);
  Payload payload{front.take(), {}, 0};
  const std::uint64_t table_at = payload.bytes.size();
  payload.bytes.resize(table_at + (bricks + 1) * sizeof(std::uint32_t));
  bytes[ByteClass::kIndex] = (bricks + 1) * sizeof(std::uint32_t);

  struct Piece {
    unsigned worker;
    std::size_t at, words;
  };
  std::vector<Piece> pieces;
  std::uint64_t brick = 0;  // next in the start table
  std::uint64_t words = 0;
  const auto set_start = [&](std::uint64_t i, std::uint64_t start) {
    const auto stored = static_cast<std::uint32_t>(start);
    std::memcpy(payload.bytes.data() + table_at + i * sizeof stored, &stored, sizeof stored);
  };
  for_each_slab(1, [&](const auto* slab, std::uint64_t layer, std::uint64_t layers) {
    for (const auto& worker : workers_) worker->words.clear();
    pieces.resize(layout_.grid.x * layout_.grid.y * layers);
    for_each_brick(slab, layer, layers, 1, [&](unsigned w, std::uint64_t i) {
      Worker& worker = *workers_[w];
      const std::size_t at = worker.words.size();
      format_.pack(worker.operations, worker.pack, worker.words, worker.bytes);
      pieces[i] = {w, at, worker.words.size() - at};
    });
    for (const Piece& piece : pieces) {
      set_start(brick++, words);
      payload.bytes.append(workers_[piece.worker]->words.data() + piece.at, piece.words * sizeof(std::uint32_t));
      words += piece.words;
    }
  });
  set_start(bricks, words);
  if (words > ~std::uint32_t{0}) {
    return fail(ErrorCode::kTooLarge, "the encoded bricks exceed 2^32 words, the range of the start table");
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

BrickExtent BrickLayout::brick_extent(const Coordinate& c) const {
  const auto cut = [this](std::uint64_t at, std::uint64_t size) {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(brick, size - at * brick));
  };
  return {cut(c.x, extent.x), cut(c.y, extent.y), cut(c.z, extent.z)};
}

void append_nibble_brick(const OperationStream& operations, std::vector<std::uint32_t>& words, ByteBreakdown& bytes) {
  append_level_starts(operations, words);
  const std::size_t operations_at = words.size();
  append_nibbles(operations.symbols(), words);
  bytes[ByteClass::kHeader] += 4 * (operations.levels() + 1);
  bytes[ByteClass::kOperations] += 4 * (words.size() - operations_at);
  append_palette(operations, words);
  bytes[ByteClass::kPalette] += 4 * operations.palette().size();
}

Expected<Payload> BrickCodec::encode(const VolumeSource& source, const Parameters& parameters, unsigned threads) const {
  const auto format = make_format_(parameters);
  BrickEncoder encoder(source, static_cast<std::uint32_t>(parameters.integer("brick")), *format, threads);
  encoder.sample();
  return encoder.run();
}

}  // namespace cvr::codecs::csgv
