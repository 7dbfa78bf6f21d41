// The format `csgv-ctx`: tables, and what a group of bricks is made of; see FORMAT.md.
#include "codecs/csgv_ctx/csgv_ctx.hpp"

#include <algorithm>

#include "codecs/csgv/brick_codec.hpp"
#include "codecs/csgv_ctx/brick_rebuild.hpp"
#include "codecs/csgv_ctx/brick_walk.hpp"
#include "codecs/csgv_ctx/gpu_tables.hpp"
#include "codecs/csgv_ctx/label_list.hpp"
#include "codecs/csgv_ctx/model.hpp"
#include "codecs/csgv_ctx/training.hpp"
#include "codecs/radix_sort.hpp"

namespace cvr::codecs {

namespace {

using namespace csgv;
using namespace csgv_ctx;
using shaders::CtxBrick;
using shaders::CtxGroup;
using shaders::Words;

constexpr std::uint32_t kGroupVoxels = 64;      ///< voxels per side of a group, but at most
constexpr std::uint32_t kGroupBricks = 4;       ///< so many bricks per side
constexpr std::uint64_t kFewVoxels = 1u << 17;  ///< tables fitted to fewer would know too little
constexpr std::uint64_t kMostVoxels = 1u
                                      << 29;  ///< more would teach nothing, and counts have 32 bits

/// Bits that number `count` >= 1 things.
unsigned bits_for(std::uint64_t count) { return static_cast<unsigned>(std::bit_width(count - 1)); }

/// What trees may ask for, by the parameter "contexts": each choice adds to the one before.
constexpr std::array<std::string_view, 5> kContexts{"level", "neighbours", "siblings", "labels",
                                                    "all"};
ContextBits context_bits(std::string_view choice) {
  constexpr std::uint32_t kLevel = 3u << kDepth;
  constexpr std::uint32_t kNeighbours = kLevel | 7u << kChild | 7u << kDiffers | 7u << kSameOrNone;
  constexpr std::uint32_t kSiblings = 0x7fu << kEarlier;
  constexpr std::uint32_t kLabels = kSiblings | 7u << kNewestIs | 1u << kNewestIsLast;
  const auto given = std::ranges::find(kContexts, choice) - kContexts.begin();
  if (given == 4) return {};
  return {.statics = given == 0 ? kLevel : kNeighbours,
          .dynamics = given < 2    ? 0
                      : given == 2 ? kSiblings
                                   : kLabels};
}

/// The tables of a volume.
struct CtxTables {
  std::vector<std::uint32_t> labels;  ///< of the volume, ascending
  ContextModel model;

  unsigned label_bits() const { return bits_for(labels.size()); }
  Buffer write() const {
    std::vector<std::uint32_t> words;
    BitWriter bits(words);
    write_labels(labels, bits);
    model.write(bits);
    ByteWriter out;
    out.append(std::as_bytes(std::span(words)));
    return out.take();
  }
  static Expected<CtxTables> read(ByteReader& in);
};

Expected<CtxTables> CtxTables::read(ByteReader& in) {
  const auto bytes = in.take(in.remaining());
  std::vector<std::uint32_t> words(bytes.size() / 4);
  if (!words.empty()) std::memcpy(words.data(), bytes.data(), 4 * words.size());
  BitReader bits(words);
  CtxTables tables;
  if (!read_labels(bits, tables.labels))
    return fail(ErrorCode::kMalformed, "tables: expected the ascending labels of the volume");
  if (BrickError error = ContextModel::read(bits, tables.model))
    return fail(ErrorCode::kMalformed, std::string("tables: ") + error);
  return tables;
}

/// Calls body(place in `all`) for each of `some`, which are among them; both ascending.
template <class Body>
void for_each_place(const std::vector<std::uint32_t>& some, const std::vector<std::uint32_t>& all,
                    Body&& body) {
  auto at = all.begin();
  for (const std::uint32_t label : some) {
    std::ptrdiff_t step = 1;  // doubled until the label lies within it
    while (all.end() - at > step && at[step] <= label) {
      at += step;
      step *= 2;
    }
    at = std::lower_bound(at, all.end() - at > step ? at + step : all.end(), label);
    body(static_cast<std::uint32_t>(at - all.begin()));
  }
}

/// Keeps what the bricks of a group need until it is written.
class CtxPacker final : public GroupPacker {
 public:
  explicit CtxPacker(const CtxTables& tables) : tables_(tables) {}
  void pack(SourceGroup& group, std::vector<std::uint32_t>& words, ByteBreakdown& bytes) override {
    bricks_.clear();
    labels_.clear();
    streams_.clear();
    while (const auto brick = group.next()) add(*brick);
    rank_labels();
    append(words, bytes);
  }

