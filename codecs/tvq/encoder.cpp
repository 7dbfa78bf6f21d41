#include "codecs/tvq/encoder.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cvr::codecs::tvq {

namespace {

constexpr unsigned kLeastDcBits = 6;
constexpr unsigned kMostAllocated = 12;  // bits of a book that the allocation considers
constexpr double kTauOfTarget = 0.7;

/// Means of the eight octants of a block, minus `mean`.
std::array<float, 8> octants(const float* block, float mean) {
  std::array<double, 8> sums{};
  for (unsigned i = 0; i < kBlockVoxels; ++i) sums[(i >> 1 & 1) + 2 * (i >> 3 & 1) + 4 * (i >> 5 & 1)] += static_cast<double>(block[i]);
  std::array<float, 8> means;
  for (unsigned j = 0; j < 8; ++j) means[j] = static_cast<float>(sums[j] / 8 - static_cast<double>(mean));
  return means;
}
unsigned octant_of(unsigned i) { return (i >> 1 & 1) + 2 * (i >> 3 & 1) + 4 * (i >> 5 & 1); }

std::vector<double> block_means(std::span<const float> samples) {
  std::vector<double> means(samples.size() / kBlockVoxels);
  for (std::size_t b = 0; b < means.size(); ++b) {
    double sum = 0;
    for (unsigned i = 0; i < kBlockVoxels; ++i) sum += static_cast<double>(samples[b * kBlockVoxels + i]);
    means[b] = sum / kBlockVoxels;
  }
  return means;
}

struct DcLattice {
  unsigned bits;
  std::int32_t base;
  std::uint32_t step;
};

/// The finest lattice of that many bits that holds all means (in units) and the zero block.
DcLattice dc_lattice(const Domain& domain, std::span<const double> means, unsigned bits) {
  const double units = units_of(domain);
  const auto [least, most] = std::ranges::minmax_element(means);
  const auto low = static_cast<std::int64_t>(std::llround(*least * units)), high = static_cast<std::int64_t>(std::llround(*most * units));
  if (low == high && low == 0) return {0, 0, 0};
  std::int64_t step;
  if (domain.type == VoxelType::kU8 && bits >= 8) {
    step = 1 << domain.fraction;  // whole grey levels, so that flat blocks are exact
  } else if (low == high) {
    return {0, static_cast<std::int32_t>(low), 0};
  } else {
    const std::int64_t steps = std::max<std::int64_t>((std::int64_t{1} << bits) - 3, 1);
    step = std::max<std::int64_t>((high - low + steps - 1) / steps, 1);
  }
  const std::int64_t first = low >= 0 ? low / step : -((-low + step - 1) / step);
  const auto last = static_cast<std::uint64_t>(std::llround(static_cast<double>(high) / static_cast<double>(step)) - first);
  return {std::min<unsigned>(static_cast<unsigned>(std::bit_width(last)), kMaxDcBits), static_cast<std::int32_t>(first * step),
          static_cast<std::uint32_t>(step)};
}

double dc_error(const DcLattice& lattice, const Domain& domain) {
  const double step = lattice.bits == 0 ? 0 : lattice.step / units_of(domain);
  return step * step / 12;
}

void code_dc(const Domain& domain, std::span<const double> means, SubVolume& part) {
  part.dc.clear();
  if (part.dc_bits == 0) return;
  const double units = units_of(domain);
  const double most = static_cast<double>((1u << part.dc_bits) - 1);
  for (const double mean : means) {
    const double code = std::floor((mean * units - part.dc_base) / part.dc_step + 0.5);
    part.dc.push_back(static_cast<std::uint16_t>(std::clamp(code, 0.0, most)));
  }
}

float dc_value(const Domain& domain, const SubVolume& part, std::size_t block) {
  const std::int64_t units = part.dc_base + (part.dc_bits == 0 ? 0 : std::int64_t{part.dc[block]} * part.dc_step);
  return static_cast<float>(static_cast<double>(units) / units_of(domain));
}

/// Units an entry, so that entries up to `largest` samples fit.
double entry_scale(const Domain& domain, double largest, double limit) {
  return std::max(1.0, std::ceil(largest * units_of(domain) / limit));
}

/// One byte an entry where its rounding costs less than 2 % of the error; for u8 always.
unsigned entry_bytes(const Domain& domain, double largest, double error) {
  const double scale = entry_scale(domain, largest, 127), rounding = scale / units_of(domain);
  return domain.type == VoxelType::kU8 || (scale <= 65535 && rounding * rounding / 12 <= 0.02 * error) ? 1 : 2;
}

void choose_entries(const Domain& domain, double largest, double error, Book& book) {
  book.entry_bytes = static_cast<std::uint8_t>(entry_bytes(domain, largest, error));
  book.scale = static_cast<std::uint16_t>(std::min(entry_scale(domain, largest, book.entry_bytes == 1 ? 127 : 32767), 65535.0));
}

/// The step of coefficients that costs 1 % of the error, in samples.
double coefficient_step(unsigned dimensions, double error) { return std::sqrt(0.12 * error * kBlockVoxels / dimensions); }

double largest_of(const CodeVectors& book) {
  double largest = 0;
  for (const float value : book.values) largest = std::max(largest, std::abs(static_cast<double>(value)));
  return largest;
}

/// Rounds code vectors of samples to entries; `code_vectors` become what the entries say.
void quantise_entries(const Domain& domain, double error, CodeVectors& code_vectors, Book& book) {
  const double units = units_of(domain);
  choose_entries(domain, largest_of(code_vectors), error, book);
  const double limit = book.entry_bytes == 1 ? 127 : 32767;
  book.size = code_vectors.size();
  book.step = 0;
  book.entries.clear();
  for (float& value : code_vectors.values) {
    const double entry = std::clamp(std::floor(static_cast<double>(value) * units / book.scale + 0.5), -limit, limit);
    book.entries.push_back(static_cast<std::int16_t>(entry));
    value = static_cast<float>(entry * book.scale / units);
  }
}

/// Rounds code vectors of coefficients, so finely that it costs 1 % of the error, and projects them; `code_vectors` become what the
/// coefficients say.
void quantise_coefficients(const Domain& domain, unsigned partition, const Basis& basis, double error, bool keep, CodeVectors& code_vectors,
                           Book& book) {
  const double per_sample = units_of(domain) * 256;
  const unsigned n = kPartitionSize[partition];
  double step = coefficient_step(n, error) * per_sample;
  step = std::max(step, largest_of(code_vectors) * per_sample / 32767);
  book.step = static_cast<std::uint32_t>(std::clamp(std::ceil(step), 1.0, static_cast<double>(kLargestStep)));
  book.size = code_vectors.size();
  book.coefficients.clear();
  for (float& value : code_vectors.values) {
    const double c = std::clamp(std::floor(static_cast<double>(value) * per_sample / book.step + 0.5), -32767.0, 32767.0);
    book.coefficients.push_back(static_cast<std::int16_t>(c));
    value = static_cast<float>(c * book.step / per_sample);
  }
  double largest = 0;
  for (std::uint32_t k = 0; k < code_vectors.size(); ++k) {
    std::array<float, kBlockVoxels> wide{};
    std::copy_n(code_vectors[k], n, wide.data() + kPartitionBegin[partition]);
    for (const float value : basis.inverse(wide)) largest = std::max(largest, std::abs(static_cast<double>(value)));
  }
  choose_entries(domain, largest, error, book);
  project(book, partition, basis);
  if (keep) return;
  book.coefficients.clear();
  book.step = 0;
}

double mean_energy(const Vectors& vectors) {
  double sum = 0;
  for (std::uint64_t n = 0; n < vectors.count; ++n) {
    for (unsigned j = 0; j < vectors.dimensions; ++j) sum += static_cast<double>(vectors[n][j]) * static_cast<double>(vectors[n][j]);
  }
  return sum / static_cast<double>(vectors.count);
}

/// What the allocation needs to know of a book.
struct Candidate {
  Vectors vectors;
  double weight;      ///< voxels that a unit of squared distance stands for
  unsigned length;    ///< entries of a code vector on a device
  bool coefficients;  ///< whether the file stores these
};

/// About the bits of a code vector where books are counted, when the blocks that use it have that mean squared error.
double vector_bits(const Domain& domain, const Candidate& candidate, double error, bool device) {
  const Vectors& v = candidate.vectors;
  std::vector<double> squares(v.dimensions, 0.0);
  double largest = 0;
  std::uint64_t active = 0;
  for (std::uint64_t n = 0; n < v.count; ++n) {
    double energy = 0;
    for (unsigned j = 0; j < v.dimensions; ++j) {
      const double value = static_cast<double>(v[n][j]);
      squares[j] += value * value;
      energy += value * value;
      largest = std::max(largest, std::abs(value));
    }
    active += energy > 0 ? 1u : 0u;
  }
  if (device || !candidate.coefficients) return candidate.length * 8.0 * entry_bytes(domain, largest, error);
  // The entropy of a rounded normal variable, and what it takes to tell the sizes apart.
  const double step = coefficient_step(v.dimensions, error);
  double bits = 0;
  for (const double s : squares)
    bits += s > 0 && step > 0 ? std::max(1.0, 0.5 * std::log2(s / static_cast<double>(active)) - std::log2(step) + 2.5) : 1.0;
  return bits;
}

struct Bits {
  unsigned dc;
  std::array<unsigned, kMaxBooks> books{};
  double error = 0;         ///< expected mean squared error, samples
  double active_error = 0;  ///< the same over the blocks that have more than DC
};

/// Distortion by bits of a code, over all blocks.
std::vector<double> distortion_curve(const Candidate& candidate, const Options& options, unsigned threads) {
  const std::uint64_t count = candidate.vectors.count;
  const auto most = std::min(options.best ? kMaxBookBits - 1 : kMostAllocated, static_cast<unsigned>(std::bit_width(count)));
  std::vector<double> curve;
  if (options.operational) {
    curve = measured_curve(candidate.vectors, most, options, threads);
  } else {
    // The paper's model has no bound; a book cannot have more code vectors than an eighth of its training vectors.
    const auto cap = static_cast<unsigned>(std::bit_width(std::max<std::uint64_t>(count / 8, 1)) - 1);
    curve = model_curve(candidate.vectors.dimensions, mean_energy(candidate.vectors) / candidate.vectors.dimensions,
                        static_cast<double>(count), std::min(most, cap));
  }
  for (double& d : curve) d *= candidate.weight;
  return curve;
}

/// What a book of 2^bits code vectors loses, from the splits of a small sample.
double rough_distortion(const Candidate& candidate, unsigned bits, unsigned threads) {
  const std::vector<std::uint32_t> active = sample_active(candidate.vectors, candidate.vectors.count),
                                   sample = sample_active(candidate.vectors, 8192);
  if (sample.empty()) return 0;
  const unsigned d = candidate.vectors.dimensions;
  const std::vector<float> values = gather(candidate.vectors, sample, 0, d);
  const Vectors training{values.data(), sample.size(), d, d};
  const CodeVectors book = SplitTree(training, 1u << bits).codebook(1u << bits);
  std::vector<std::uint16_t> codes(sample.size());
  find_nearest(book, training, codes, threads);
  return candidate.weight * total_distortion(book, training, codes, threads) / static_cast<double>(sample.size()) *
         static_cast<double>(active.size());
}

/// Bits of DC and books by `rate`, or as they are given.
Bits allocate(const Scheme& scheme, const Domain& domain, std::span<const double> means, std::span<const Candidate> candidates,
              double budget, const Options& options, unsigned threads) {
  const double blocks = static_cast<double>(means.size()), voxels = blocks * kBlockVoxels;
  const bool dc_free = scheme.dc && options.dc_bits == 0 && domain.type != VoxelType::kU8;
  Bits bits{!scheme.dc ? 0 : options.dc_bits != 0 ? options.dc_bits : 8, {}, 0, 0};
  std::uint64_t active = 1;
  for (const Candidate& c : candidates) active = std::max<std::uint64_t>(active, sample_active(c.vectors, c.vectors.count).size());
  const auto dc_distortion = [&](unsigned dc) { return voxels * dc_error(dc_lattice(domain, means, dc), domain); };
  const auto set_error = [&](double distortion) {
    bits.error = distortion / voxels;
    bits.active_error = distortion / (static_cast<double>(active) * kBlockVoxels);
  };
  if (options.rate <= 0) {
    double distortion = 0;
    for (unsigned p = 0; p < scheme.books; ++p) {
      bits.books[p] = options.bits[p];
      distortion += rough_distortion(candidates[p], bits.books[p], threads);
    }
    set_error(distortion);
    if (dc_free) {
      for (bits.dc = kLeastDcBits; bits.dc < kMaxDcBits && dc_distortion(bits.dc) > 0.05 * distortion; ++bits.dc) {
      }
    }
    return bits;
  }
  std::vector<BitCurve> curves;
  for (const Candidate& c : candidates) {
    curves.push_back({0, distortion_curve(c, options, threads), {}});
    set_error(bits.error * voxels + curves.back().distortion.back());
  }
  if (scheme.dc) {
    BitCurve& curve = curves.emplace_back();
    curve.first = dc_free ? kLeastDcBits : bits.dc;
    for (unsigned b = curve.first; b <= (dc_free ? 14u : bits.dc); ++b) curve.distortion.push_back(dc_distortion(b));
    curve.book_bits.assign(curve.distortion.size(), 0.0);
  }
  // What a code vector takes depends on the error, which depends on the bits: after a first guess the dearer of two estimates.
  std::array<double, kMaxBooks> dearest{};
  for (unsigned pass = 0; pass < 3; ++pass) {
    for (unsigned p = 0; p < scheme.books; ++p) {
      const double each = std::max(vector_bits(domain, candidates[p], bits.active_error, options.count_device), dearest[p]);
      if (pass > 0) dearest[p] = each;
      curves[p].book_bits.clear();
      for (unsigned b = 0; b < curves[p].distortion.size(); ++b) curves[p].book_bits.push_back(b == 0 ? 0 : std::exp2(b) * each);
    }
    const std::vector<unsigned> chosen = choose_bits(curves, blocks, budget);
    double distortion = 0;
    for (std::size_t p = 0; p < curves.size(); ++p) distortion += curves[p].distortion[chosen[p] - curves[p].first];
    set_error(distortion);
    std::copy_n(chosen.begin(), scheme.books, bits.books.begin());
    if (scheme.dc) bits.dc = chosen[scheme.books];
  }
  return bits;
}

std::vector<std::uint8_t> classes_of(std::span<const float> coefficients, double tau) {
  std::vector<std::uint8_t> classes(coefficients.size() / kBlockVoxels);
  for (std::size_t b = 0; b < classes.size(); ++b) {
    classes[b] = static_cast<std::uint8_t>(classify(zone_energies(coefficients.data() + b * kBlockVoxels), tau * tau));
  }
  return classes;
}

/// The error of books on some blocks when the classes lose at most tau.
double error_at(std::span<const float> coefficients, double tau, const Bits& bits, const Options& options, unsigned threads) {
  const std::vector<std::uint8_t> classes = classes_of(coefficients, tau);
  const ClassifiedBooks trained = train_chapters(coefficients, classes, bits.books, options, threads);
  double sum = 0;
  for (unsigned p = 0; p < kPartitions; ++p) {
    std::vector<std::uint16_t> codes =
        assign_codes(trained.books[p], trained.chapters[p], p, coefficients, classes, options.global, threads);
    codes.resize(classes.size());
    sum += total_distortion(trained.books[p], partition_vectors(coefficients, p), codes, threads);
  }
  return sum;
}

double choose_tau(const Domain& domain, std::span<const float> coefficients, const Bits& bits, const Options& options, unsigned threads) {
  const double range = domain.type == VoxelType::kU8
                           ? 255
                           : static_cast<double>(domain.high - domain.low) / (domain.type == VoxelType::kF32 ? units_of(domain) : 1);
  const double target = options.psnr > 0 ? range * std::pow(10.0, -options.psnr / 20) : std::sqrt(bits.error);
  if (options.tau > 0) return options.tau * target;
  if (options.psnr > 0) return kTauOfTarget * target;
  const std::uint64_t blocks = coefficients.size() / kBlockVoxels, most = options.best ? 32768 : 8192;
  const Vectors whole{coefficients.data(), blocks, kBlockVoxels, kBlockVoxels};
  const std::vector<float> sample = gather(whole, sample_active(whole, most), 0, kBlockVoxels);
  if (sample.empty()) return target;
  double best = target, least = -1;
  for (const double factor : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    Options quick = options;
    quick.best = false;
    quick.rough = true;
    const double error = error_at(sample, factor * target, bits, quick, threads);
    if (least < 0 || error < least) least = error, best = factor * target;
  }
  return best;
}

void flip_every_second(Basis& basis) {
  std::vector<std::int16_t> stored(basis.stored().begin(), basis.stored().end());
  const std::size_t row = basis.kind() == TransformKind::kKltFull ? kBlockVoxels : 4;
  for (std::size_t i = 0; i < stored.size(); ++i) {
    if (i / row % 2 == 1) stored[i] = static_cast<std::int16_t>(-stored[i]);
  }
  basis = Basis(basis.kind(), stored);
}

void train_tvq(const Domain& domain, std::span<const double> means, std::vector<float> samples, double budget, const Options& options,
               SubVolume& part, unsigned threads) {
  part.basis = Basis::fit(options.transform, samples, threads);
  if (options.flip_signs) flip_every_second(part.basis);
  part.basis.forward(samples, threads);
  const std::span<const float> coefficients(samples);
  std::vector<Candidate> candidates;
  for (unsigned p = 0; p < kPartitions; ++p) {
    candidates.push_back({partition_vectors(coefficients, p), 1, kBlockVoxels, options.coefficients});
  }
  const Bits bits = allocate(kTvq, domain, means, candidates, budget, options, threads);
  const DcLattice lattice = dc_lattice(domain, means, bits.dc);
  part.dc_bits = lattice.bits, part.dc_base = lattice.base, part.dc_step = lattice.step;
  code_dc(domain, means, part);

  ClassifiedBooks trained;
  std::vector<std::uint8_t> classes;
  if (options.classify) {
    classes = classes_of(coefficients, choose_tau(domain, coefficients, bits, options, threads));
    trained = train_chapters(coefficients, classes, bits.books, options, threads);
  } else {
    for (unsigned p = 0; p < kPartitions; ++p) {
      trained.books[p] = train_book(candidates[p].vectors, bits.books[p], options, options.seed * 64 + p, threads);
    }
  }
  for (unsigned p = 0; p < kPartitions; ++p) {
    Book& book = part.books[p];
    quantise_coefficients(domain, p, part.basis, bits.active_error, options.coefficients, trained.books[p], book);
    book.chapters = trained.chapters[p];
    part.codes[p] =
        assign_codes(trained.books[p], trained.chapters[p], p, coefficients, classes, options.global || !options.classify, threads);
  }
}

void code_nearest(const CodeVectors& book, const Vectors& vectors, std::vector<std::uint16_t>& codes, unsigned threads) {
  codes.clear();
  if (book.size() == 1) return;
  codes.resize(vectors.count);
  find_nearest(book, vectors, codes, threads);
}

void train_hvq(const Domain& domain, std::span<const double> means, std::span<const float> samples, double budget, const Options& options,
               SubVolume& part, unsigned threads) {
  const std::size_t blocks = means.size();
  const auto code_levels = [&](unsigned dc_bits) {
    const DcLattice lattice = dc_lattice(domain, means, dc_bits);
    part.dc_bits = lattice.bits, part.dc_base = lattice.base, part.dc_step = lattice.step;
    code_dc(domain, means, part);
  };
  // Octants relative to the decoded mean, voxels to the octants.
  std::vector<float> coarse(blocks * 8), fine(blocks * kBlockVoxels);
  const auto make_coarse = [&] {
    for (std::size_t b = 0; b < blocks; ++b)
      std::ranges::copy(octants(samples.data() + b * kBlockVoxels, dc_value(domain, part, b)),
                        coarse.begin() + static_cast<std::ptrdiff_t>(8 * b));
  };
  const auto make_fine = [&](const CodeVectors* coded) {
    for (std::size_t b = 0; b < blocks; ++b) {
      const float* block = samples.data() + b * kBlockVoxels;
      const float mean = dc_value(domain, part, b);
      const std::array<float, 8> means8 = octants(block, mean);
      const float* octant = coded == nullptr ? means8.data() : (*coded)[part.codes[0].empty() ? 0 : part.codes[0][b]];
      for (unsigned i = 0; i < kBlockVoxels; ++i) fine[b * kBlockVoxels + i] = block[i] - mean - octant[octant_of(i)];
    }
  };
  code_levels(domain.type == VoxelType::kU8 ? 8 : 14);
  make_coarse();
  make_fine(nullptr);
  const Vectors first{coarse.data(), blocks, 8, 8}, second{fine.data(), blocks, kBlockVoxels, kBlockVoxels};
  const std::array<Candidate, 2> candidates{{{first, 8, 8, false}, {second, 1, kBlockVoxels, false}}};
  const Bits bits = allocate(kHvq, domain, means, candidates, budget, options, threads);
  code_levels(bits.dc);
  make_coarse();
  CodeVectors octant_book = train_book(first, bits.books[0], options, options.seed * 64, threads);
  quantise_entries(domain, bits.active_error, octant_book, part.books[0]);
  code_nearest(octant_book, first, part.codes[0], threads);
  make_fine(options.closed_loop ? &octant_book : nullptr);
  CodeVectors voxel_book = train_book(second, bits.books[1], options, options.seed * 64 + 1, threads);
  quantise_entries(domain, bits.active_error, voxel_book, part.books[1]);
  code_nearest(voxel_book, second, part.codes[1], threads);
}

/// Code 0 is the zero block, whose entries stand at an end of their range: the base lies in the middle of the samples.
void train_vq(const Domain& domain, std::span<const double> means, std::span<float> samples, double budget, const Options& options,
              SubVolume& part, unsigned threads) {
  const Vectors vectors{samples.data(), means.size(), kBlockVoxels, kBlockVoxels};
  const std::array<Candidate, 1> candidates{{{vectors, 1, kBlockVoxels, false}}};
  const Bits bits = allocate(kVq, domain, means, candidates, budget, options, threads);
  CodeVectors trained = train_book(vectors, bits.books[0], options, options.seed * 64, threads);
  const auto [least, most] = std::ranges::minmax_element(trained.values);
  Book& book = part.books[0];
  const double middle = (static_cast<double>(*least) + static_cast<double>(*most)) / 2;
  choose_entries(domain, (static_cast<double>(*most) - static_cast<double>(*least)) / 2 * 127 / 127.5, bits.active_error, book);
  // A multiple of the scale, so that the zero block is exact; entries use all 2^8 or 2^16 values.
  const double units = units_of(domain);
  part.dc_base = static_cast<std::int32_t>(std::floor(middle * units / book.scale + 0.5)) * book.scale;
  const double limit = book.entry_bytes == 1 ? 127 : 32767;
  book.size = trained.size();
  book.entries.clear();
  for (float& value : trained.values) {
    const double entry = std::clamp(std::floor((static_cast<double>(value) * units - part.dc_base) / book.scale + 0.5), -limit - 1, limit);
    book.entries.push_back(static_cast<std::int16_t>(entry));
    value = static_cast<float>((entry * book.scale + part.dc_base) / units);
  }
  code_nearest(trained, vectors, part.codes[0], threads);
}

/// The largest and the mean squared error over all voxels but exceptions, by slabs.
class ErrorSink final : public SlabSink {
 public:
  ErrorSink(const VolumeSource& truth, std::span<const ExceptionRun> exceptions) : truth_(truth), reader_(truth), exceptions_(exceptions) {}
  std::uint64_t preferred_depth() const override { return 16; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    const VolumeInfo& info = truth_.info();
    slab_.resize((z1 - z0) * info.extent.x * info.extent.y * size_of(info.type));
    return slab_.data();
  }
  void end(std::uint64_t z0, std::uint64_t z1) override {
    const std::byte* original = reader_.read(z0, z1);
    const std::uint64_t plane = truth_.info().extent.x * truth_.info().extent.y;
    switch (truth_.info().type) {
      case VoxelType::kU16:
        return add<std::uint16_t>(original, z0 * plane, (z1 - z0) * plane);
      case VoxelType::kI16:
        return add<std::int16_t>(original, z0 * plane, (z1 - z0) * plane);
      case VoxelType::kF32:
        return add<float>(original, z0 * plane, (z1 - z0) * plane);
      default:
        return add<std::uint8_t>(original, z0 * plane, (z1 - z0) * plane);
    }
  }
  RecordedError error() const { return {largest_, count_ == 0 ? 0 : squares_ / static_cast<double>(count_)}; }

