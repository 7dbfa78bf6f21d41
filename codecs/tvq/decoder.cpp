// The decoder. All ways lead through one image of rows, books and records
// (shaders/shared/tvq.glsl): single voxels through the text that a GPU runs, whole levels block by
// block from books that are multiplied by their scale beforehand.
#include "codecs/tvq/decoder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "shaders/shared/shared.hpp"
#include "volumes/parallel.hpp"

#if defined(__AVX2__) && !defined(CVR_SCALAR)
#define CVR_TVQ_AVX2 1
#include <immintrin.h>
#endif

namespace cvr::codecs::tvq {

namespace {

constexpr std::uint32_t kRow = CVR_TVQ_ROW;

/// Books as a decoder of whole levels wants them: 64 entries a code vector in units.
template <class T>
struct Table {
  std::array<std::vector<T>, kMaxBooks> books;
};

std::uint32_t append_book(std::vector<std::uint32_t>& words, const Book& book) {
  const auto first = words.size();
  const unsigned per_word = 4 / book.entry_bytes, bits = 8 * book.entry_bytes;
  const std::uint32_t mask = book.entry_bytes == 1 ? 0xffu : 0xffffu;
  words.resize(first + (book.entries.size() + per_word - 1) / per_word, 0);
  for (std::size_t i = 0; i < book.entries.size(); ++i) {
    words[first + i / per_word] |= (static_cast<std::uint32_t>(book.entries[i]) & mask)
                                   << (i % per_word * bits);
  }
  return static_cast<std::uint32_t>(first);
}

/// Rows, books and records; nothing if it does not fit 32-bit addresses of words.
std::optional<std::vector<std::uint32_t>> make_image(const Scheme& scheme,
                                                     const Encoding& encoding) {
  const DeviceBytes bytes = device_bytes(scheme, encoding);
  if (bytes.total() / 4 + encoding.parts.size() * (kRow + 8) > 0xfffffff0u) return std::nullopt;
  std::vector<std::uint32_t> words(encoding.parts.size() * kRow, 0);
  words.reserve(words.size() + bytes.total() / 4 + encoding.parts.size() * 8);
  std::vector<std::array<std::uint32_t, kMaxBooks>> first_words;  // of the books of each set
  for (std::size_t s = 0; s < encoding.parts.size(); ++s) {
    const SubVolume& part = encoding.parts[s];
    std::array<std::uint32_t, kRow> row{};
    row[2] = part.dc_bits;
    row[3] = static_cast<std::uint32_t>(part.dc_base);
    row[4] = part.dc_step;
    unsigned record = part.dc_bits;
    const std::size_t set = s % encoding.books.size();
    const bool first_use = set == first_words.size();
    if (first_use) first_words.emplace_back();
    for (unsigned p = 0; p < kMaxBooks; ++p) {
      std::uint32_t* entry = row.data() + 5 + 4 * p;
      const Book& book = encoding.books[set].books[p];
      if (p >= scheme.books || (book.size == 1 && scheme.zero_vectors())) {
        entry[3] = 4;
        continue;
      }
      if (first_use) first_words[set][p] = append_book(words, book);
      entry[0] = book.bits();
      entry[1] = first_words[set][p];
      entry[2] = book.scale;
      entry[3] = (book.entry_bytes == 2 ? 1u : 0u) | (scheme.length[p] == 8 ? 2u : 0u);
      record += book.bits();
    }
    row[0] = static_cast<std::uint32_t>(words.size());
    row[1] = record;
    const std::uint64_t blocks = part.blocks.voxels();
    if (record > 0) words.resize(words.size() + (blocks * record + 31) / 32, 0);
    std::uint64_t bit = std::uint64_t{row[0]} * 32;
    const auto put = [&](std::uint32_t code, unsigned width) {
      if (width == 0) return;
      const auto shift = static_cast<unsigned>(bit & 31);
      words[bit >> 5] |= code << shift;
      if (shift + width > 32) words[(bit >> 5) + 1] |= code >> (32 - shift);
      bit += width;
    };
    for (std::uint64_t b = 0; b < blocks && record > 0; ++b) {
      if (part.dc_bits > 0) put(part.dc[b], part.dc_bits);
      for (unsigned p = 0; p < scheme.books; ++p) {
        if (!part.codes[p].empty()) put(part.codes[p][b], encoding.books[set].books[p].bits());
      }
    }
    std::ranges::copy(row, words.begin() + static_cast<std::ptrdiff_t>(s * kRow));
  }
  words.push_back(0);
  words.push_back(0);
  return words;
}

shaders::TvqDomain shader_domain(const Domain& domain) {
  // Halves of the exponent, so that neither factor is a denormal or infinite.
  const int exponent = domain.exponent - static_cast<int>(domain.fraction), half = exponent / 2;
  return {domain.fraction,
          domain.zero,
          domain.low,
          domain.high,
          domain.offset,
          std::ldexp(1.0f, half),
          std::ldexp(1.0f, exponent - half)};
}

/// Reads the fields of one record.
class Record {
 public:
  Record(const std::uint32_t* words, std::uint64_t bit)
      : words_(words + (bit >> 5)), bit_(static_cast<unsigned>(bit & 31)) {}
  std::uint32_t next(unsigned width) {
    std::uint64_t pair;
    std::memcpy(&pair, words_ + (bit_ >> 5), sizeof pair);
    const auto field = static_cast<std::uint32_t>(pair >> (bit_ & 31)) & ((1u << width) - 1u);
    bit_ += width;
    return field;
  }