 private:
  struct Brick {
    std::uint32_t first_entry, entries;  ///< in `labels_`
    std::uint32_t bytes;                 ///< of its stream
  };
  void add(const SourceBrick& brick);
  void put_reference(const CodedReference& reference, StreamEncoder& encoder) const;
  void rank_labels();
  void append(std::vector<std::uint32_t>& words, ByteBreakdown& bytes) const;

  const CtxTables& tables_;
  BrickWalk walk_;
  std::vector<Brick> bricks_;
  std::vector<std::uint32_t> labels_;  ///< palettes, one after the other
  std::vector<std::uint8_t> streams_;
  std::vector<std::uint16_t> stream_words_;
  std::vector<std::uint32_t> list_;   ///< the labels, ascending, each once
  std::vector<std::uint32_t> ranks_;  ///< in `list_`, of each of `labels_`
  std::vector<std::uint64_t> keyed_, spare_;
};

/// Finds the list and the ranks by one sort of (label, place).
void CtxPacker::rank_labels() {
  keyed_.resize(labels_.size());
  for (std::size_t i = 0; i < labels_.size(); ++i) keyed_[i] = std::uint64_t{labels_[i]} << 32 | i;
  radix_sort(keyed_, spare_);
  list_.clear();
  ranks_.resize(labels_.size());
  for (const std::uint64_t key : keyed_) {
    const auto label = static_cast<std::uint32_t>(key >> 32);
    if (list_.empty() || list_.back() != label) list_.push_back(label);
    ranks_[static_cast<std::uint32_t>(key)] = static_cast<std::uint32_t>(list_.size() - 1);
  }
}

void CtxPacker::put_reference(const CodedReference& reference, StreamEncoder& encoder) const {
  if (!reference.coded()) return;
  const unsigned width = reference.width();
  std::uint32_t value = reference.value;
  for (unsigned left = bits_below(width); left > 0;) {
    const unsigned count =
        (left - 1) % kProbabilityBits +
        1;  // the decoder takes as many as it can at a time, the last ones are fewest
    encoder.put_bits(value & ((1u << count) - 1), count);
    value >>= count;
    left -= count;
  }
  encoder.put(tables_.model.number(reference.kind()), width);
}

/// Codes a brick's stream at once; what needs the whole group waits for append(). Not
/// inlined: the loop needs all registers.
[[gnu::noinline]] void CtxPacker::add(const SourceBrick& brick) {
  walk_.run(brick.grid, brick.validity);
  const ContextModel& model = tables_.model;
  const std::span<const Event> events = walk_.events();
  StreamEncoder encoder(stream_words_, events.size() + kMostPieces * walk_.references().size());
  auto reference = walk_.references().end();
  for (std::size_t i = events.size(); i-- > 0;) {
    const Event event = events[i];
    const std::uint32_t symbol = symbol_of(event);
    if ((symbol & 7) == kDelta) put_reference(CodedReference(*--reference), encoder);
    encoder.put(model.distribution(model.row(static_of(event), dynamic_of(event))), symbol);
  }
  const std::size_t first = streams_.size();
  encoder.finish(streams_);
  bricks_.push_back({static_cast<std::uint32_t>(labels_.size()),
                     static_cast<std::uint32_t>(walk_.palette().size()),
                     static_cast<std::uint32_t>(streams_.size() - first)});
  labels_.insert(labels_.end(), walk_.palette().begin(), walk_.palette().end());
}

void CtxPacker::append(std::vector<std::uint32_t>& words, ByteBreakdown& bytes) const {
  std::uint32_t most_bytes = 0;
  std::uint32_t most_entries = 2;
  for (const Brick& brick : bricks_) {
    most_bytes = std::max(most_bytes, brick.bytes);
    most_entries = std::max(most_entries, brick.entries);
  }
  const auto size_bits = static_cast<unsigned>(std::bit_width(most_bytes));
  const auto count_bits = static_cast<unsigned>(std::bit_width(most_entries - 2));
  const unsigned rank_bits = bits_for(list_.size());
  const auto root = [&](std::size_t i) { return ranks_[bricks_[i].first_entry]; };

  const std::size_t first_word = words.size();
  BitWriter out(words);
  out.put(static_cast<std::uint32_t>(list_.size() - 1), CVR_CTX_LABELS_BITS);
  out.put(size_bits, CVR_CTX_SIZE_BITS);
  out.put(count_bits, CVR_CTX_HEADER_BITS - CVR_CTX_LABELS_BITS - CVR_CTX_SIZE_BITS);
  for (const Brick& brick : bricks_) out.put(brick.entries > 1 ? 1 : 0, 1);
  const std::uint64_t palette_at = out.bits();
  for (std::size_t i = 1; i < bricks_.size(); ++i) out.put(root(i) != root(i - 1) ? 1 : 0, 1);
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    if (i == 0 || root(i) != root(i - 1)) out.put(root(i), rank_bits);
  }
  for_each_place(list_, tables_.labels,
                 [&](std::uint32_t place) { out.put(place, tables_.label_bits()); });
  std::uint64_t palette_bits = out.bits() - palette_at;
  for (const Brick& brick : bricks_) {
    if (brick.entries == 1) continue;
    out.put(brick.bytes, size_bits);
    out.put(brick.entries - 2, count_bits);
  }
  const std::uint64_t entries_at = out.bits();
  for (const Brick& brick : bricks_) {
    for (std::uint32_t k = 1; k < brick.entries; ++k)
      out.put(ranks_[brick.first_entry + k], rank_bits);
  }
  palette_bits += out.bits() - entries_at;

