// `csgvr` and `csgvr-sb`: operations in a Huffman-shaped wavelet matrix, without and with stop bits
// (CSGV-R paper, section 3).
//
// Brick layout and single-voxel access: shaders/shared/csgvr.glsl. This file builds the matrix,
// checks it, and decodes whole bricks by a faster path than node-by-node access: one cursor a
// wavelet level, eight operations a step.
#include "codecs/csgvr/csgvr.hpp"

#include <fmt/format.h>

#include "codecs/csgv/brick_codec.hpp"
#include "codecs/csgv/brick_gpu.hpp"
#include "codecs/csgv/operation_encoder.hpp"
#include "codecs/csgvr/voxel_walk.hpp"
#include "codecs/succinct/bit_vector.hpp"

namespace cvr::codecs {

namespace {

using namespace csgv;
using shaders::CsgvrBrick;
using shaders::Words;
using succinct::BitAppender;
using succinct::deposit_bits;
using succinct::extract_bits;

constexpr unsigned kWaveletLevels = CVR_WAVELET_LEVELS;

constexpr OperationOptions options_with(bool stop_bits) {
  return {.stop_bits = stop_bits, .keep_outside = true, .delta = false};
}

/// Bit k of 64 symbols, one plane for each k < 4.
std::array<std::uint64_t, 4> bit_planes(const std::uint8_t* symbols) {
  std::array<std::uint64_t, 4> planes{};
#ifdef CVR_LANES_AVX2
  for (unsigned half = 0; half < 2; ++half) {
    const __m256i bytes = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(symbols + 32 * half));
    for (unsigned k = 0; k < 4; ++k) {
      const __m256i top = _mm256_slli_epi16(bytes, static_cast<int>(7 - k));
      planes[k] |= std::uint64_t{static_cast<std::uint32_t>(_mm256_movemask_epi8(top))}
                   << (32 * half);
    }
  }
#else
  for (unsigned group = 0; group < 8; ++group) {
    std::uint64_t bytes;
    std::memcpy(&bytes, symbols + 8 * group, sizeof bytes);
    for (unsigned k = 0; k < 4; ++k)
      planes[k] |= std::uint64_t{gather_low_bits(bytes >> k)} << (8 * group);
  }
#endif
  return planes;
}

/// A Reader for Reconstruction over a checked brick.
class WaveletReader {
 public:
  WaveletReader(Words words, const CsgvrBrick& brick) : words_(words), brick_(brick) {
    for (unsigned l = 1; l < kWaveletLevels; ++l)
      cursors_[l] = words.w[brick.z_at + kWaveletLevels + l - 1];
    size_ = cursors_[1];  // the first wavelet level has one bit per symbol
  }
  void begin_level(unsigned, bool finest) { finest_ = finest; }
  bool take(unsigned count, std::uint64_t& codes) {
    if (cursors_[0] + count > size_) return false;
    const unsigned all = (1u << count) - 1;
    codes = 0;
    if (brick_.s.bits_at != 0 && !finest_)
      codes = kSpread[bits(brick_.s.bits_at, cursors_[0]) & all] * kStopBit;
    unsigned rest = all;
    for (unsigned l = 0; l < kWaveletLevels; ++l) {
      const unsigned left = static_cast<unsigned>(std::popcount(rest));
      const std::uint64_t ones = deposit_bits(bits(brick_.w.bits_at, cursors_[l]), rest);
      cursors_[l] += left;
      rest &= static_cast<unsigned>(~ones);
      if (rest == 0) return true;
      codes += kSpread[rest];  // one more zero before the first one
    }
    return true;
  }

 private:
  /// At least 33 bits from bit `i` on; a word beyond the vector may be touched, but not beyond the
  /// brick (its palette follows).
  std::uint64_t bits(std::uint32_t bits_at, std::uint32_t i) const {
    return shaders::cvr_word64(words_, bits_at + i / 32) >> (i % 32);
  }

  Words words_;
  const CsgvrBrick& brick_;
  std::array<std::uint32_t, kWaveletLevels> cursors_{};
  std::uint32_t size_;
  bool finest_ = false;
};

/// Appends bricks; reuses its vectors.
class MatrixAppender {
 public:
  explicit MatrixAppender(bool stop_bits) : stop_bits_(stop_bits) {}
  void operator()(const OperationStream& operations, std::vector<std::uint32_t>& words,
                  ByteBreakdown& bytes);