 private:
  const std::uint32_t* words_;
  unsigned bit_;
};

/// Adds up one block. Books that are not there point to zeros.
template <class T>
inline void add_block(T dc, const T* a, const T* b, const T* c, T* sums) {
  for (unsigned i = 0; i < kBlockVoxels; ++i)
    sums[i] = static_cast<T>(static_cast<T>(dc + a[i]) + static_cast<T>(b[i] + c[i]));
}

inline void finish_block(const shaders::TvqDomain& domain, const std::int16_t* sums,
                         std::uint8_t* voxels) {
#ifdef CVR_TVQ_AVX2
  const auto half = static_cast<short>(1u << domain.fraction >> 1);
  const __m256i rounding = _mm256_set1_epi16(half),
                zero = _mm256_set1_epi16(static_cast<short>(domain.zero));
  const __m256i low = _mm256_set1_epi16(static_cast<short>(domain.low)),
                high = _mm256_set1_epi16(static_cast<short>(domain.high));
  const __m128i shift = _mm_cvtsi32_si128(static_cast<int>(domain.fraction));
  const auto value = [&](unsigned i) {
    const __m256i sum = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(sums + i));
    const __m256i whole = _mm256_sra_epi16(_mm256_adds_epi16(sum, rounding), shift);
    return _mm256_min_epi16(_mm256_max_epi16(_mm256_add_epi16(whole, zero), low), high);
  };
  for (unsigned i = 0; i < kBlockVoxels; i += 32) {
    const __m256i packed = _mm256_packus_epi16(value(i), value(i + 16));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(voxels + i),
                        _mm256_permute4x64_epi64(packed, 0xd8));
  }
#else
  for (unsigned i = 0; i < kBlockVoxels; ++i)
    voxels[i] = static_cast<std::uint8_t>(shaders::cvr_tvq_integer(domain, sums[i]));
#endif
}
template <class T>
inline void finish_block(const shaders::TvqDomain& domain, const std::int32_t* sums, T* voxels) {
  for (unsigned i = 0; i < kBlockVoxels; ++i) {
    if constexpr (std::is_same_v<T, float>) {
      voxels[i] = shaders::cvr_tvq_float(domain, sums[i]);
    } else {
      voxels[i] = static_cast<T>(shaders::cvr_tvq_integer(domain, sums[i]));
    }
  }
}