  const std::size_t front = (out.bits() + 7) / 8;
  words.resize(first_word + (front + streams_.size() + 3) / 4);
  std::ranges::copy(streams_, reinterpret_cast<std::uint8_t*>(words.data() + first_word) + front);
  bytes[ByteClass::kPalette] += palette_bits / 8;
  bytes[ByteClass::kHeader] += front - palette_bits / 8;
  bytes[ByteClass::kOperations] += streams_.size();
  bytes[ByteClass::kPadding] += 4 * (words.size() - first_word) - front - streams_.size();
}

class CtxPacking final : public StreamingEncoder {
 public:
  explicit CtxPacking(CtxTables tables) : tables_(std::move(tables)) {}
  std::unique_ptr<GroupPacker> packer() const override {
    return std::make_unique<CtxPacker>(tables_);
  }

 private:
  CtxTables tables_;
};

class CtxEncoder final : public SampledEncoder {
 public:
  CtxEncoder(unsigned threads, const Sampling& sampling, const ContextBits& contexts,
             std::vector<std::uint32_t> labels)
      : sampling_(sampling), contexts_(contexts), labels_(std::move(labels)), workers_(threads) {}

  Sampling sampling() const override { return sampling_; }
  void count(unsigned w, const SourceBrick& brick) override {
    Worker& worker = workers_[w];
    worker.walk.run(brick.grid, brick.validity);
    worker.events.add(worker.walk.events());
    for (const Reference& older : worker.walk.references()) {
      const CodedReference reference(older);
      if (reference.coded()) ++worker.numbers[reference.kind()][reference.width()];
    }
  }
  Fitted<StreamingEncoder> fit() && override {
    EventCounts& events = workers_[0].events;
    NumberCounts& numbers = workers_[0].numbers;
    for (std::size_t w = 1; w < workers_.size(); ++w) {
      events.merge(workers_[w].events);
      for (unsigned kind = 0; kind < numbers.size(); ++kind) {
        for (unsigned s = 0; s < kSymbols; ++s) numbers[kind][s] += workers_[w].numbers[kind][s];
      }
    }
    CtxTables tables{std::move(labels_), train(events, numbers, contexts_)};
    Buffer bytes = tables.write();
    return {std::move(bytes), std::make_unique<const CtxPacking>(std::move(tables))};
  }

