// The encoding half of the brick frame: slabs of brick layers are drawn from the source, their
// bricks encoded in parallel into the workers' own memory and appended in brick order, so that the
// bytes do not depend on the number of threads. Each strategy has its encode().
#include <algorithm>
#include <cstring>

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
  explicit Worker(std::uint32_t b) : grid(b) {}
  LabelGrid grid;
  std::vector<std::uint32_t> words;  ///< of the groups that wait to be appended
  ByteBreakdown bytes;
};

/// Whole layers of bricks, x fastest, labels as they are stored (u8, u16 or u32).
struct Slab {
  const std::byte* voxels;
  VoxelType type;
  std::uint64_t layer, layers;  ///< the first, and how many
};

/// Bricks side by side in a slab.
class SlabGroup final : public SourceGroup {
 public:
  SlabGroup(const BrickLayout& layout, const OperationOptions& options, const Slab& slab,
            const Coordinate& first, const Extent& bricks, LabelGrid& grid)
      : layout_(layout),
        options_(options),
        slab_(slab),
        first_(first),
        bricks_(bricks),
        grid_(grid) {}

  std::optional<SourceBrick> next() override {
    if (taken_ == bricks_.voxels()) return std::nullopt;
    const Coordinate in_group = bricks_.coordinate(taken_++);
    const Coordinate at{first_.x + in_group.x, first_.y + in_group.y, first_.z + in_group.z};
    const Extent& e = layout_.extent;
    const std::uint64_t b = layout_.brick;
    const std::uint64_t voxel = at.x * b + e.x * (at.y * b + e.y * (at.z - slab_.layer) * b);
    validity_.emplace(layout_.brick, layout_.brick_extent(at));
    volumes::with_label_type(slab_.type, [&]<class T>() {
      if constexpr (sizeof(T) <= 4)
        grid_.build(reinterpret_cast<const T*>(slab_.voxels) + voxel, e.x, e.x * e.y, *validity_);
    });
    if (options_.keep_outside) grid_.fill_outside(*validity_);
    return SourceBrick{grid_, *validity_};
  }

 private:
  const BrickLayout& layout_;
  const OperationOptions& options_;
  const Slab& slab_;
  Coordinate first_;
  Extent bricks_;
  LabelGrid& grid_;
  std::uint64_t taken_ = 0;
  std::optional<Validity> validity_;
};

class BrickEncoder {
 public:
  BrickEncoder(const VolumeSource& source, const BrickFormat& format, unsigned threads)
      : source_(source),
        reader_(source),
        remap_(source, threads),
        format_(format),
        threads_(std::max(1u, threads)),
        layout_(source.info().extent, format.brick, format.group) {
    for (unsigned i = 0; i < threads_; ++i)
      workers_.push_back(std::make_unique<Worker>(format.brick));
  }

  Expected<Payload> run();

 private:
  void encode(std::unique_ptr<const StreamingEncoder> encoder);
  void encode(std::unique_ptr<SampledEncoder> encoder);
  void encode(std::unique_ptr<TwoPassEncoder> encoder);

  std::vector<std::uint32_t> stored_labels();
  template <class Body>
  void for_each_slab(unsigned stride, Body&& body);
  unsigned stride_of(const Sampling& sampling) const;
  std::uint64_t groups_in(const Slab& slab) const;
  SlabGroup group_of(const Slab& slab, std::uint64_t i, unsigned worker) const;
  void stream(const StreamingEncoder& encoder);

  void begin(std::span<const std::byte> tables);
  template <class Make>
  void append_groups(std::uint64_t count, Make&& make);
  void append_start();

  const VolumeSource& source_;
  SlabReader reader_;
  LabelRemap remap_;
  const BrickFormat& format_;
  unsigned threads_;
  BrickLayout layout_;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::vector<std::uint32_t> narrowed_;

  Payload payload_{};
  std::uint64_t table_at_ = 0;  ///< byte of the start table
  std::uint64_t starts_ = 0;    ///< how many have been written
  std::uint64_t words_ = 0;     ///< of the groups that have been appended
};