class BlockDecoder final : public codecs::Decoder, public VoxelAccess, public ProgressiveAccess {
 public:
  BlockDecoder(const Scheme& scheme, const VolumeInfo& info, const Encoding& encoding,
               std::vector<std::uint32_t> words, const StepBytes& steps)
      : scheme_(scheme),
        info_(info),
        domain_(shader_domain(encoding.domain)),
        edge_(encoding.edge),
        step_(info.step_extent()),
        grid_(encoding.grid(step_)),
        error_(encoding.error),
        exceptions_(encoding.exceptions),
        exception_bits_(encoding.exception_bits),
        words_(std::move(words)),
        steps_(steps) {
    std::int64_t largest = 0;  // of any sum, with its rounding
    for (std::size_t i = 0; i < encoding.parts.size(); ++i) {
      const SubVolume& part = encoding.parts[i];
      const std::int64_t first = part.dc_base,
                         last = first + ((std::int64_t{1} << part.dc_bits) - 1) * part.dc_step;
      std::int64_t sum = std::max(std::abs(first), std::abs(last));
      for (unsigned p = 0; p < scheme.books; ++p) {
        const Book& book = encoding.books_of(i).books[p];
        int most = 0;
        for (const std::int16_t entry : book.entries) most = std::max(most, std::abs(int{entry}));
        sum += std::int64_t{most} * book.scale;
      }
      largest = std::max(largest, sum);
      blocks_.push_back(part.blocks);
    }
    narrow_ = info.type == VoxelType::kU8 && largest + (1 << domain_.fraction) <= 32767;
    for (std::uint64_t b = 0, run = 0; run < exceptions_.size(); b += exceptions_[run++].count)
      exception_at_.push_back(b);
    if (narrow_) {
      make_tables(encoding, narrow_tables_);
    } else {
      make_tables(encoding, wide_tables_);
    }
  }

  const VoxelAccess* voxel_access() const override { return this; }
  const ProgressiveAccess* progressive_access() const override {
    return scheme_.dc ? this : nullptr;
  }
  std::optional<RecordedError> recorded_error() const override { return error_; }

  unsigned steps() const override { return scheme_.books + 1; }
  std::string_view step_name(unsigned step) const override { return scheme_.steps[step]; }
  std::uint64_t step_bytes(unsigned step) const override { return steps_[step]; }

  /// With one sub-volume the row stands in constants: a device then reads the record and one entry
  /// a book. A device knows a stack of cubes and no time: a series is refused (kUnsupported) unless
  /// its steps begin where such cubes do.
  Expected<GpuSamples> gpu_samples(unsigned step) const override {
    if (scheme_.dc ? step > scheme_.books : step != 0)
      return fail(ErrorCode::kBadArgument, fmt::format("step: expected 0..{}, found {}",
                                                       scheme_.dc ? scheme_.books : 0, step));
    if (info_.extent.x > UINT32_MAX || info_.extent.y > UINT32_MAX || info_.extent.z > UINT32_MAX)
      return fail(ErrorCode::kUnsupported, "an axis exceeds 2^32 voxels");
    const std::optional<std::uint32_t> edge = device_edge();
    if (!edge) {
      return fail(ErrorCode::kUnsupported,
                  fmt::format("time steps of {} voxels with edge={}: a device finds sub-volumes "
                              "where edges divide the depth of a step, or "
                              "where that is a multiple of 4 and no step is wider or higher",
                              to_string(step_), edge_));
    }
    GpuSamples samples{.decoder = "tvq", .constants = {}, .buffers = {}};
    const auto constant = [&](std::string name, std::uint32_t value) {
      samples.constants.emplace_back("CVR_TVQ_" + std::move(name), value);
    };
    constant("READ", scheme_.dc ? step : scheme_.books);
    constant("EDGE", *edge);
    constant("FLOAT", info_.type == VoxelType::kF32 ? 1 : 0);
    constant("FRACTION", domain_.fraction);
    constant("ZERO", static_cast<std::uint32_t>(domain_.zero));
    constant("LOW", static_cast<std::uint32_t>(domain_.low));
    constant("HIGH", static_cast<std::uint32_t>(domain_.high));
    constant("OFFSET", std::bit_cast<std::uint32_t>(domain_.offset));
    constant("STEP_A", std::bit_cast<std::uint32_t>(domain_.step_a));
    constant("STEP_B", std::bit_cast<std::uint32_t>(domain_.step_b));
    for (std::uint32_t k = 0; *edge == 0 && k < kRow; ++k)
      constant(fmt::format("ROW_{}", k), words_[k]);
    samples.buffers.push_back({"blocks and books", std::as_bytes(std::span(words_)), nullptr});
    return samples;
  }