 private:
  struct alignas(64) Worker {
    BrickWalk walk;
    EventCounts events;
    NumberCounts numbers{};
  };

  Sampling sampling_;
  ContextBits contexts_;
  std::vector<std::uint32_t> labels_;  ///< of the volume, ascending
  std::vector<Worker> workers_;
};

class CtxReader final : public BrickReader, public EntropyTally {
 public:
  CtxReader(CtxTables tables, std::uint32_t group) : tables_(std::move(tables)), group_(group) {}

  BrickError check(std::span<const std::uint32_t> group, std::uint32_t bricks,
                   unsigned levels) const override;
  BrickError unpack(const StoredBrick& brick, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace) const override {
    return decode(brick, validity, target, workspace, nullptr);
  }
  const EntropyTally* entropy() const override { return this; }
  BrickError tally(const StoredBrick& brick, const Validity& validity, BrickWorkspace& workspace,
                   SymbolTally& tally) const override {
    return decode(brick, validity, workspace.grid.levels() - 1, workspace, &tally);
  }
  Expected<void> describe_to_gpu(const BrickLayout&, unsigned,
                                 GpuEncoding& encoding) const override {
    describe_tables(tables_.model, tables_.labels, group_, tables_.label_bits(), encoding);
    encoding.brick_loops +=
        encoding.brick_loops / 2 +
        group_ * group_ * group_;  // two sweeps, two nodes at once in one; records of a group
    return {};
  }

 private:
  BrickError decode(const StoredBrick& stored, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace, SymbolTally* tally) const;
  std::uint32_t label_of(Words words, const CtxGroup& group, std::uint32_t rank) const {
    const unsigned bits = tables_.label_bits();
    return tables_.labels[cvr_ctx_field(words, group.list_at + rank * bits, bits)];
  }