 private:
  template <class T>
  void add(const std::byte* original, std::uint64_t first, std::uint64_t count) {
    const auto* expected = reinterpret_cast<const T*>(original);
    const auto* found = reinterpret_cast<const T*>(slab_.data());
    for (std::uint64_t i = 0; i < count; ++i) {
      while (next_ < exceptions_.size() && exceptions_[next_].first + exceptions_[next_].count <= first + i) ++next_;
      if (next_ < exceptions_.size() && exceptions_[next_].first <= first + i) continue;
      const double difference = static_cast<double>(expected[i]) - static_cast<double>(found[i]);
      largest_ = std::max(largest_, std::abs(difference));
      squares_ += difference * difference;
      ++count_;
    }
  }

  const VolumeSource& truth_;
  volumes::SlabReader reader_;
  std::span<const ExceptionRun> exceptions_;
  Buffer slab_;
  std::size_t next_ = 0;
  double largest_ = 0, squares_ = 0;
  std::uint64_t count_ = 0;
};

}  // namespace

SubVolume encode_part(const Scheme& scheme, const Domain& domain, const Extent& blocks, std::vector<float> samples, std::uint64_t voxels,
                      const Options& options, unsigned threads) {
  SubVolume part;
  part.blocks = blocks;
  const std::vector<double> means = block_means(samples);
  const double budget = options.rate * static_cast<double>(voxels);
  if (scheme.has_transform()) {
    train_tvq(domain, means, std::move(samples), budget, options, part, threads);
  } else if (scheme.dc) {
    train_hvq(domain, means, samples, budget, options, part, threads);
  } else {
    train_vq(domain, means, samples, budget, options, part, threads);
  }
  return part;
}

