// `csgv-nibble`: one plain nibble a symbol (CSGV-R paper, section 2.5).
//
// Brick in 32-bit words: [start of each level in nibbles, L words][palette size][nibbles, padded to
// a word][palette, reversed].
#include "codecs/csgv/brick_codec.hpp"
#include "codecs/csgv/brick_gpu.hpp"
#include "codecs/csgv/csgv.hpp"
#include "codecs/csgv/nibbles.hpp"
#include "codecs/csgv/operation_encoder.hpp"

namespace cvr::codecs {

namespace {

using namespace csgv;

constexpr OperationOptions options_with(bool delta) {
  return {.stop_bits = true, .keep_outside = false, .delta = delta};
}

class NibbleBrickReader final : public BrickReader {
 public:
  explicit NibbleBrickReader(bool delta) : delta_(delta) {}

  /// unpack() checks all that it reads.
  BrickError check(std::span<const std::uint32_t>, std::uint32_t, unsigned) const override {
    return nullptr;
  }

  BrickError unpack(const StoredBrick& brick, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace) const override {
    const auto words = brick.words;
    const std::uint64_t header = workspace.grid.levels() + 1;
    if (words.size() <= header) return "the brick is shorter than its header";
    const std::uint32_t palette_size = words[header - 1];
    if (palette_size > words.size() - header) return "the palette is longer than the brick";
    NibbleReader reader(words.data() + header, words.size() - header - palette_size);
    const ReversedPalette palette{words.data() + words.size() - 1, palette_size};
    return rebuild(reader, palette, validity, options_with(delta_), target, workspace);
  }

  Expected<void> describe_to_gpu(const BrickLayout& layout, unsigned threads,
                                 GpuEncoding& encoding) const override {
    encoding.decoder = "csgv";
    if (delta_) encoding.brick_loops *= 17;  // a loop over digits for each node
    encoding.constants = {{"CVR_CSGV_RANS", 0u}, {"CVR_CSGV_DELTA", delta_ ? 1u : 0u}};
    return add_palettes(layout, threads, encoding);
  }

 private:
  bool delta_;
};

class NibbleFormat final : public BrickFormat {
 public:
  explicit NibbleFormat(const Parameters& parameters)
      : BrickFormat(brick_edge(parameters), options_with(parameters.integer("delta") != 0)) {}

  EncoderStrategy encoder(unsigned, const StoredLabels&) const override {
    return std::make_unique<const OperationEncoder<NibbleAppender>>(brick, options);
  }
  Expected<std::unique_ptr<const BrickReader>> reader(ByteReader&) const override {
    return std::make_unique<const NibbleBrickReader>(options.delta);
  }
};

}  // namespace

const Codec& csgv_nibble_codec() {
  static const BrickCodec kCodec(
      brick_traits("csgv-nibble", "csgv", "CSGV, one nibble an operation", Granularity::kBrick),
      {brick_parameter(), delta_parameter()},
      [](const Parameters& parameters) { return std::make_unique<NibbleFormat>(parameters); });
  return kCodec;
}

}  // namespace cvr::codecs