  Expected<void> decode(unsigned, unsigned threads, SlabSink& sink) const override {
    return decode_step(scheme_.books, threads, sink);
  }

  Expected<void> decode_step(unsigned step, unsigned threads, SlabSink& sink) const override {
    if (step > scheme_.books)
      return fail(ErrorCode::kBadArgument,
                  fmt::format("step: expected 0..{}, found {}", scheme_.books, step));
    const std::uint64_t rows = (step_.y + kBlockEdge - 1) / kBlockEdge,
                        layers = layers_of_step() * info_.time_steps;
    for (std::uint64_t l0 = 0; l0 < layers;) {
      const std::uint64_t z0 = layer(l0).z;
      std::uint64_t l1 = l0 + 1;
      while (l1 < layers && layer(l1).end() - z0 <= sink.preferred_depth()) ++l1;
      const std::uint64_t z1 = layer(l1 - 1).end();
      std::byte* out = sink.begin(z0, z1);
      volumes::parallel_for(threads, (l1 - l0) * rows, [&](unsigned, std::uint64_t i) {
        decode_row(layer(l0 + i / rows), i % rows * kBlockEdge, z0, step, out);
      });
      restore_exceptions(z0, z1, reinterpret_cast<std::uint32_t*>(out));
      sink.end(z0, z1);
      l0 = l1;
    }
    return {};
  }

  Expected<void> at(std::span<const Coordinate> points, unsigned lod,
                    std::span<std::uint64_t> labels) const override {
    if (lod != 0)
      return fail(ErrorCode::kBadArgument,
                  fmt::format("level of detail: expected 0, found {}", lod));
    const shaders::Words words{words_.data()};
    for (std::size_t n = 0; n < points.size(); ++n) {
      const Coordinate& c = points[n];
      Coordinate inside{c.x, c.y, c.z % step_.z};
      std::uint64_t part = c.z / step_.z * grid_.voxels();
      if (edge_ > 0) {
        part += grid_.index({inside.x / edge_, inside.y / edge_, inside.z / edge_});
        inside = {inside.x % edge_, inside.y % edge_, inside.z % edge_};
      }
      const std::uint64_t block = blocks_[part].index(
          {inside.x / kBlockEdge, inside.y / kBlockEdge, inside.z / kBlockEdge});
      const auto i =
          static_cast<std::uint32_t>((inside.x & 3) + 4 * (inside.y & 3) + 16 * (inside.z & 3));
      const shaders::TvqRow row =
          shaders::cvr_tvq_row(words, static_cast<std::uint32_t>(part * kRow));
      const int sum = shaders::cvr_tvq_sum(words, row, block, i, kMaxBooks);
      switch (info_.type) {
        case VoxelType::kF32:
          labels[n] =
              std::bit_cast<std::uint32_t>(exception_or(c, shaders::cvr_tvq_float(domain_, sum)));
          break;
        case VoxelType::kI16:
          labels[n] = static_cast<std::uint16_t>(shaders::cvr_tvq_integer(domain_, sum));
          break;
        default:
          labels[n] = static_cast<std::uint32_t>(shaders::cvr_tvq_integer(domain_, sum));
          break;
      }
    }
    return {};
  }

 private:
  /// Up to four planes of a time step that blocks lie in.
  struct Layer {
    std::uint64_t step;
    std::uint64_t in_step;  ///< the first plane, counted from that of its step
    std::uint64_t z;        ///< the first plane, of the stack
    std::uint64_t planes;
    std::uint64_t end() const { return z + planes; }
  };
  std::uint64_t layers_of_step() const { return (step_.z + kBlockEdge - 1) / kBlockEdge; }
  Layer layer(std::uint64_t i) const {
    const std::uint64_t step = i / layers_of_step(), in_step = i % layers_of_step() * kBlockEdge;
    return {step, in_step, step * step_.z + in_step,
            std::min<std::uint64_t>(kBlockEdge, step_.z - in_step)};
  }

