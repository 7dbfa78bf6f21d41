// `csgvr-nibble`: random access without wavelet matrix and stop bits (supplemental, section 3).
// Layout and access: shaders/shared/csgvr_nibble.glsl. Every brick codes all (8^L - 1) / 7 nodes.
#include "codecs/csgv/brick_codec.hpp"
#include "codecs/csgv/brick_gpu.hpp"
#include "codecs/csgv/nibbles.hpp"
#include "codecs/csgv/operation_encoder.hpp"
#include "codecs/csgvr/csgvr.hpp"
#include "codecs/csgvr/voxel_walk.hpp"

namespace cvr::codecs {

namespace {

using namespace csgv;

constexpr OperationOptions kOptions{.stop_bits = false, .keep_outside = true, .delta = false};

class CsgvrNibbleReader final : public BrickReader, public VoxelReader {
 public:
  BrickError check(std::span<const std::uint32_t> words, std::uint32_t,
                   unsigned levels) const override {
    const std::uint64_t nibble_words = (nodes_before_level(levels) + 7) / 8;
    if (words.size() < levels + 1 + nibble_words) return "the brick is shorter than its operations";
    if (words.size() != levels + 1 + nibble_words + words[levels])
      return "the palette does not end with the brick";
    for (unsigned l = 0; l < levels; ++l) {
      if (words[l] != nodes_before_level(l))
        return "a level does not begin where all coarser nodes end";
    }
    return words[levels] == 0 ? "the palette is empty" : nullptr;
  }

  BrickError unpack(const StoredBrick& brick, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace) const override {
    const auto words = brick.words;
    const unsigned levels = workspace.grid.levels();
    const std::uint32_t palette_size = words[levels];
    NibbleReader reader(words.data() + levels + 1, words.size() - levels - 1 - palette_size);
    const ReversedPalette palette{words.data() + words.size() - 1, palette_size};
    return rebuild(reader, palette, validity, kOptions, target, workspace);
  }

  Expected<void> describe_to_gpu(const BrickLayout& layout, unsigned threads,
                                 GpuEncoding& encoding) const override {
    encoding.decoder = "csgvr_nibble";
    encoding.cell_loops +=
        nodes_of_level(encoding.levels - 1) / (7 * CVR_NIBBLE_WORDS) + 1;  // eight nodes a word
    return add_palettes(layout, threads, encoding);
  }

  const VoxelReader* voxels() const override { return this; }
  BrickError at(const BrickLayout& layout, std::span<const Coordinate> points, unsigned level,
                std::span<std::uint64_t> labels) const override {
    return csgvr::for_each_point(
        layout, points, level, labels,
        [&](std::span<const std::uint32_t> brick, std::uint32_t, std::uint32_t n,
            std::uint64_t& label) {
          std::uint32_t index = 0;
          std::uint32_t hops = 0;
          const shaders::Words words{brick.data()};
          if (!cvr_csgvr_nibble_palette_index(words, layout.levels, n, level, index, hops))
            return false;
          label = brick[brick.size() - 1 - index];
          return true;
        });
  }
};

class CsgvrNibbleFormat final : public BrickFormat {
 public:
  explicit CsgvrNibbleFormat(const Parameters& parameters)
      : BrickFormat(brick_edge(parameters), kOptions) {}
  EncoderStrategy encoder(unsigned, const StoredLabels&) const override {
    return std::make_unique<const OperationEncoder<NibbleAppender>>(brick, options);
  }
  Expected<std::unique_ptr<const BrickReader>> reader(ByteReader&) const override {
    return std::make_unique<const CsgvrNibbleReader>();
  }
};

}  // namespace

const Codec& csgvr_nibble_codec() {
  static const BrickCodec kCodec(
      brick_traits("csgvr-nibble", "csgvr",
                   "CSGV-R without wavelet matrix: one nibble an operation, counted by a loop",
                   Granularity::kVoxel),
      {brick_parameter()},
      [](const Parameters& parameters) { return std::make_unique<CsgvrNibbleFormat>(parameters); });
  return kCodec;
}

}  // namespace cvr::codecs