 private:
  bool stop_bits_;
  std::array<BitAppender, kWaveletLevels> levels_;
  BitAppender matrix_, stops_;
};

/// Splits symbols into the bits of each wavelet level and the stop bits. Level l has a bit for each
/// symbol with l zeros so far: one if the symbol ends there.
void build_wavelet_levels(std::span<const std::uint8_t> symbols,
                          std::array<BitAppender, kWaveletLevels>& levels, BitAppender& stops) {
  for (BitAppender& level : levels) level.clear();
  stops.clear();
  std::array<std::uint8_t, 64> tail{};
  for (std::size_t i = 0; i < symbols.size(); i += 64) {
    const auto count = static_cast<unsigned>(std::min<std::size_t>(64, symbols.size() - i));
    const std::uint8_t* chunk = symbols.data() + i;
    if (count < 64) {
      std::memcpy(tail.data(), chunk, count);
      chunk = tail.data();
    }
    const std::uint64_t all = ~std::uint64_t{0} >> (64 - count);
    const auto [p0, p1, p2, p3] = bit_planes(chunk);
    const std::array ends{~(p0 | p1 | p2), p0 & ~p1 & ~p2, p1 & ~p0 & ~p2, p0 & p1 & ~p2, p2 & ~p0};
    stops.append(p3 & all, count);
    std::uint64_t rest = all;
    for (unsigned l = 0; l < kWaveletLevels && rest != 0; ++l) {
      levels[l].append(extract_bits(ends[l], rest), static_cast<unsigned>(std::popcount(rest)));
      rest &= ~ends[l];
    }
  }
}

void MatrixAppender::operator()(const OperationStream& operations,
                                std::vector<std::uint32_t>& words, ByteBreakdown& bytes) {
  build_wavelet_levels(operations.symbols(), levels_, stops_);
  matrix_.clear();
  std::array<std::uint32_t, kWaveletLevels> starts;
  std::array<std::uint32_t, kWaveletLevels> ones_before;
  std::uint32_t ones = 0;
  for (unsigned l = 0; l < kWaveletLevels; ++l) {
    starts[l] = matrix_.size();
    ones_before[l] = ones;
    for (const std::uint64_t word : levels_[l].words())
      ones += static_cast<std::uint32_t>(std::popcount(word));
    matrix_.append(levels_[l]);
  }
  append_level_starts(operations, words);
  words.push_back(matrix_.size());
  words.insert(words.end(), ones_before.begin(), ones_before.end());
  words.insert(words.end(), starts.begin() + 1, starts.end());
  bytes[ByteClass::kHeader] += 4 * (operations.levels() + 2 + 2 * kWaveletLevels - 1);

  const auto append_vector = [&](const BitAppender& vector, ByteClass use) {
    const std::size_t rank_at = words.size();
    succinct::append_flat_rank(vector.words(), vector.size(), words);
    bytes[ByteClass::kRank] += 4 * (words.size() - rank_at);
    succinct::append_words(vector.words(), words);
    bytes[use] += 8 * vector.words().size();
  };
  append_vector(matrix_, ByteClass::kOperations);
  if (stop_bits_) {
    append_vector(stops_, ByteClass::kStopBits);
    words.push_back(static_cast<std::uint32_t>(stops_.words().size()));
    bytes[ByteClass::kHeader] += 4;
  }
  append_palette(operations, words);
  bytes[ByteClass::kPalette] += 4 * operations.palette().size();
}

class CsgvrReader final : public BrickReader, public VoxelReader {
 public:
  explicit CsgvrReader(bool stop_bits) : stop_bits_(stop_bits) {}

