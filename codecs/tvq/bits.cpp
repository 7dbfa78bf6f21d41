#include "codecs/tvq/bits.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "codecs/tvq/rounding.hpp"

namespace cvr::codecs::tvq {

namespace {

constexpr unsigned kMostAllocated = 12;  // bits of a book that the allocation considers

double mean_energy(const Vectors& vectors) {
  double sum = 0;
  for (std::uint64_t n = 0; n < vectors.count; ++n) {
    for (unsigned j = 0; j < vectors.dimensions; ++j)
      sum += static_cast<double>(vectors[n][j]) * static_cast<double>(vectors[n][j]);
  }
  return sum / static_cast<double>(vectors.count);
}

/// About the bits of a code vector where books are counted, when the blocks that use it have that
/// mean squared error.
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
  if (device || !candidate.coefficients)
    return candidate.length * 8.0 * entry_bytes(domain, largest, error);
  // The entropy of a rounded normal variable, and what it takes to tell the sizes apart.
  const double step = coefficient_step(v.dimensions, error);
  double bits = 0;
  for (const double s : squares)
    bits += s > 0 && step > 0 ? std::max(1.0, 0.5 * std::log2(s / static_cast<double>(active)) -
                                                  std::log2(step) + 2.5)
                              : 1.0;
  return bits;
}

/// Distortion by bits of a code, over all blocks.
std::vector<double> distortion_curve(const Candidate& candidate, const Options& options,
                                     unsigned threads) {
  const std::uint64_t count = candidate.vectors.count;
  const auto most = std::min(options.best ? kMaxBookBits - 1 : kMostAllocated,
                             static_cast<unsigned>(std::bit_width(count)));
  std::vector<double> curve;
  if (options.operational) {
    curve = measured_curve(candidate.vectors, most, options, threads);
  } else {
    // The paper's model has no bound; a book cannot have more code vectors than an eighth of its
    // training vectors.
    const auto cap =
        static_cast<unsigned>(std::bit_width(std::max<std::uint64_t>(count / 8, 1)) - 1);
    curve = model_curve(candidate.vectors.dimensions,
                        mean_energy(candidate.vectors) / candidate.vectors.dimensions,
                        static_cast<double>(count), std::min(most, cap));
  }
  for (double& d : curve) d *= candidate.weight;
  return curve;
}

/// What a book of 2^bits code vectors loses, from the splits of a small sample.
double rough_distortion(const Candidate& candidate, unsigned bits, unsigned threads) {
  const std::vector<std::uint32_t> active =
                                       sample_active(candidate.vectors, candidate.vectors.count),
                                   sample = sample_active(candidate.vectors, 8192);
  if (sample.empty()) return 0;
  const unsigned d = candidate.vectors.dimensions;
  const std::vector<float> values = gather(candidate.vectors, sample, 0, d);
  const Vectors training{values.data(), sample.size(), d, d};
  const CodeVectors book = SplitTree(training, 1u << bits).codebook(1u << bits);
  std::vector<std::uint16_t> codes(sample.size());
  find_nearest(book, training, codes, threads);
  return candidate.weight * total_distortion(book, training, codes, threads) /
         static_cast<double>(sample.size()) * static_cast<double>(active.size());
}

}  // namespace

Bits allocate(const Scheme& scheme, const Domain& domain, std::span<const double> means,
              std::span<const Candidate> candidates, double blocks, double budget,
              const Options& options, unsigned threads) {
  const double voxels = blocks * kBlockVoxels;
  const double each =
      blocks / static_cast<double>(means.size());  // blocks that one of the sample stands for
  const bool dc_free = scheme.dc && options.dc_bits == 0 && domain.type != VoxelType::kU8;
  Bits bits{!scheme.dc ? 0 : options.dc_bits != 0 ? options.dc_bits : 8, {}, 0, 0};
  std::uint64_t active = 1;
  for (const Candidate& c : candidates)
    active = std::max<std::uint64_t>(active, sample_active(c.vectors, c.vectors.count).size());
  const auto dc_distortion = [&](unsigned dc) {
    return voxels * dc_error(dc_lattice(domain, means, dc), domain);
  };
  const auto set_error = [&](double distortion) {
    bits.error = distortion / voxels;
    bits.active_error = distortion / (static_cast<double>(active) * each * kBlockVoxels);
  };
  if (options.rate <= 0) {
    double distortion = 0;
    for (unsigned p = 0; p < scheme.books; ++p) {
      bits.books[p] = options.bits[p];
      distortion += each * rough_distortion(candidates[p], bits.books[p], threads);
    }
    set_error(distortion);
    if (dc_free) {
      for (bits.dc = kLeastDcBits;
           bits.dc < kMaxDcBits && dc_distortion(bits.dc) > 0.05 * distortion; ++bits.dc) {
      }
    }
    return bits;
  }
  std::vector<BitCurve> curves;
  for (const Candidate& c : candidates) {
    curves.push_back({0, distortion_curve(c, options, threads), {}});
    for (double& d : curves.back().distortion) d *= each;
    set_error(bits.error * voxels + curves.back().distortion.back());
  }
  if (scheme.dc) {
    BitCurve& curve = curves.emplace_back();
    curve.first = dc_free ? kLeastDcBits : bits.dc;
    for (unsigned b = curve.first; b <= (dc_free ? 14u : bits.dc); ++b)
      curve.distortion.push_back(dc_distortion(b));
    curve.book_bits.assign(curve.distortion.size(), 0.0);
  }
  // What a code vector takes depends on the error, which depends on the bits: after a first guess
  // the dearer of two estimates.
  std::array<double, kMaxBooks> dearest{};
  for (unsigned pass = 0; pass < 3; ++pass) {
    for (unsigned p = 0; p < scheme.books; ++p) {
      const double each = std::max(
          vector_bits(domain, candidates[p], bits.active_error, options.count_device), dearest[p]);
      if (pass > 0) dearest[p] = each;
      curves[p].book_bits.clear();
      for (unsigned b = 0; b < curves[p].distortion.size(); ++b)
        curves[p].book_bits.push_back(b == 0 ? 0 : std::exp2(b) * each);
    }
    const std::vector<unsigned> chosen = choose_bits(curves, blocks, budget);
    double distortion = 0;
    for (std::size_t p = 0; p < curves.size(); ++p)
      distortion += curves[p].distortion[chosen[p] - curves[p].first];
    set_error(distortion);
    std::copy_n(chosen.begin(), scheme.books, bits.books.begin());
    if (scheme.dc) bits.dc = chosen[scheme.books];
  }
  return bits;
}

}  // namespace cvr::codecs::tvq