Expected<Payload> encode(const Scheme& scheme, const VolumeSource& source, const EncoderSettings& settings, unsigned threads) {
  const VolumeInfo& info = source.info();
  auto facts = survey(source, settings.zero, settings.mask);
  if (!facts) return tl::unexpected(facts.error());
  Encoding encoding;
  encoding.domain = facts->domain;
  encoding.edge = settings.edge;
  encoding.exceptions = std::move(facts->exceptions);
  encoding.exception_bits = std::move(facts->exception_bits);
  const Extent grid = encoding.grid(info.extent);
  for (std::uint64_t i = 0; i < grid.voxels(); ++i) {
    const Coordinate at{i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y)};
    volumes::Box box{{0, 0, 0}, info.extent};
    if (settings.edge > 0) {
      const std::uint64_t edge = settings.edge;
      box.origin = {at.x * edge, at.y * edge, at.z * edge};
      box.size = {std::min(edge, info.extent.x - box.origin.x), std::min(edge, info.extent.y - box.origin.y),
                  std::min(edge, info.extent.z - box.origin.z)};
    }
    Options options = settings.options;
    options.seed = settings.options.seed * 1000003 + i;
    encoding.parts.push_back(encode_part(scheme, encoding.domain, ceil_div(box.size, kBlockEdge), read_blocks(source, encoding.domain, box),
                                         box.size.voxels(), options, threads));
  }
  Payload payload = write_payload(scheme, encoding);
  const auto decoder = make_decoder(scheme, info, encoding, {});
  if (!decoder) return tl::unexpected(decoder.error());
  ErrorSink sink(source, encoding.exceptions);
  if (auto ok = (*decoder)->decode(0, threads, sink); !ok) return tl::unexpected(ok.error());
  const RecordedError error = sink.error();
  std::memcpy(payload.bytes.data() + kErrorOffset, &error.largest, sizeof error.largest);
  std::memcpy(payload.bytes.data() + kErrorOffset + sizeof error.largest, &error.mean_squared, sizeof error.mean_squared);
  return payload;
}

}  // namespace cvr::codecs::tvq