/// All labels that are stored, ascending.
std::vector<std::uint32_t> BrickEncoder::stored_labels() {
  std::vector<std::uint32_t> stored;
  if (const std::size_t remapped = remap_.labels().size(); remapped > 0) {
    for (std::uint32_t i = 0; i < remapped; ++i) stored.push_back(i);
    return stored;
  }
  const std::vector<std::uint64_t> labels = distinct_labels(source_, threads_);
  stored.assign(labels.begin(), labels.end());
  return stored;
}

/// Draws slabs of brick layers; body(slab).
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
    Slab slab{reader_.read(z0, z1), source_.info().type, layer, layers};
    if (slab.type == VoxelType::kU64) {
      const std::uint64_t voxels = e.x * e.y * (z1 - z0);
      narrowed_.resize(voxels);
      remap_.apply({reinterpret_cast<const std::uint64_t*>(slab.voxels), voxels}, narrowed_.data());
      slab.voxels = reinterpret_cast<const std::byte*>(narrowed_.data());
      slab.type = VoxelType::kU32;
    }
    body(slab);
  }
}

/// The stride, halved until enough bricks are seen, doubled until they are not too many.
unsigned BrickEncoder::stride_of(const Sampling& sampling) const {
  unsigned stride = sampling.stride;
  const auto seen = [&] { return volumes::ceil_div(layout_.grid, stride).voxels(); };
  while (stride > 1 && seen() < sampling.few) stride /= 2;
  while (seen() > sampling.most) stride *= 2;
  return stride;
}

std::uint64_t BrickEncoder::groups_in(const Slab& slab) const {
  return layout_.groups.x * layout_.groups.y * ((slab.layers + layout_.group - 1) / layout_.group);
}

/// The i-th group of a slab of whole groups.
SlabGroup BrickEncoder::group_of(const Slab& slab, std::uint64_t i, unsigned worker) const {
  Coordinate group = layout_.groups.coordinate(i);
  group.z += slab.layer / layout_.group;
  const std::uint64_t g = layout_.group;
  return {layout_,
          format_.options,
          slab,
          {group.x * g, group.y * g, group.z * g},
          layout_.bricks_of_group(group),
          workers_[worker]->grid};
}

void BrickEncoder::stream(const StreamingEncoder& encoder) {
  std::vector<std::unique_ptr<GroupPacker>> packers;
  for (unsigned w = 0; w < threads_; ++w) packers.push_back(encoder.packer());
  for_each_slab(1, [&](const Slab& slab) {
    append_groups(groups_in(slab), [&](unsigned w, std::uint64_t i) {
      SlabGroup group = group_of(slab, i, w);
      packers[w]->pack(group, workers_[w]->words, workers_[w]->bytes);
    });
  });
}

void BrickEncoder::encode(std::unique_ptr<const StreamingEncoder> encoder) {
  begin({});
  stream(*encoder);
}

void BrickEncoder::encode(std::unique_ptr<SampledEncoder> encoder) {
  const unsigned stride = stride_of(encoder->sampling());
  for_each_slab(stride, [&](const Slab& slab) {
    const Extent sampled = volumes::ceil_div({layout_.grid.x, layout_.grid.y, slab.layers}, stride);
    parallel_for(threads_, sampled.voxels(), [&](unsigned w, std::uint64_t i) {
      const Coordinate n = sampled.coordinate(i);
      SlabGroup brick(layout_, format_.options, slab,
                      {n.x * stride, n.y * stride, slab.layer + n.z * stride}, {1, 1, 1},
                      workers_[w]->grid);
      encoder->count(w, *brick.next());
    });
  });
  const Fitted<StreamingEncoder> fitted = std::move(*encoder).fit();
  encoder.reset();
  begin(fitted.tables.bytes());
  stream(*fitted.result);
}

