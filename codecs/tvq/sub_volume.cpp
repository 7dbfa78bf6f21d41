#include "codecs/tvq/sub_volume.hpp"

#include <algorithm>
#include <cmath>

#include "codecs/tvq/bits.hpp"
#include "codecs/tvq/rounding.hpp"

namespace cvr::codecs::tvq {

namespace {

constexpr double kTauOfTarget = 0.7;

/// Means of the eight octants of a block, minus `mean`.
std::array<float, 8> octants(const float* block, float mean) {
  std::array<double, 8> sums{};
  for (unsigned i = 0; i < kBlockVoxels; ++i)
    sums[(i >> 1 & 1) + 2 * (i >> 3 & 1) + 4 * (i >> 5 & 1)] += static_cast<double>(block[i]);
  std::array<float, 8> means;
  for (unsigned j = 0; j < 8; ++j)
    means[j] = static_cast<float>(sums[j] / 8 - static_cast<double>(mean));
  return means;
}
unsigned octant_of(unsigned i) { return (i >> 1 & 1) + 2 * (i >> 3 & 1) + 4 * (i >> 5 & 1); }

std::vector<std::uint8_t> classes_of(std::span<const float> coefficients, double tau) {
  std::vector<std::uint8_t> classes(coefficients.size() / kBlockVoxels);
  for (std::size_t b = 0; b < classes.size(); ++b) {
    classes[b] = static_cast<std::uint8_t>(
        classify(zone_energies(coefficients.data() + b * kBlockVoxels), tau * tau));
  }
  return classes;
}

/// The error of books on some blocks when the classes lose at most tau.
double error_at(std::span<const float> coefficients, double tau, const Bits& bits,
                const Options& options, unsigned threads) {
  const std::vector<std::uint8_t> classes = classes_of(coefficients, tau);
  const ClassifiedBooks trained =
      train_chapters(coefficients, classes, bits.books, options, threads);
  double sum = 0;
  for (unsigned p = 0; p < kPartitions; ++p) {
    std::vector<std::uint16_t> codes = assign_codes(trained.books[p], trained.chapters[p], p,
                                                    coefficients, classes, options.global, threads);
    codes.resize(classes.size());
    sum += total_distortion(trained.books[p], partition_vectors(coefficients, p), codes, threads);
  }
  return sum;
}

double choose_tau(const Domain& domain, std::span<const float> coefficients, const Bits& bits,
                  const Options& options, unsigned threads) {
  const double range = domain.type == VoxelType::kU8
                           ? 255
                           : static_cast<double>(domain.high - domain.low) /
                                 (domain.type == VoxelType::kF32 ? units_of(domain) : 1);
  const double target =
      options.psnr > 0 ? range * std::pow(10.0, -options.psnr / 20) : std::sqrt(bits.error);
  if (options.tau > 0) return options.tau * target;
  if (options.psnr > 0) return kTauOfTarget * target;
  const std::uint64_t blocks = coefficients.size() / kBlockVoxels,
                      most = options.best ? 32768 : 8192;
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

Trained train_tvq(const Domain& domain, Blocks& sample, double blocks, double budget,
                  const Options& options, unsigned threads) {
  Trained result;
  Basis& basis = result.set.basis;
  basis = options.basis != nullptr ? *options.basis
                                   : Basis::fit(options.transform, sample.samples, threads);
  basis.forward(sample.samples, threads);
  sample.transformed = true;
  const std::span<const float> coefficients(sample.samples);
  std::vector<Candidate> candidates;
  for (unsigned p = 0; p < kPartitions; ++p) {
    candidates.push_back(
        {partition_vectors(coefficients, p), 1, kBlockVoxels, options.coefficients});
  }
  const Bits bits =
      allocate(kTvq, domain, sample.means, candidates, blocks, budget, options, threads);
  result.dc_bits = bits.dc;
  ClassifiedBooks trained;
  if (options.classify) {
    result.tau = choose_tau(domain, coefficients, bits, options, threads);
    trained = train_chapters(coefficients, classes_of(coefficients, result.tau), bits.books,
                             options, threads);
  } else {
    for (unsigned p = 0; p < kPartitions; ++p) {
      trained.books[p] =
          train_book(candidates[p].vectors, bits.books[p], options, options.seed * 64 + p, threads);
    }
  }
  for (unsigned p = 0; p < kPartitions; ++p) {
    Book& book = result.set.books[p];
    quantise_coefficients(domain, p, basis, bits.active_error, options.coefficients,
                          trained.books[p], book);
    book.chapters = trained.chapters[p];
    result.code_vectors[p] = std::move(trained.books[p]);
  }
  return result;
}

void code_tvq(const Trained& trained, Blocks& blocks, const Options& options, SubVolume& part,
              unsigned threads) {
  if (!blocks.transformed) trained.set.basis.forward(blocks.samples, threads);
  const std::span<const float> coefficients(blocks.samples);
  const bool whole_books = options.global || !options.classify;
  std::vector<std::uint8_t> classes;
  if (!whole_books) classes = classes_of(coefficients, trained.tau);
  for (unsigned p = 0; p < kPartitions; ++p) {
    part.codes[p] = assign_codes(trained.code_vectors[p], trained.set.books[p].chapters, p,
                                 coefficients, classes, whole_books, threads);
  }
}

void code_nearest(const CodeVectors& book, const Vectors& vectors,
                  std::vector<std::uint16_t>& codes, unsigned threads) {
  codes.clear();
  if (book.size() == 1) return;
  codes.resize(vectors.count);
  find_nearest(book, vectors, codes, threads);
}

/// What the books of hvq see: octants relative to the decoded mean, voxels relative to the octants.
class Hierarchy {
 public:
  Hierarchy(const Domain& domain, const Blocks& blocks) : domain_(domain), blocks_(blocks) {
    coarse_.resize(blocks.count() * 8);
    fine_.resize(blocks.count() * kBlockVoxels);
  }
  Vectors octants() const { return {coarse_.data(), blocks_.count(), 8, 8}; }
  Vectors voxels() const { return {fine_.data(), blocks_.count(), kBlockVoxels, kBlockVoxels}; }

  void code_means(unsigned dc_bits, SubVolume& part) {
    code_dc(domain_, blocks_.means, dc_bits, part);
    for (std::size_t b = 0; b < blocks_.count(); ++b)
      std::ranges::copy(tvq::octants(block(b), dc_value(domain_, part, b)),
                        coarse_.begin() + static_cast<std::ptrdiff_t>(8 * b));
  }
  /// Voxels relative to the octants that part.codes[0] names in `coded`, or to their own where it
  /// is null.
  void take_octants_off(const CodeVectors* coded, const SubVolume& part) {
    for (std::size_t b = 0; b < blocks_.count(); ++b) {
      const float mean = dc_value(domain_, part, b);
      const std::array<float, 8> own = tvq::octants(block(b), mean);
      const float* octant =
          coded == nullptr ? own.data() : (*coded)[part.codes[0].empty() ? 0 : part.codes[0][b]];
      for (unsigned i = 0; i < kBlockVoxels; ++i)
        fine_[b * kBlockVoxels + i] = block(b)[i] - mean - octant[octant_of(i)];
    }
  }

 private:
  const float* block(std::size_t b) const { return blocks_.samples.data() + b * kBlockVoxels; }

  const Domain& domain_;
  const Blocks& blocks_;
  std::vector<float> coarse_, fine_;
};

/// DC and octants, and what is then left to the second book.
void code_octants(const Trained& trained, const Options& options, Hierarchy& hierarchy,
                  SubVolume& part, unsigned threads) {
  hierarchy.code_means(trained.dc_bits, part);
  code_nearest(trained.code_vectors[0], hierarchy.octants(), part.codes[0], threads);
  hierarchy.take_octants_off(options.closed_loop ? &trained.code_vectors[0] : nullptr, part);
}

Trained train_hvq(const Domain& domain, const Blocks& sample, double blocks, double budget,
                  const Options& options, unsigned threads) {
  Trained result;
  SubVolume part;
  Hierarchy hierarchy(domain, sample);
  hierarchy.code_means(domain.type == VoxelType::kU8 ? 8 : 14, part);
  hierarchy.take_octants_off(nullptr, part);
  const std::array<Candidate, 2> candidates{
      {{hierarchy.octants(), 8, 8, false}, {hierarchy.voxels(), 1, kBlockVoxels, false}}};
  const Bits bits =
      allocate(kHvq, domain, sample.means, candidates, blocks, budget, options, threads);
  result.dc_bits = bits.dc;
  hierarchy.code_means(bits.dc, part);
  result.code_vectors[0] =
      train_book(hierarchy.octants(), bits.books[0], options, options.seed * 64, threads);
  quantise_entries(domain, bits.active_error, result.code_vectors[0], result.set.books[0]);
  code_octants(result, options, hierarchy, part, threads);
  result.code_vectors[1] =
      train_book(hierarchy.voxels(), bits.books[1], options, options.seed * 64 + 1, threads);
  quantise_entries(domain, bits.active_error, result.code_vectors[1], result.set.books[1]);
  return result;
}

void code_hvq(const Domain& domain, const Trained& trained, const Blocks& blocks,
              const Options& options, SubVolume& part, unsigned threads) {
  Hierarchy hierarchy(domain, blocks);
  code_octants(trained, options, hierarchy, part, threads);
  code_nearest(trained.code_vectors[1], hierarchy.voxels(), part.codes[1], threads);
}

Vectors whole_blocks(const Blocks& blocks) {
  return {blocks.samples.data(), blocks.count(), kBlockVoxels, kBlockVoxels};
}

/// Code 0 is the zero block, whose entries stand at an end of their range: the base lies in the
/// middle of the samples.
Trained train_vq(const Domain& domain, const Blocks& sample, double blocks, double budget,
                 const Options& options, unsigned threads) {
  Trained result;
  const std::array<Candidate, 1> candidates{{{whole_blocks(sample), 1, kBlockVoxels, false}}};
  const Bits bits =
      allocate(kVq, domain, sample.means, candidates, blocks, budget, options, threads);
  CodeVectors& trained = result.code_vectors[0];
  trained = train_book(whole_blocks(sample), bits.books[0], options, options.seed * 64, threads);
  const auto [least, most] = std::ranges::minmax_element(trained.values);
  Book& book = result.set.books[0];
  const double middle = (static_cast<double>(*least) + static_cast<double>(*most)) / 2;
  choose_entries(domain,
                 (static_cast<double>(*most) - static_cast<double>(*least)) / 2 * 127 / 127.5,
                 bits.active_error, book);
  // A multiple of the scale, so that the zero block is exact; entries use all 2^8 or 2^16 values.
  const double units = units_of(domain);
  result.dc_base =
      static_cast<std::int32_t>(std::floor(middle * units / book.scale + 0.5)) * book.scale;
  const double limit = book.entry_bytes == 1 ? 127 : 32767;
  book.size = trained.size();
  book.entries.clear();
  for (float& value : trained.values) {
    const double entry = std::clamp(
        std::floor((static_cast<double>(value) * units - result.dc_base) / book.scale + 0.5),
        -limit - 1, limit);
    book.entries.push_back(static_cast<std::int16_t>(entry));
    value = static_cast<float>((entry * book.scale + result.dc_base) / units);
  }
  return result;
}

}  // namespace

Blocks::Blocks(std::vector<float> of_samples)
    : samples(std::move(of_samples)), means(block_means(samples)) {}

Trained train(const Scheme& scheme, const Domain& domain, Blocks& sample, double blocks,
              double budget, const Options& options, unsigned threads) {
  if (scheme.has_transform()) return train_tvq(domain, sample, blocks, budget, options, threads);
  if (scheme.dc) return train_hvq(domain, sample, blocks, budget, options, threads);
  return train_vq(domain, sample, blocks, budget, options, threads);
}

SubVolume code(const Scheme& scheme, const Domain& domain, const Trained& trained,
               const Extent& grid, Blocks blocks, const Options& options, unsigned threads) {
  SubVolume part;
  part.blocks = grid;
  if (scheme.has_transform()) {
    code_dc(domain, blocks.means, trained.dc_bits, part);
    code_tvq(trained, blocks, options, part, threads);
  } else if (scheme.dc) {
    code_hvq(domain, trained, blocks, options, part, threads);
  } else {
    part.dc_base = trained.dc_base;
    code_nearest(trained.code_vectors[0], whole_blocks(blocks), part.codes[0], threads);
  }
  return part;
}

}  // namespace cvr::codecs::tvq
