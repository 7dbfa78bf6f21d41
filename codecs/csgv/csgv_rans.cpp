// `csgv-rans`: the symbols (operation + stop bit) entropy-coded with two static tables a volume
// (CSGV-R paper, section 2.5).
//
// Brick in 32-bit words: [start of each level, L words][palette size][coarse stream][fine stream,
// padded to a word] [palette, reversed]. The starts count symbols, but for the finest level: there
// it is the byte at which the fine stream begins. The coarse stream holds all levels but the
// finest, the fine stream the finest (no stop bits); each is empty where no symbol is. Tables: 2 x
// 16 frequencies (u16), coarse first.
#include <cstring>

#include "codecs/csgv/brick_codec.hpp"
#include "codecs/csgv/brick_gpu.hpp"
#include "codecs/csgv/csgv.hpp"
#include "codecs/csgv/operation_encoder.hpp"
#include "codecs/entropy/rans.hpp"

namespace cvr::codecs {

namespace {

using namespace csgv;
using entropy::RansDecoder;
using entropy::RansTable;

constexpr OperationOptions options_with(bool delta) {
  return {.stop_bits = true, .keep_outside = false, .delta = delta};
}

/// [0] of all coarse levels, [1] of the finest.
using RansTables = std::array<RansTable, 2>;

/// A Reader for Reconstruction over the two streams.
class RansReader {
 public:
  /// tally: counts the symbols, or nullptr.
  RansReader(const RansTables& tables, std::span<const std::uint8_t> coarse,
             std::span<const std::uint8_t> fine, SymbolTally* tally)
      : tables_(tables), fine_(fine), decoder_(tables[0], coarse), tally_(tally) {}
  void begin_level(unsigned, bool finest) {
    if (finest) decoder_ = RansDecoder(tables_[1], fine_);
    finest_ = finest;
  }
  bool take(unsigned count, std::uint64_t& codes) {
    codes = 0;
    for (unsigned c = 0; c < count; ++c) codes |= std::uint64_t{decoder_.next()} << (8 * c);
    if (tally_ != nullptr) {
      for (unsigned c = 0; c < count; ++c)
        tally_->add(finest_ ? 1 : 0, static_cast<std::uint32_t>(codes >> (8 * c) & 0xff));
    }
    return !decoder_.failed();
  }

 private:
  const RansTables& tables_;
  std::span<const std::uint8_t> fine_;
  RansDecoder decoder_;
  SymbolTally* tally_;
  bool finest_ = false;
};

/// Appends bricks.
class RansAppender {
 public:
  explicit RansAppender(const RansTables& tables) : tables_(tables) {}
  void operator()(const OperationStream& operations, std::vector<std::uint32_t>& words,
                  ByteBreakdown& bytes) {
    const unsigned levels = operations.levels();
    const std::size_t brick_at = words.size();
    append_level_starts(operations, words);
    streams_.clear();
    const auto symbols = operations.symbols();
    const std::uint32_t finest = operations.level_start(levels - 1);
    tables_[0].encode(symbols.first(finest), streams_);
    words[brick_at + levels - 1] = static_cast<std::uint32_t>(streams_.size());
    tables_[1].encode(symbols.subspan(finest), streams_);
    bytes[ByteClass::kOperations] += streams_.size();
    while (streams_.size() % 4 != 0) {
      streams_.push_back(0);
      ++bytes[ByteClass::kPadding];
    }
    const std::size_t streams_at = words.size();
    words.resize(streams_at + streams_.size() / 4);
    std::memcpy(words.data() + streams_at, streams_.data(), streams_.size());
    append_palette(operations, words);
    bytes[ByteClass::kHeader] += 4 * (levels + 1);
    bytes[ByteClass::kPalette] += 4 * operations.palette().size();
  }

 private:
  RansTables tables_;
  std::vector<std::uint8_t> streams_;
};

/// Counts how often each symbol occurs.
class RansEncoder final : public SampledEncoder {
 public:
  RansEncoder(unsigned threads, std::uint32_t brick, const OperationOptions& options,
              unsigned stride)
      : brick_(brick), options_(options), stride_(stride), workers_(threads, Worker(brick)) {}

  Sampling sampling() const override { return {stride_, 64}; }
  void count(unsigned w, const SourceBrick& brick) override {
    auto& [operations, counts] = workers_[w];
    operations.encode(brick.grid, brick.validity, options_);
    const std::uint32_t finest = operations.level_start(operations.levels() - 1);
    const auto symbols = operations.symbols();
    for (const std::uint8_t symbol : symbols.first(finest)) ++counts[0][symbol];
    for (const std::uint8_t symbol : symbols.subspan(finest)) ++counts[1][symbol];
  }
  Fitted<StreamingEncoder> fit() && override {
    RansTables tables;
    ByteWriter out;
    for (unsigned part = 0; part < 2; ++part) {
      Counts sum{};
      for (const Worker& worker : workers_) {
        for (unsigned s = 0; s < sum.size(); ++s) sum[s] += worker.counts[part][s];
      }
      // Operations 0..5 with and without stop bit; digits of deltas take any value.
      tables[part] = RansTable::fit(sum, options_.delta ? 0xffff : part == 0 ? 0x3f3f : 0x003f);
      for (const std::uint16_t f : tables[part].frequencies()) out.put(f);
    }
    return {out.take(), std::make_unique<const OperationEncoder<RansAppender>>(
                            brick_, options_, RansAppender(tables))};
  }