  /// The edge of cubes that cut the whole stack into its sub-volumes; 0 where there is but one;
  /// none where cubes cannot.
  std::optional<std::uint32_t> device_edge() const {
    if (info_.time_steps == 1) return edge_;
    if (edge_ > 0 && step_.z % edge_ == 0) return edge_;
    const bool columns = grid_.voxels() == 1 && step_.z % kBlockEdge == 0 && step_.x <= step_.z &&
                         step_.y <= step_.z;
    return columns ? std::optional(static_cast<std::uint32_t>(step_.z)) : std::nullopt;
  }

  template <class T>
  void make_tables(const Encoding& encoding, std::vector<Table<T>>& tables) {
    for (const BookSet& set : encoding.books) {
      Table<T>& table = tables.emplace_back();
      for (unsigned p = 0; p < scheme_.books; ++p) {
        const Book& book = set.books[p];
        table.books[p].resize(std::size_t{book.size} * kBlockVoxels);
        for (std::size_t i = 0; i < table.books[p].size(); ++i) {
          const std::size_t entry = scheme_.length[p] == 8 ? i / 64 * 8 + (i >> 1 & 1) +
                                                                 2 * (i >> 3 & 1) + 4 * (i >> 5 & 1)
                                                           : i;
          table.books[p][i] = static_cast<T>(book.entries[entry] * book.scale);
        }
      }
    }
  }

  void decode_row(const Layer& layer, std::uint64_t y, std::uint64_t z0, unsigned step,
                  std::byte* out) const {
    switch (info_.type) {
      case VoxelType::kU16:
        return decode_typed<std::int32_t, std::uint16_t>(wide_tables_, layer, y, z0, step, out);
      case VoxelType::kI16:
        return decode_typed<std::int32_t, std::int16_t>(wide_tables_, layer, y, z0, step, out);
      case VoxelType::kF32:
        return decode_typed<std::int32_t, float>(wide_tables_, layer, y, z0, step, out);
      default:
        if (narrow_)
          return decode_typed<std::int16_t, std::uint8_t>(narrow_tables_, layer, y, z0, step, out);
        return decode_typed<std::int32_t, std::uint8_t>(wide_tables_, layer, y, z0, step, out);
    }
  }

  /// The blocks of one row along x that begin at y of a layer; z0 is the first plane of `out`.
  template <class S, class T>
  void decode_typed(const std::vector<Table<S>>& tables, const Layer& layer, std::uint64_t y,
                    std::uint64_t z0, unsigned step, std::byte* out) const {
    static constexpr std::array<S, kBlockVoxels> kNothing{};
    const Extent& e = info_.extent;
    T* voxels = reinterpret_cast<T*>(out);
    const std::uint64_t z = layer.z, depth = layer.planes,
                        height = std::min<std::uint64_t>(kBlockEdge, e.y - y);
    for (std::uint64_t px = 0; px < grid_.x; ++px) {
      const std::uint64_t part =
          layer.step * grid_.voxels() +
          (edge_ == 0 ? 0 : grid_.index({px, y / edge_, layer.in_step / edge_}));
      const Table<S>& table = tables[part % tables.size()];
      const std::uint32_t* row = words_.data() + part * kRow;
      const std::uint64_t local_y = edge_ == 0 ? y : y % edge_,
                          local_z = edge_ == 0 ? layer.in_step : layer.in_step % edge_;
      const Extent& blocks = blocks_[part];
      std::uint64_t bit = std::uint64_t{row[0]} * 32 +
                          blocks.index({0, local_y / kBlockEdge, local_z / kBlockEdge}) * row[1];
      const bool present[kMaxBooks] = {step > 0 && (row[8] & 4) == 0,
                                       step > 1 && (row[12] & 4) == 0,
                                       step > 2 && (row[16] & 4) == 0};
      const auto base = static_cast<std::int32_t>(row[3]);
      for (std::uint64_t bx = 0; bx < blocks.x; ++bx, bit += row[1]) {
        Record record(words_.data(), bit);
        const auto dc =
            static_cast<S>(base + static_cast<std::int32_t>(record.next(row[2]) * row[4]));
        const S* entries[kMaxBooks];
        for (unsigned p = 0; p < kMaxBooks; ++p) {
          const std::uint32_t code = record.next(row[5 + 4 * p]);
          entries[p] = present[p] ? table.books[p].data() + std::size_t{code} * kBlockVoxels
                                  : kNothing.data();
        }
        alignas(32) S sums[kBlockVoxels];
        alignas(32) T block[kBlockVoxels];
        add_block<S>(dc, entries[0], entries[1], entries[2], sums);
        finish_block(domain_, sums, block);
        const std::uint64_t x = (edge_ == 0 ? 0 : px * edge_) + bx * kBlockEdge;
        const std::uint64_t width = std::min<std::uint64_t>(kBlockEdge, e.x - x);
        T* to = voxels + e.index({x, y, z - z0});
        for (std::uint64_t k = 0; k < depth; ++k) {
          for (std::uint64_t j = 0; j < height; ++j) {
            T* line = to + e.x * (j + e.y * k);
            const T* from = block + 4 * j + 16 * k;
            if (width == kBlockEdge) {
              std::memcpy(line, from, kBlockEdge * sizeof(T));
            } else {
              std::memcpy(line, from, width * sizeof(T));
            }
          }
        }
      }
    }
  }

