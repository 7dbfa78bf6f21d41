// `csgv-rans`: the symbols (operation + stop bit) entropy-coded with two static tables a volume
// (CSGV-R paper, section 2.5).
//
// Brick in 32-bit words: [start of each level, L words][palette size][coarse stream][fine stream,
// padded to a word] [palette, reversed]. The starts count symbols, but for the finest level: there
// it is the byte at which the fine stream begins. The coarse stream holds all levels but the
// finest, the fine stream the finest (no stop bits); each is empty where no symbol is. Tables: 2 x
// 16 frequencies (u16), coarse first.
#include "codecs/csgv/brick_codec.hpp"
#include "codecs/csgv/csgv.hpp"
#include "codecs/entropy/rans.hpp"

namespace cvr::codecs {

namespace {

using namespace csgv;
using entropy::RansDecoder;
using entropy::RansTable;

/// A Reader for Reconstruction over the two streams.
class RansReader {
 public:
  /// tally: counts the symbols, or nullptr.
  RansReader(const std::array<RansTable, 2>& tables, std::span<const std::uint8_t> coarse,
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
  const std::array<RansTable, 2>& tables_;
  std::span<const std::uint8_t> fine_;
  RansDecoder decoder_;
  SymbolTally* tally_;
  bool finest_ = false;
};

/// How often each symbol occurs: [0] in all coarse levels, [1] in the finest.
class SymbolCounts final : public BrickStatistics {
 public:
  void add(const SourceBrick& brick) override {
    const OperationStream& operations = brick.operations;
    const std::uint32_t finest = operations.level_start(operations.levels() - 1);
    const auto symbols = operations.symbols();
    for (const std::uint8_t symbol : symbols.first(finest)) ++counts[0][symbol];
    for (const std::uint8_t symbol : symbols.subspan(finest)) ++counts[1][symbol];
  }
  void merge(const BrickStatistics& other) override {
    for (unsigned part = 0; part < 2; ++part) {
      for (unsigned s = 0; s < 16; ++s)
        counts[part][s] += static_cast<const SymbolCounts&>(other).counts[part][s];
    }
  }
  std::array<std::array<std::uint64_t, entropy::kRansSymbols>, 2> counts{};
};

struct RansWorkspace final : PackWorkspace {
  std::vector<std::uint8_t> bytes;
};

class RansFormat final : public BrickFormat {
 public:
  explicit RansFormat(const Parameters& parameters)
      : delta_(parameters.integer("delta") != 0),
        sampling_(static_cast<unsigned>(parameters.integer("sampling"))) {}

  OperationOptions options() const override {
    return {.stop_bits = true, .keep_outside = false, .delta = delta_};
  }
  Sampling sampling() const override { return {sampling_, 64}; }
  std::unique_ptr<BrickStatistics> statistics() const override {
    return std::make_unique<SymbolCounts>();
  }
  void fit(const BrickStatistics& statistics) override {
    const auto& counts = static_cast<const SymbolCounts&>(statistics).counts;
    // Operations 0..5 with and without stop bit; digits of deltas take any value.
    tables_[0] = RansTable::fit(counts[0], delta_ ? 0xffff : 0x3f3f);
    tables_[1] = RansTable::fit(counts[1], delta_ ? 0xffff : 0x003f);
  }
  void write_tables(ByteWriter& out) const override {
    for (const RansTable& table : tables_) {
      for (const std::uint16_t f : table.frequencies()) out.put(f);
    }
  }
  Expected<void> read_tables(ByteReader& in) override {
    for (RansTable& table : tables_) {
      std::array<std::uint16_t, entropy::kRansSymbols> frequencies;
      for (std::uint16_t& f : frequencies) f = in.get<std::uint16_t>();
      if (in.failed() || !RansTable::from_frequencies(frequencies, table)) {
        return fail(ErrorCode::kMalformed,
                    "frequency tables: expected 2 x 16 frequencies that sum to 16384 each");
      }
    }
    return {};
  }

  std::unique_ptr<PackWorkspace> pack_workspace() const override {
    return std::make_unique<RansWorkspace>();
  }
  void pack(const SourceBrick& brick, PackWorkspace& workspace, std::vector<std::uint32_t>& words,
            ByteBreakdown& bytes) const override {
    const OperationStream& operations = brick.operations;
    const unsigned levels = operations.levels();
    const std::size_t brick_at = words.size();
    append_level_starts(operations, words);
    std::vector<std::uint8_t>& streams = static_cast<RansWorkspace&>(workspace).bytes;
    streams.clear();
    const auto symbols = operations.symbols();
    const std::uint32_t finest = operations.level_start(levels - 1);
    tables_[0].encode(symbols.first(finest), streams);
    words[brick_at + levels - 1] = static_cast<std::uint32_t>(streams.size());
    tables_[1].encode(symbols.subspan(finest), streams);
    bytes[ByteClass::kOperations] += streams.size();
    while (streams.size() % 4 != 0) {
      streams.push_back(0);
      ++bytes[ByteClass::kPadding];
    }
    const std::size_t streams_at = words.size();
    words.resize(streams_at + streams.size() / 4);
    std::memcpy(words.data() + streams_at, streams.data(), streams.size());
    append_palette(operations, words);
    bytes[ByteClass::kHeader] += 4 * (levels + 1);
    bytes[ByteClass::kPalette] += 4 * operations.palette().size();
  }

  BrickError unpack(const StoredBrick& brick, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace) const override {
    return decode(brick.words, validity, target, workspace, nullptr);
  }
  bool has_entropy() const override { return true; }
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
    Reconstruction reconstruction(reader, {words.data() + words.size() - 1, palette_size},
                                  workspace.grid, validity, options());
    return reconstruction.run(target, workspace.active[0].data(), workspace.active[1].data());
  }

  bool delta_;
  unsigned sampling_;
  std::array<RansTable, 2> tables_;
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
        .description = "the tables are fitted to every n-th brick an axis (less where that leaves "
                       "under 64 bricks)"}},
      [](const Parameters& parameters) { return std::make_unique<RansFormat>(parameters); });
  return kCodec;
}

}  // namespace cvr::codecs
