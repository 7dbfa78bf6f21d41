// `csgv-nibble`: one plain nibble a symbol (CSGV-R paper, section 2.5).
//
// Brick in 32-bit words: [start of each level in nibbles, L words][palette size][nibbles, padded to
// a word][palette, reversed].
#include "codecs/csgv/brick_codec.hpp"
#include "codecs/csgv/csgv.hpp"

namespace cvr::codecs {

namespace {

using namespace csgv;

class NibbleFormat final : public BrickFormat {
 public:
  explicit NibbleFormat(const Parameters& parameters) : delta_(parameters.integer("delta") != 0) {}

  OperationOptions options() const override {
    return {.stop_bits = true, .keep_outside = false, .delta = delta_};
  }

  void pack(const SourceBrick& brick, PackWorkspace&, std::vector<std::uint32_t>& words,
            ByteBreakdown& bytes) const override {
    append_nibble_brick(brick.operations, words, bytes);
  }

  BrickError unpack(const StoredBrick& brick, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace) const override {
    const auto words = brick.words;
    const std::uint64_t header = workspace.grid.levels() + 1;
    if (words.size() <= header) return "the brick is shorter than its header";
    const std::uint32_t palette_size = words[header - 1];
    if (palette_size > words.size() - header) return "the palette is longer than the brick";
    NibbleReader reader(words.data() + header, words.size() - header - palette_size);
    Reconstruction reconstruction(reader, {words.data() + words.size() - 1, palette_size},
                                  workspace.grid, validity, options());
    return reconstruction.run(target, workspace.active[0].data(), workspace.active[1].data());
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

}  // namespace

const Codec& csgv_nibble_codec() {
  static const BrickCodec kCodec(
      brick_traits("csgv-nibble", "csgv", "CSGV, one nibble an operation", Granularity::kBrick),
      {brick_parameter(), delta_parameter()},
      [](const Parameters& parameters) { return std::make_unique<NibbleFormat>(parameters); });
  return kCodec;
}

}  // namespace cvr::codecs