  CtxTables tables_;
  std::uint32_t group_;  ///< bricks per side
};

BrickError CtxReader::check(std::span<const std::uint32_t> group_words, std::uint32_t bricks,
                            unsigned levels) const {
  const std::uint64_t end = 32 * static_cast<std::uint64_t>(group_words.size());
  // Texts address bits in 32 bits; no encoder comes near that.
  if (end < CVR_CTX_HEADER_BITS + 2 * bricks || end > ~std::uint32_t{0})
    return "the group is shorter than its header, or far too long";
  const Words words{group_words.data()};
  const std::uint32_t most_voxels = bricks * nodes_of_level(levels - 1);
  if ((words.w[0] & ((1u << CVR_CTX_LABELS_BITS) - 1)) >= most_voxels)
    return "the group has more labels than voxels";
  const CtxGroup group = cvr_ctx_group(words, bricks, tables_.label_bits());
  if (group.records_at > end) return "the group is shorter than its list of labels";
  for (std::uint32_t i = 0; i < group.labels; ++i) {
    if (cvr_ctx_field(words, group.list_at + i * tables_.label_bits(), tables_.label_bits()) >=
        tables_.labels.size())
      return "a label is none of the volume's";
  }
  for (std::uint32_t at = group.roots_at; at < group.list_at; at += group.rank_bits) {
    if (cvr_ctx_field(words, at, group.rank_bits) >= group.labels)
      return "a root is none of the group's labels";
  }
  BitReader in(group_words, group.records_at);
  std::uint64_t entries = 0;
  std::uint64_t bytes = 0;
  for (std::uint32_t i = cvr_ctx_ones(words, group.several_at, bricks); i > 0; --i) {
    bytes += in.get(group.size_bits);
    entries += 1 + std::uint64_t{in.get(group.count_bits)};
  }
  if (in.failed() || entries > most_voxels) return "the group has more palette entries than voxels";
  for (std::uint64_t i = 0; i < entries; ++i) {
    if (in.get(group.rank_bits) >= group.labels)
      return "a palette entry is none of the group's labels";
  }
  if (in.failed() || ((in.position() + 7) / 8 + bytes + 3) / 4 != group_words.size())
    return "the streams do not fill the group";
  return nullptr;
}

BrickError CtxReader::decode(const StoredBrick& stored, const Validity& validity, unsigned target,
                             BrickWorkspace& workspace, SymbolTally* tally) const {
  const Words words{stored.words.data()};
  const CtxGroup group = cvr_ctx_group(words, stored.bricks, tables_.label_bits());
  const CtxBrick brick = cvr_ctx_brick(words, group, stored.member);
  std::vector<std::uint32_t>& palette = workspace.palette;
  palette.resize(brick.labels);
  palette[0] = label_of(words, group, brick.root);
  for (std::uint32_t k = 1; k < brick.labels; ++k) {
    palette[k] = label_of(
        words, group,
        cvr_ctx_field(words, brick.entries_at + (k - 1) * group.rank_bits, group.rank_bits));
  }
  const std::span stream(reinterpret_cast<const std::uint8_t*>(words.w) + brick.stream_at,
                         brick.bytes);
  return rebuild_brick(tables_.model, palette, stream, validity, target, workspace, tally);
}

class CtxFormat final : public BrickFormat {
 public:
  explicit CtxFormat(const Parameters& parameters)
      : BrickFormat(brick_edge(parameters),
                    {.stop_bits = true, .keep_outside = false, .delta = true},
                    std::min(kGroupVoxels / brick_edge(parameters), kGroupBricks)),
        stride_(static_cast<unsigned>(parameters.integer("sampling"))),
        contexts_(context_bits(parameters.text("contexts"))) {}

  EncoderStrategy encoder(unsigned threads, const StoredLabels& labels) const override {
    const std::uint64_t voxels = std::uint64_t{brick} * brick * brick;
    const Sampling sampling{stride_, std::max<std::uint64_t>(1, kFewVoxels / voxels),
                            kMostVoxels / voxels};
    return std::make_unique<CtxEncoder>(threads, sampling, contexts_, labels());
  }
  Expected<std::unique_ptr<const BrickReader>> reader(ByteReader& in) const override {
    auto tables = CtxTables::read(in);
    if (!tables) return tl::unexpected(tables.error());
    return std::make_unique<const CtxReader>(*std::move(tables), group);
  }

 private:
  unsigned stride_;
  ContextBits contexts_;
};

}  // namespace

const Codec& csgv_ctx_codec() {
  static const BrickCodec kCodec = [] {
    Traits traits = brick_traits("csgv-ctx", "csgv",
                                 "CSGV, symbols coded in their context: small at brick access",
                                 Granularity::kBrick);
    ParameterSpec brick = brick_parameter();
    brick.default_value = "16";
    brick.choices = {8, 16, 32, 64};
    return BrickCodec(
        traits,
        {brick,
         {.name = "sampling",
          .type = ParameterType::kInteger,
          .default_value = "2",
          .minimum = 1,
          .maximum = 64,
          .description = "the tables are fitted to every n-th brick per axis (fewer where that is "
                         "over 2^29 voxels, more where it is under 2^17)"},
         {.name = "contexts",
          .type = ParameterType::kText,
          .default_value = "all",
          .names = {kContexts.begin(), kContexts.end()},
          .description = "what symbols are conditioned on, each with what stands before it: the "
                         "level; the neighbours' labels; "
                         "which siblings differ; whether their label is a neighbour's; siblings' "
                         "neighbours and the palette"}},
        [](const Parameters& parameters) { return std::make_unique<CtxFormat>(parameters); });
  }();
  return kCodec;
}

}  // namespace cvr::codecs