  /// The first run that ends at a voxel or later.
  std::size_t run_from(std::uint64_t voxel) const {
    const auto last = [](const ExceptionRun& run) { return run.first + run.count - 1; };
    return static_cast<std::size_t>(std::ranges::lower_bound(exceptions_, voxel, {}, last) -
                                    exceptions_.begin());
  }

  float exception_or(const Coordinate& c, float value) const {
    if (exceptions_.empty()) return value;
    const std::uint64_t voxel = info_.extent.index(c);
    const std::size_t run = run_from(voxel);
    if (run == exceptions_.size() || exceptions_[run].first > voxel) return value;
    return std::bit_cast<float>(
        exception_bits_[exception_at_[run] + voxel - exceptions_[run].first]);
  }

  void restore_exceptions(std::uint64_t z0, std::uint64_t z1, std::uint32_t* out) const {
    if (exceptions_.empty()) return;
    const std::uint64_t plane = info_.extent.x * info_.extent.y, begin = z0 * plane,
                        end = z1 * plane;
    for (std::size_t run = run_from(begin);
         run < exceptions_.size() && exceptions_[run].first < end; ++run) {
      const std::uint64_t first = std::max(begin, exceptions_[run].first),
                          last = std::min(end, exceptions_[run].first + exceptions_[run].count);
      std::memcpy(out + (first - begin),
                  exception_bits_.data() + exception_at_[run] + (first - exceptions_[run].first),
                  (last - first) * sizeof(float));
    }
  }

  const Scheme& scheme_;
  VolumeInfo info_;
  shaders::TvqDomain domain_;
  std::uint32_t edge_;
  Extent step_;  ///< of a time step
  Extent grid_;  ///< of the sub-volumes of a time step
  RecordedError error_;
  std::vector<ExceptionRun> exceptions_;
  std::vector<std::uint32_t> exception_bits_;
  std::vector<std::uint64_t> exception_at_;  ///< the first of each run in exception_bits_
  std::vector<std::uint32_t> words_;
  StepBytes steps_;
  std::vector<Extent> blocks_;  ///< of each sub-volume
  bool narrow_ = false;         ///< all sums fit 16 bits
  std::vector<Table<std::int16_t>> narrow_tables_;
  std::vector<Table<std::int32_t>> wide_tables_;
};

}  // namespace

Expected<std::unique_ptr<Decoder>> make_decoder(const Scheme& scheme, const VolumeInfo& info,
                                                const Encoding& encoding, const StepBytes& steps) {
  auto words = make_image(scheme, encoding);
  if (!words) return fail(ErrorCode::kTooLarge, "books and records exceed 2^32 words");
  return std::make_unique<BlockDecoder>(scheme, info, encoding, std::move(*words), steps);
}

Expected<std::unique_ptr<Decoder>> open(const Scheme& scheme, const Stream& stream) {
  StepBytes steps{};
  auto encoding = read_payload(scheme, stream.info, stream.payload, steps);
  if (!encoding) return tl::unexpected(encoding.error());
  return make_decoder(scheme, stream.info, *encoding, steps);
}

}  // namespace cvr::codecs::tvq