void BrickEncoder::encode(std::unique_ptr<TwoPassEncoder> encoder) {
  std::vector<KeptGroup> kept;  // in the order of the groups
  for_each_slab(1, [&](const Slab& slab) {
    const std::size_t first = kept.size();
    kept.resize(first + groups_in(slab));
    parallel_for(threads_, kept.size() - first, [&](unsigned w, std::uint64_t i) {
      SlabGroup group = group_of(slab, i, w);
      kept[first + i] = encoder->keep(w, group);
    });
  });
  const Fitted<KeptVolume> fitted = std::move(*encoder).fit();
  encoder.reset();
  begin(fitted.tables.bytes());
  std::vector<std::unique_ptr<GroupWriter>> writers;
  for (unsigned w = 0; w < threads_; ++w) writers.push_back(fitted.result->writer());
  for (std::size_t first = 0; first < kept.size(); first += kGroupsAtOnce) {
    append_groups(std::min(kGroupsAtOnce, kept.size() - first), [&](unsigned w, std::uint64_t i) {
      writers[w]->write(kept[first + i], workers_[w]->words, workers_[w]->bytes);
    });
  }
}

/// Begins the payload: labels, tables, room for the start table.
void BrickEncoder::begin(std::span<const std::byte> tables) {
  ByteBreakdown& bytes = payload_.breakdown;
  ByteWriter out;
  out.put(static_cast<std::uint64_t>(remap_.labels().size()));
  out.append(std::as_bytes(std::span(remap_.labels())));
  out.put(narrow<std::uint32_t>(tables.size()));
  out.put(std::uint32_t{0});
  out.append(tables);
  bytes[ByteClass::kTables] = out.size() - 16;
  bytes[ByteClass::kHeader] = 16;
  out.align(4);
  bytes[ByteClass::kPadding] = out.size() - 16 - bytes[ByteClass::kTables];
  payload_.bytes = out.take();
  table_at_ = payload_.bytes.size();
  bytes[ByteClass::kIndex] = (layout_.groups.voxels() + 1) * sizeof(std::uint32_t);
  payload_.bytes.resize(table_at_ + bytes[ByteClass::kIndex]);
}

/// make(worker, i) appends the i-th of the next groups to the worker's words; then they are
/// appended to the payload in their order.
template <class Make>
void BrickEncoder::append_groups(std::uint64_t count, Make&& make) {
  struct Piece {
    unsigned worker;
    std::size_t at, words;
  };
  std::vector<Piece> pieces(count);
  for (const auto& worker : workers_) worker->words.clear();
  parallel_for(threads_, count, [&](unsigned w, std::uint64_t i) {
    const std::size_t at = workers_[w]->words.size();
    make(w, i);
    pieces[i] = {w, at, workers_[w]->words.size() - at};
  });
  for (const Piece& piece : pieces) {
    append_start();
    payload_.bytes.append(workers_[piece.worker]->words.data() + piece.at,
                          piece.words * sizeof(std::uint32_t));
    words_ += piece.words;
  }
}

/// The next entry of the start table: where the next group begins, or the end.
void BrickEncoder::append_start() {
  const auto start = static_cast<std::uint32_t>(words_);
  std::memcpy(payload_.bytes.data() + table_at_ + starts_++ * sizeof start, &start, sizeof start);
}

Expected<Payload> BrickEncoder::run() {
  std::visit([this](auto&& encoder) { encode(std::forward<decltype(encoder)>(encoder)); },
             format_.encoder(threads_, [this] { return stored_labels(); }));
  append_start();
  if (words_ > ~std::uint32_t{0}) {
    return fail(ErrorCode::kTooLarge,
                "the encoded bricks exceed 2^32 words, the range of the start table");
  }
  for (const auto& worker : workers_) payload_.breakdown += worker->bytes;
  payload_.published_bytes = payload_.bytes.size() - table_at_;
  return std::move(payload_);
}

}  // namespace

Expected<Payload> BrickCodec::encode(const VolumeSource& source, const Parameters& parameters,
                                     unsigned threads) const {
  return BrickEncoder(source, *make_format_(parameters), threads).run();
}

}  // namespace cvr::codecs::csgv