 private:
  using Counts = std::array<std::uint64_t, entropy::kRansSymbols>;
  struct alignas(64) Worker {
    explicit Worker(std::uint32_t b) : operations(b) {}
    OperationStream operations;
    std::array<Counts, 2> counts{};  ///< of all coarse levels, of the finest
  };

  std::uint32_t brick_;
  OperationOptions options_;
  unsigned stride_;
  std::vector<Worker> workers_;
};

class RansBrickReader final : public BrickReader, public EntropyTally {
 public:
  RansBrickReader(bool delta, const RansTables& tables) : delta_(delta), tables_(tables) {}

  /// unpack() checks all that it reads.
  BrickError check(std::span<const std::uint32_t>, std::uint32_t, unsigned) const override {
    return nullptr;
  }
  BrickError unpack(const StoredBrick& brick, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace) const override {
    return decode(brick.words, validity, target, workspace, nullptr);
  }
  const EntropyTally* entropy() const override { return this; }
  BrickError tally(const StoredBrick& brick, const Validity& validity, BrickWorkspace& workspace,
                   SymbolTally& tally) const override {
    return decode(brick.words, validity, workspace.grid.levels() - 1, workspace, &tally);
  }
  Expected<void> describe_to_gpu(const BrickLayout& layout, unsigned threads,
                                 GpuEncoding& encoding) const override {
    encoding.decoder = "csgv";
    if (delta_) encoding.brick_loops *= 17;  // a loop over digits for each node
    encoding.constants = {{"CVR_CSGV_RANS", 1u}, {"CVR_CSGV_DELTA", delta_ ? 1u : 0u}};
    auto slots = std::make_shared<Buffer>();
    for (const RansTable& table : tables_) {
      const std::vector<std::uint32_t> words = table.packed_slots();
      slots->append(words.data(), words.size() * sizeof words[0]);
    }
    encoding.buffers.push_back({"tables", slots->bytes(), slots});
    return add_palettes(layout, threads, encoding);
  }

 private:
  BrickError decode(std::span<const std::uint32_t> words, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace, SymbolTally* tally) const {
    const unsigned levels = workspace.grid.levels();
    const std::uint64_t header = levels + 1;
    if (words.size() <= header) return "the brick is shorter than its header";
    const std::uint32_t palette_size = words[header - 1];
    if (palette_size > words.size() - header) return "the palette is longer than the brick";
    const std::span streams(reinterpret_cast<const std::uint8_t*>(words.data() + header),
                            4 * (words.size() - header - palette_size));
    const std::uint32_t fine_at = words[levels - 1];
    if (fine_at > streams.size()) return "the fine stream begins beyond the brick";
    RansReader reader(tables_, streams.first(fine_at), streams.subspan(fine_at), tally);
    const ReversedPalette palette{words.data() + words.size() - 1, palette_size};
    return rebuild(reader, palette, validity, options_with(delta_), target, workspace);
  }

  bool delta_;
  RansTables tables_;
};

class RansFormat final : public BrickFormat {
 public:
  explicit RansFormat(const Parameters& parameters)
      : BrickFormat(brick_edge(parameters), options_with(parameters.integer("delta") != 0)),
        stride_(static_cast<unsigned>(parameters.integer("sampling"))) {}

  EncoderStrategy encoder(unsigned threads, const StoredLabels&) const override {
    return std::make_unique<RansEncoder>(threads, brick, options, stride_);
  }
  Expected<std::unique_ptr<const BrickReader>> reader(ByteReader& in) const override {
    RansTables tables;
    for (RansTable& table : tables) {
      std::array<std::uint16_t, entropy::kRansSymbols> frequencies;
      for (std::uint16_t& f : frequencies) f = in.get<std::uint16_t>();
      if (in.failed() || !RansTable::from_frequencies(frequencies, table)) {
        return fail(ErrorCode::kMalformed,
                    "frequency tables: expected 2 x 16 frequencies that sum to 16384 each");
      }
    }
    return std::make_unique<const RansBrickReader>(options.delta, tables);
  }

 private:
  unsigned stride_;
};

}  // namespace

const Codec& csgv_rans_codec() {
  static const BrickCodec kCodec(
      brick_traits("csgv-rans", "csgv", "CSGV, range-ANS with two static tables a volume",
                   Granularity::kBrick),
      {brick_parameter(),
       delta_parameter(),
       {.name = "sampling",
        .type = ParameterType::kInteger,
        .default_value = "8",
        .minimum = 1,
        .maximum = 64,
        .description = "the tables are fitted to every n-th brick per axis (less where that leaves "
                       "under 64 bricks)"}},
      [](const Parameters& parameters) { return std::make_unique<RansFormat>(parameters); });
  return kCodec;
}

}  // namespace cvr::codecs
