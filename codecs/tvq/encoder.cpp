#include "codecs/tvq/encoder.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "codecs/tvq/bits.hpp"
#include "codecs/tvq/random_codes.hpp"
#include "codecs/tvq/rounding.hpp"

namespace cvr::codecs::tvq {

namespace {

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
    const Extent blocks = ceil_div(box.size, kBlockEdge);
    encoding.parts.push_back(options.random_codes ? random_part(scheme, encoding.domain, blocks, options)
                                                  : encode_part(scheme, encoding.domain, blocks, read_blocks(source, encoding.domain, box),
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
