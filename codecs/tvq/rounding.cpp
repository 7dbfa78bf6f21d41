#include "codecs/tvq/rounding.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cvr::codecs::tvq {

namespace {

/// Units an entry, so that entries up to `largest` samples fit.
double entry_scale(const Domain& domain, double largest, double limit) {
  return std::max(1.0, std::ceil(largest * units_of(domain) / limit));
}

double largest_of(const CodeVectors& book) {
  double largest = 0;
  for (const float value : book.values)
    largest = std::max(largest, std::abs(static_cast<double>(value)));
  return largest;
}

}  // namespace

std::vector<double> block_means(std::span<const float> samples) {
  std::vector<double> means(samples.size() / kBlockVoxels);
  for (std::size_t b = 0; b < means.size(); ++b) {
    double sum = 0;
    for (unsigned i = 0; i < kBlockVoxels; ++i)
      sum += static_cast<double>(samples[b * kBlockVoxels + i]);
    means[b] = sum / kBlockVoxels;
  }
  return means;
}

DcLattice dc_lattice(const Domain& domain, std::span<const double> means, unsigned bits) {
  const double units = units_of(domain);
  const auto [least, most] = std::ranges::minmax_element(means);
  const auto low = static_cast<std::int64_t>(std::llround(*least * units)),
             high = static_cast<std::int64_t>(std::llround(*most * units));
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
  const auto last = static_cast<std::uint64_t>(
      std::llround(static_cast<double>(high) / static_cast<double>(step)) - first);
  return {std::min<unsigned>(static_cast<unsigned>(std::bit_width(last)), kMaxDcBits),
          static_cast<std::int32_t>(first * step), static_cast<std::uint32_t>(step)};
}

double dc_error(const DcLattice& lattice, const Domain& domain) {
  const double step = lattice.bits == 0 ? 0 : lattice.step / units_of(domain);
  return step * step / 12;
}

void code_dc(const Domain& domain, std::span<const double> means, unsigned bits, SubVolume& part) {
  const DcLattice lattice = dc_lattice(domain, means, bits);
  part.dc_bits = lattice.bits, part.dc_base = lattice.base, part.dc_step = lattice.step;
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
  const std::int64_t units =
      part.dc_base + (part.dc_bits == 0 ? 0 : std::int64_t{part.dc[block]} * part.dc_step);
  return static_cast<float>(static_cast<double>(units) / units_of(domain));
}

unsigned entry_bytes(const Domain& domain, double largest, double error) {
  const double scale = entry_scale(domain, largest, 127), rounding = scale / units_of(domain);
  return domain.type == VoxelType::kU8 ||
                 (scale <= 65535 && rounding * rounding / 12 <= 0.02 * error)
             ? 1
             : 2;
}

void choose_entries(const Domain& domain, double largest, double error, Book& book) {
  book.entry_bytes = static_cast<std::uint8_t>(entry_bytes(domain, largest, error));
  book.scale = static_cast<std::uint16_t>(
      std::min(entry_scale(domain, largest, book.entry_bytes == 1 ? 127 : 32767), 65535.0));
}

double coefficient_step(unsigned dimensions, double error) {
  return std::sqrt(0.12 * error * kBlockVoxels / dimensions);
}

void quantise_entries(const Domain& domain, double error, CodeVectors& code_vectors, Book& book) {
  const double units = units_of(domain);
  choose_entries(domain, largest_of(code_vectors), error, book);
  const double limit = book.entry_bytes == 1 ? 127 : 32767;
  book.size = code_vectors.size();
  book.step = 0;
  book.entries.clear();
  for (float& value : code_vectors.values) {
    const double entry = std::clamp(
        std::floor(static_cast<double>(value) * units / book.scale + 0.5), -limit, limit);
    book.entries.push_back(static_cast<std::int16_t>(entry));
    value = static_cast<float>(entry * book.scale / units);
  }
}

void quantise_coefficients(const Domain& domain, unsigned partition, const Basis& basis,
                           double error, bool keep, CodeVectors& code_vectors, Book& book) {
  const double per_sample = units_of(domain) * 256;
  const unsigned n = kPartitionSize[partition];
  double step = coefficient_step(n, error) * per_sample;
  step = std::max(step, largest_of(code_vectors) * per_sample / 32767);
  book.step = static_cast<std::uint32_t>(
      std::clamp(std::ceil(step), 1.0, static_cast<double>(kLargestStep)));
  book.size = code_vectors.size();
  book.coefficients.clear();
  for (float& value : code_vectors.values) {
    const double c = std::clamp(
        std::floor(static_cast<double>(value) * per_sample / book.step + 0.5), -32767.0, 32767.0);
    book.coefficients.push_back(static_cast<std::int16_t>(c));
    value = static_cast<float>(c * book.step / per_sample);
  }
  double largest = 0;
  for (std::uint32_t k = 0; k < code_vectors.size(); ++k) {
    std::array<float, kBlockVoxels> wide{};
    std::copy_n(code_vectors[k], n, wide.data() + kPartitionBegin[partition]);
    for (const float value : basis.inverse(wide))
      largest = std::max(largest, std::abs(static_cast<double>(value)));
  }
  choose_entries(domain, largest, error, book);
  project(book, partition, basis);
  if (keep) return;
  book.coefficients.clear();
  book.step = 0;
}

}  // namespace cvr::codecs::tvq