  BrickError check(std::span<const std::uint32_t> words, std::uint32_t bricks,
                   unsigned levels) const override;
  BrickError unpack(const StoredBrick& brick, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace) const override;
  const VoxelReader* voxels() const override { return this; }
  BrickError at(const BrickLayout& layout, std::span<const Coordinate> points, unsigned level,
                std::span<std::uint64_t> labels) const override;
  Expected<void> describe_to_gpu(const BrickLayout& layout, unsigned threads,
                                 GpuEncoding& encoding) const override {
    encoding.decoder = "csgvr";
    encoding.constants = {{"CVR_CSGVR_STOP_BITS", stop_bits_ ? 1u : 0u}};
    return add_palettes(layout, threads, encoding);
  }

 private:
  CsgvrBrick open(std::span<const std::uint32_t> words, unsigned levels) const {
    return shaders::cvr_csgvr_open({words.data()}, static_cast<std::uint32_t>(words.size()), levels,
                                   stop_bits_);
  }
  BrickError check_wavelet_matrix(Words words, const CsgvrBrick& brick, std::uint32_t symbols,
                                  std::uint32_t w_bits) const;
  BrickError check_levels(Words words, const CsgvrBrick& brick, std::uint32_t& symbols) const;

  bool stop_bits_;
};

/// Level starts: each level has eight nodes for each node of the level before that carries no stop
/// bit.
BrickError CsgvrReader::check_levels(Words words, const CsgvrBrick& brick,
                                     std::uint32_t& symbols) const {
  std::uint32_t start = 0;
  std::uint32_t nodes = 1;
  for (unsigned l = 0; l < brick.levels; ++l) {
    if (words.w[l] != start) return "a level does not begin where the coarser ones end";
    std::uint32_t open = nodes;
    if (stop_bits_) {
      if (start + nodes > symbols) return "the stop bits are fewer than the nodes";
      open -= cvr_rank1(words, brick.s, start + nodes) - cvr_rank1(words, brick.s, start);
    }
    start += nodes;
    nodes = 8 * open;
  }
  symbols = start;
  return nullptr;
}

BrickError CsgvrReader::check_wavelet_matrix(Words words, const CsgvrBrick& brick,
                                             std::uint32_t symbols, std::uint32_t w_bits) const {
  std::uint32_t start = 0;
  std::uint32_t length = symbols;
  for (unsigned l = 0; l < kWaveletLevels; ++l) {
    if (l > 0 && words.w[brick.z_at + kWaveletLevels + l - 1] != start)
      return "a wavelet level does not begin where the last ends";
    if (length > w_bits - start) return "a wavelet level is longer than the matrix";
    if (words.w[brick.z_at + l] != cvr_rank1(words, brick.w, start))
      return "the ones before a wavelet level are miscounted";
    const std::uint32_t ones =
        cvr_rank1(words, brick.w, start + length) - cvr_rank1(words, brick.w, start);
    if (l + 1 == kWaveletLevels && ones != brick.palette_size)
      return "palette and 'palette advance' operations differ in number";
    start += length;
    length -= ones;
  }
  return start == w_bits ? nullptr : "the wavelet matrix is longer than its levels";
}

BrickError CsgvrReader::check(std::span<const std::uint32_t> brick_words, std::uint32_t,
                              unsigned levels) const {
  const std::uint64_t header = levels + 2 + 2 * kWaveletLevels - 1;
  if (brick_words.size() <= header) return "the brick is shorter than its header";
  const Words words{brick_words.data()};
  const std::uint64_t size = brick_words.size();
  const std::uint64_t palette_size = words.w[levels];
  const std::uint32_t w_bits = words.w[levels + 1];
  // No brick has more than five bits a node; the bound keeps the sums below in range.
  if (w_bits > kWaveletLevels * nodes_before_level(levels))
    return "the wavelet matrix is longer than any brick's";
  const std::uint64_t w_words =
      2 * (std::uint64_t{succinct::flat_rank_entries(w_bits)} + succinct::words64(w_bits));
  if (palette_size == 0) return "the palette is empty";
  if (header + w_words + palette_size + (stop_bits_ ? 1 : 0) > size)
    return "the brick is shorter than its parts";
  std::uint32_t symbols = nodes_before_level(levels);
  const std::uint64_t s_at = header + w_words;
  if (stop_bits_) {
    const std::uint64_t s_words = words.w[size - palette_size - 1];
    if (s_words > succinct::words64(symbols)) return "the stop bits are more than the nodes";
    symbols = std::min(symbols, static_cast<std::uint32_t>(64 * s_words));
  }
  // The size of S follows from the level starts, which need its rank: find it from the first
  // wavelet level.
  const std::uint32_t first_level = words.w[header - kWaveletLevels + 1];
  if (first_level > symbols) return "the first wavelet level has more symbols than the brick";
  symbols = first_level;
  if (stop_bits_ && words.w[size - palette_size - 1] != succinct::words64(symbols)) {
    return "the stop bits are not as many as the nodes";
  }
  const std::uint64_t s_parts =
      stop_bits_
          ? 2 * (std::uint64_t{succinct::flat_rank_entries(symbols)} + succinct::words64(symbols)) +
                1
          : 0;
  if (s_at + s_parts + palette_size != size) return "the parts of the brick do not fill it";
  const CsgvrBrick brick = open(brick_words, levels);
  if (!succinct::check_flat_rank(words.w + brick.w.bits_at, w_bits, words.w + brick.w.rank_at)) {
    return "the rank of the wavelet matrix is wrong";
  }
  if (stop_bits_ &&
      !succinct::check_flat_rank(words.w + brick.s.bits_at, symbols, words.w + brick.s.rank_at)) {
    return "the rank of the stop bits is wrong";
  }
  std::uint32_t counted = symbols;
  if (BrickError error = check_levels(words, brick, counted)) return error;
  if (counted != symbols) return "the levels have more or fewer nodes than the wavelet matrix";
  return check_wavelet_matrix(words, brick, symbols, w_bits);
}

BrickError CsgvrReader::unpack(const StoredBrick& stored, const Validity& validity, unsigned target,
                               BrickWorkspace& workspace) const {
  const auto words = stored.words;
  const CsgvrBrick brick = open(words, workspace.grid.levels());
  WaveletReader reader({words.data()}, brick);
  const ReversedPalette palette{words.data() + words.size() - 1, brick.palette_size};
  return rebuild(reader, palette, validity, options_with(stop_bits_), target, workspace);
}

BrickError CsgvrReader::at(const BrickLayout& layout, std::span<const Coordinate> points,
                           unsigned level, std::span<std::uint64_t> labels) const {
  return csgvr::for_each_point(layout, points, level, labels,
                               [&](std::span<const std::uint32_t> brick_words, std::uint32_t,
                                   std::uint32_t n, std::uint64_t& label) {
                                 const CsgvrBrick brick = open(brick_words, layout.levels);
                                 const Words words{brick_words.data()};
                                 std::uint32_t index = 0;
                                 std::uint32_t hops = 0;
                                 if (!cvr_csgvr_palette_index(words, brick, n, level, index, hops))
                                   return false;
                                 label = cvr_csgvr_label(words, brick, index);
                                 return true;
                               });
}

class CsgvrFormat final : public BrickFormat {
 public:
  CsgvrFormat(const Parameters& parameters, bool stop_bits)
      : BrickFormat(brick_edge(parameters), options_with(stop_bits)) {}
  EncoderStrategy encoder(unsigned, const StoredLabels&) const override {
    return std::make_unique<const OperationEncoder<MatrixAppender>>(
        brick, options, MatrixAppender(options.stop_bits));
  }
  Expected<std::unique_ptr<const BrickReader>> reader(ByteReader&) const override {
    return std::make_unique<const CsgvrReader>(options.stop_bits);
  }
};

}  // namespace

const Codec& csgvr_codec() {
  static const BrickCodec kCodec(
      brick_traits("csgvr", "csgvr", "CSGV-R: wavelet matrix, no stop bits", Granularity::kVoxel),
      {brick_parameter()}, [](const Parameters& parameters) {
        return std::make_unique<CsgvrFormat>(parameters, false);
      });
  return kCodec;
}

const Codec& csgvr_sb_codec() {
  static const BrickCodec kCodec(
      brick_traits("csgvr-sb", "csgvr", "CSGV-R: wavelet matrix and stop bits",
                   Granularity::kVoxel),
      {brick_parameter()},
      [](const Parameters& parameters) { return std::make_unique<CsgvrFormat>(parameters, true); });
  return kCodec;
}

}  // namespace cvr::codecs
