#include "codecs/tvq/train.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "volumes/parallel.hpp"

namespace cvr::codecs::tvq {

namespace {

constexpr std::uint8_t kNoChapter = 0;  // the zero class, which has none

/// Zones of a partition that a class keeps, as a range of dimensions: they always lie together.
struct LiveRange {
  unsigned first, count;
};
LiveRange live_range(unsigned block_class, unsigned partition) {
  unsigned first = kBlockVoxels, end = 0;
  for (unsigned k = kPartitionBegin[partition];
       k < kPartitionBegin[partition] + kPartitionSize[partition]; ++k) {
    if ((kBlockClasses[block_class].keeps >> (k / 8) & 1) == 0) continue;
    first = std::min(first, k);
    end = k + 1;
  }
  if (end == 0) return {0, 0};
  return {first - kPartitionBegin[partition], end - first};
}

/// The class whose zones hold those of a class and which is the next dearer.
std::uint8_t superset_of(std::uint8_t block_class) { return block_class < 5 ? 5 : 9; }

/// Which chapter the blocks of each class use in a partition: their own, or that of a class that
/// they are folded into.
using ChapterOf = std::array<std::uint8_t, kClasses>;

ChapterOf chapters_by_fold(unsigned partition,
                           const std::array<std::uint64_t, kClasses>& population,
                           std::uint64_t entries) {
  ChapterOf chapter{};
  std::array<std::uint64_t, kClasses> members{};
  for (std::uint8_t c = 1; c < kClasses; ++c) {
    if (population[c] > 0 && live_range(c, partition).count > 0) {
      chapter[c] = c;
      members[c] = population[c];
    }
  }
  for (;;) {
    std::uint8_t least = kNoChapter;
    std::uint64_t count = 0;
    for (std::uint8_t c = 1; c < kClasses; ++c) {
      if (members[c] == 0) continue;
      ++count;
      if (c != kClasses - 1 && (least == kNoChapter || members[c] < members[least])) least = c;
    }
    if (count <= entries || least == kNoChapter) break;
    const std::uint8_t into = superset_of(least);
    members[into] += members[least];
    members[least] = 0;
    for (std::uint8_t& c : chapter) c = c == least ? into : c;
  }
  return chapter;
}

ChapterDemand demand_of(const Vectors& vectors, double probability) {
  const unsigned d = vectors.dimensions;
  std::vector<double> variance(d, 0.0);
  for (unsigned j = 0; j < d; ++j) {
    double sum = 0, squares = 0;
    for (std::uint64_t n = 0; n < vectors.count; ++n) {
      sum += static_cast<double>(vectors[n][j]);
      squares += static_cast<double>(vectors[n][j]) * static_cast<double>(vectors[n][j]);
    }
    const auto count = static_cast<double>(vectors.count);
    variance[j] = std::max(0.0, squares / count - sum / count * (sum / count));
  }
  const double floor = 1e-12 * std::ranges::max(variance);
  ChapterDemand demand{
      probability, 0, 0,
      static_cast<std::uint32_t>(std::min<std::uint64_t>(vectors.count, 1u << kMaxBookBits))};
  double logs = 0;
  for (const double v : variance) {
    if (v > floor) logs += std::log(v), ++demand.dimensions;
  }
  if (demand.dimensions > 0)
    demand.amplitude = demand.dimensions * std::exp(logs / demand.dimensions);
  return demand;
}

std::array<std::uint64_t, kClasses> histogram(std::span<const std::uint8_t> classes) {
  std::array<std::uint64_t, kClasses> population{};
  for (const std::uint8_t c : classes) ++population[c];
  return population;
}

}  // namespace

Vectors partition_vectors(std::span<const float> coefficients, unsigned partition) {
  return {coefficients.data() + kPartitionBegin[partition], coefficients.size() / kBlockVoxels,
          kPartitionSize[partition], kBlockVoxels};
}

std::vector<std::uint32_t> sample_active(const Vectors& vectors, std::uint64_t most) {
  std::vector<std::uint32_t> active;
  for (std::uint64_t n = 0; n < vectors.count; ++n) {
    if (std::any_of(vectors[n], vectors[n] + vectors.dimensions, [](float v) { return v != 0; }))
      active.push_back(static_cast<std::uint32_t>(n));
  }
  if (active.size() <= most) return active;
  std::vector<std::uint32_t> sample(most);
  for (std::uint64_t i = 0; i < most; ++i) sample[i] = active[i * active.size() / most];
  return sample;
}

std::vector<float> gather(const Vectors& vectors, std::span<const std::uint32_t> which,
                          unsigned first, unsigned dimensions) {
  std::vector<float> values(which.size() * dimensions);
  for (std::size_t i = 0; i < which.size(); ++i)
    std::copy_n(vectors[which[i]] + first, dimensions, values.data() + i * dimensions);
  return values;
}

std::uint64_t training_size(const Options& options, std::uint64_t code_vectors) {
  if (options.best) return std::uint64_t{1} << 20;
  return std::clamp<std::uint64_t>(32 * code_vectors, 8192, 65536);
}

unsigned training_iterations(const Options& options) {
  return options.rough ? 2 : options.best ? 30 : 10;
}

CodeVectors train_book(const Vectors& vectors, unsigned bits, const Options& options,
                       std::uint64_t seed, unsigned threads) {
  const unsigned d = vectors.dimensions;
  CodeVectors book{d, std::vector<float>(d, 0.0f)};
  const std::vector<std::uint32_t> sample =
      sample_active(vectors, training_size(options, std::uint64_t{1} << bits));
  if (bits == 0 || sample.empty()) return book;
  const std::vector<float> values = gather(vectors, sample, 0, d);
  const Vectors training{values.data(), sample.size(), d, d};
  const CodeVectors initial =
      initial_codebook(options.initialisation, training, (1u << bits) - 1, seed);
  book.values.insert(book.values.end(), initial.values.begin(), initial.values.end());
  refine(book, training, {.iterations = training_iterations(options), .fixed = 1}, threads);
  return book;
}

std::vector<double> measured_curve(const Vectors& vectors, unsigned most_bits,
                                   const Options& options, unsigned threads) {
  const std::uint64_t most = options.best ? 98304 : 24576;
  const std::vector<std::uint32_t> active = sample_active(vectors, vectors.count);
  std::vector<double> curve(most_bits + 1, 0.0);
  if (active.empty()) return curve;
  std::vector<std::uint32_t> train, test;
  if (active.size() <= most) {
    train = test = active;
  } else {
    for (std::uint64_t i = 0; i < most; ++i)
      (i % 3 == 2 ? test : train).push_back(active[i * active.size() / most]);
  }
  const unsigned d = vectors.dimensions;
  const std::vector<float> train_values = gather(vectors, train, 0, d),
                           test_values = gather(vectors, test, 0, d);
  const Vectors training{train_values.data(), train.size(), d, d},
      held_out{test_values.data(), test.size(), d, d};
  const SplitTree tree(training, (1u << most_bits) - 1);
  const double scale = static_cast<double>(active.size()) / static_cast<double>(test.size());
  std::vector<std::uint16_t> codes(test.size());
  for (unsigned b = 0; b <= most_bits; ++b) {
    CodeVectors book{d, std::vector<float>(d, 0.0f)};
    if (b > 0) {
      const CodeVectors leaves = tree.codebook((1u << b) - 1);
      book.values.insert(book.values.end(), leaves.values.begin(), leaves.values.end());
      refine(book, training, {.iterations = options.best ? 3u : 1u, .fixed = 1}, threads);
    }
    find_nearest(book, held_out, codes, threads);
    curve[b] = scale * total_distortion(book, held_out, codes, threads);
    if (b > 0) curve[b] = std::min(curve[b], curve[b - 1]);
  }
  return curve;
}

ClassifiedBooks train_chapters(std::span<const float> coefficients,
                               std::span<const std::uint8_t> classes,
                               const std::array<unsigned, kPartitions>& bits,
                               const Options& options, unsigned threads) {
  ClassifiedBooks result;
  const std::array<std::uint64_t, kClasses> population = histogram(classes);
  for (unsigned p = 0; p < kPartitions; ++p) {
    const Vectors vectors = partition_vectors(coefficients, p);
    const unsigned d = vectors.dimensions;
    CodeVectors& book = result.books[p];
    book = {d, std::vector<float>(d, 0.0f)};
    if (bits[p] == 0) continue;
    const std::uint32_t entries = (1u << bits[p]) - 1;
    const ChapterOf chapter_of = chapters_by_fold(p, population, entries);
    // Chapters learn from blocks of their classes alone, which may be few among all.
    const std::uint64_t size = training_size(options, std::uint64_t{1} << bits[p]);
    std::vector<std::uint32_t> users;
    for (std::uint32_t n = 0; n < classes.size(); ++n) {
      if (chapter_of[classes[n]] != kNoChapter) users.push_back(n);
    }
    const std::uint64_t drawn = std::min<std::uint64_t>(users.size(), size);
    std::array<std::vector<std::uint32_t>, kClasses> members;
    for (std::uint64_t i = 0; i < drawn; ++i) {
      const std::uint32_t n = users[i * users.size() / drawn];
      members[chapter_of[classes[n]]].push_back(n);
    }
    std::vector<std::uint8_t> used;
    std::vector<std::vector<float>> values;
    std::vector<ChapterDemand> demands;
    for (std::uint8_t c = 1; c < kClasses; ++c) {
      if (members[c].empty()) continue;
      const LiveRange live = live_range(c, p);
      values.push_back(gather(vectors, members[c], live.first, live.count));
      // A folded block keeps what its own class keeps.
      for (std::size_t i = 0; i < members[c].size(); ++i) {
        for (unsigned j = 0; j < live.count; ++j) {
          if ((kBlockClasses[classes[members[c][i]]].keeps >>
                   ((kPartitionBegin[p] + live.first + j) / 8) &
               1) == 0)
            values.back()[i * live.count + j] = 0;
        }
      }
      used.push_back(c);
      demands.push_back(
          demand_of({values.back().data(), members[c].size(), live.count, live.count},
                    static_cast<double>(members[c].size()) / static_cast<double>(drawn)));
    }
    if (used.empty()) continue;
    const std::vector<std::uint32_t> share = share_entries(demands, entries);
    for (std::size_t i = 0; i < used.size(); ++i) {
      const LiveRange live = live_range(used[i], p);
      const Vectors training{values[i].data(), members[used[i]].size(), live.count, live.count};
      CodeVectors chapter = initial_codebook(options.initialisation, training, share[i],
                                             options.seed * 64 + p * 16 + used[i]);
      refine(chapter, training, {.iterations = training_iterations(options)}, threads);
      for (std::uint32_t k = 0; k < chapter.size(); ++k) {
        std::vector<float> wide(d, 0.0f);
        std::copy_n(chapter[k], live.count, wide.data() + live.first);
        book.append(wide.data());
      }
      result.chapters[p].push_back({used[i], chapter.size()});
    }
    if (!options.global) continue;
    // From here on the classes are but where the iteration begins: all code vectors for all blocks.
    const std::vector<std::uint32_t> sample = sample_active(vectors, size);
    const std::vector<float> all = gather(vectors, sample, 0, d);
    refine(book, {all.data(), sample.size(), d, d},
           {.iterations = training_iterations(options), .fixed = 1}, threads);
    result.chapters[p].clear();
  }
  return result;
}

std::vector<std::uint16_t> assign_codes(const CodeVectors& book, std::span<const Chapter> chapters,
                                        unsigned partition, std::span<const float> coefficients,
                                        std::span<const std::uint8_t> classes, bool global,
                                        unsigned threads) {
  const Vectors vectors = partition_vectors(coefficients, partition);
  std::vector<std::uint16_t> codes(vectors.count, 0);
  if (book.size() == 1) return {};
  if (global) {
    find_nearest(book, vectors, codes, threads);
    return codes;
  }
  // A class without a chapter of its own was folded into the next dearer that has one.
  const auto chapter_of = [&](std::uint8_t c) -> std::uint8_t {
    if (live_range(c, partition).count == 0) return kNoChapter;
    while (std::ranges::find(chapters, c, &Chapter::block_class) == chapters.end()) {
      if (c == kClasses - 1) return kNoChapter;
      c = superset_of(c);
    }
    return c;
  };
  std::array<std::uint8_t, kClasses> chapter{};
  for (std::uint8_t c = 1; c < kClasses; ++c) chapter[c] = chapter_of(c);
  std::uint32_t first = 1;
  for (const Chapter& used : chapters) {
    std::vector<std::uint32_t> which;
    for (std::uint32_t n = 0; n < vectors.count; ++n) {
      if (chapter[classes[n]] == used.block_class) which.push_back(n);
    }
    std::vector<float> values = gather(vectors, which, 0, vectors.dimensions);
    CodeVectors part{
        book.dimensions,
        std::vector<float>(book[first], book[first] + std::size_t{used.size} * book.dimensions)};
    std::vector<std::uint16_t> found(which.size());
    find_nearest(part, {values.data(), which.size(), vectors.dimensions, vectors.dimensions}, found,
                 threads);
    for (std::size_t i = 0; i < which.size(); ++i)
      codes[which[i]] = static_cast<std::uint16_t>(first + found[i]);
    first += used.size;
  }
  return codes;
}

}  // namespace cvr::codecs::tvq
