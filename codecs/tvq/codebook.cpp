#include "codecs/tvq/codebook.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>

#include "codecs/tvq/lanes.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::tvq {

namespace {

constexpr std::uint64_t kChunk = 1024;  // vectors that one worker takes at a time

/// The code vectors eight abreast: group g holds, dimension by dimension, the vectors 8g..8g+7; the
/// scores of absent ones are infinite.
class Groups {
 public:
  explicit Groups(const CodeVectors& book)
      : dimensions_(book.dimensions), count_((book.size() + 2 * kLanes - 1) / (2 * kLanes) * 2) {
    values_.assign(std::size_t{count_} * dimensions_ * kLanes, 0.0f);
    half_norms_.assign(std::size_t{count_} * kLanes, std::numeric_limits<float>::infinity());
    for (std::uint32_t k = 0; k < book.size(); ++k) {
      double norm = 0;
      for (unsigned j = 0; j < dimensions_; ++j) {
        const float value = book[k][j];
        values_[(std::size_t{k / kLanes} * dimensions_ + j) * kLanes + k % kLanes] = value;
        norm += static_cast<double>(value) * static_cast<double>(value);
      }
      half_norms_[k] = static_cast<float>(norm / 2);
    }
  }

  /// The nearest code vectors of kAbreast vectors.
  static constexpr unsigned kAbreast = 4;
  void nearest(const float* const* vectors, std::uint16_t* codes) const {
    Lanes best[kAbreast];
    LaneIndices index[kAbreast] = {};
    for (Lanes& b : best) b = Lanes{} + std::numeric_limits<float>::infinity();
    LaneIndices number{0, 1, 2, 3, 4, 5, 6, 7};
    for (std::uint32_t g = 0; g < count_; g += 2) {
      const float* group = values_.data() + std::size_t{g} * dimensions_ * kLanes;
      Lanes score[kAbreast][2] = {};
      for (unsigned j = 0; j < dimensions_; ++j) {
        Lanes first, second;
        load(first, group + j * kLanes);
        load(second, group + (dimensions_ + j) * kLanes);
        for (unsigned v = 0; v < kAbreast; ++v) {
          const float x = vectors[v][j];
          score[v][0] += x * first;
          score[v][1] += x * second;
        }
      }
      for (unsigned half = 0; half < 2; ++half) {
        Lanes norm;
        load(norm, half_norms_.data() + (g + half) * kLanes);
        for (unsigned v = 0; v < kAbreast; ++v) {
          const Lanes s = norm - score[v][half];
          const LaneIndices better = s < best[v];
          best[v] = better ? s : best[v];
          index[v] = better ? number : index[v];
        }
        number += static_cast<std::int32_t>(kLanes);
      }
    }
    for (unsigned v = 0; v < kAbreast; ++v) {
      unsigned lane = 0;
      for (unsigned l = 1; l < kLanes; ++l) {
        if (best[v][l] < best[v][lane] ||
            (best[v][l] == best[v][lane] && index[v][l] < index[v][lane]))
          lane = l;
      }
      codes[v] = static_cast<std::uint16_t>(index[v][lane]);
    }
  }

 private:
  unsigned dimensions_;
  std::uint32_t count_;  // groups, even
  std::vector<float> values_, half_norms_;
};

/// The members of every cell, in order.
struct Cells {
  std::vector<std::uint64_t> begin;  ///< cells + 1
  std::vector<std::uint32_t> members;

  Cells(std::span<const std::uint16_t> codes, std::uint32_t cells)
      : begin(cells + 1), members(codes.size()) {
    for (const std::uint16_t code : codes) ++begin[code + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::uint64_t> at(begin.begin(), begin.end() - 1);
    for (std::size_t n = 0; n < codes.size(); ++n)
      members[at[codes[n]]++] = static_cast<std::uint32_t>(n);
  }
  std::span<const std::uint32_t> of(std::uint32_t cell) const {
    return std::span(members).subspan(begin[cell], begin[cell + 1] - begin[cell]);
  }
};

std::vector<double> mean_of(const Vectors& vectors, std::span<const std::uint32_t> members) {
  std::vector<double> mean(vectors.dimensions, 0.0);
  for (const std::uint32_t n : members) {
    for (unsigned j = 0; j < vectors.dimensions; ++j) mean[j] += static_cast<double>(vectors[n][j]);
  }
  for (double& m : mean) m /= static_cast<double>(members.size());
  return mean;
}

/// Gives code vectors without members to the cells that need them most. Returns whether there was
/// distortion left for all of them.
bool fill_empty_cells(CodeVectors& book, const Vectors& vectors, const Cells& cells,
                      std::uint32_t fixed, unsigned threads) {
  std::vector<std::uint32_t> empty;
  for (std::uint32_t k = fixed; k < book.size(); ++k) {
    if (cells.of(k).empty()) empty.push_back(k);
  }
  if (empty.empty()) return true;
  struct Donor {
    double distortion = 0, farthest_distance = -1;
    std::uint32_t farthest = 0;
  };
  std::vector<Donor> donors(book.size());
  volumes::parallel_for(threads, (book.size() + 63) / 64, [&](unsigned, std::uint64_t chunk) {
    for (std::uint64_t k = chunk * 64; k < std::min<std::uint64_t>(book.size(), chunk * 64 + 64);
         ++k) {
      for (const std::uint32_t n : cells.of(static_cast<std::uint32_t>(k))) {
        const double distance =
            squared_distance(vectors[n], book[static_cast<std::uint32_t>(k)], book.dimensions);
        donors[k].distortion += distance;
        if (distance > donors[k].farthest_distance)
          donors[k].farthest_distance = distance, donors[k].farthest = n;
      }
    }
  });
  std::vector<std::uint32_t> order(book.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, [&](std::uint32_t a, std::uint32_t b) {
    return donors[a].distortion > donors[b].distortion;
  });
  std::size_t next = 0;
  for (const std::uint32_t k : empty) {
    if (next == order.size() || !(donors[order[next]].distortion > 0)) return next > 0;
    std::copy_n(vectors[donors[order[next++]].farthest], book.dimensions, book[k]);
  }
  return true;
}

void drop_empty_cells(CodeVectors& book, const Cells& cells, std::uint32_t fixed) {
  std::uint32_t kept = 0;
  for (std::uint32_t k = 0; k < book.size(); ++k) {
    if (k >= fixed && cells.of(k).empty()) continue;
    std::copy_n(book[k], book.dimensions, book[kept++]);
  }
  book.resize(std::max(kept, std::uint32_t{1}));
}

CodeVectors random_codebook(const Vectors& vectors, std::uint32_t size, std::uint64_t seed) {
  std::vector<std::uint64_t> order(vectors.count);
  std::iota(order.begin(), order.end(), std::uint64_t{0});
  std::ranges::stable_sort(order, {}, [&](std::uint64_t n) { return mix(seed ^ mix(n)); });
  CodeVectors book{vectors.dimensions, {}};
  std::vector<std::vector<float>> seen;
  for (const std::uint64_t n : order) {
    if (book.size() == size) break;
    std::vector<float> vector(vectors[n], vectors[n] + vectors.dimensions);
    const auto at = std::ranges::lower_bound(seen, vector);
    if (at != seen.end() && *at == vector) continue;
    book.append(vector.data());
    seen.insert(at, std::move(vector));
  }
  return book;
}

/// Lloyd-Max levels of one component.
std::vector<float> scalar_levels(const Vectors& vectors, unsigned component, std::uint32_t levels) {
  std::vector<float> values(vectors.count);
  for (std::uint64_t n = 0; n < vectors.count; ++n) values[n] = vectors[n][component];
  const Vectors line{values.data(), vectors.count, 1, 1};
  CodeVectors book = SplitTree(line, levels).codebook(levels);
  refine(book, line, {.iterations = 20}, 1);
  return book.values;
}

CodeVectors scalar_codebook(const Vectors& vectors, std::uint32_t size) {
  const unsigned d = vectors.dimensions;
  std::vector<double> variance(d, 0.0);
  for (std::uint64_t n = 0; n < vectors.count; ++n) {
    for (unsigned j = 0; j < d; ++j)
      variance[j] += static_cast<double>(vectors[n][j]) * static_cast<double>(vectors[n][j]);
  }
  // A level more where the variance that it would still have is the largest, as long as the grid
  // fits.
  std::vector<std::uint32_t> levels(d, 1);
  for (std::uint64_t product = 1;;) {
    unsigned best = d;
    for (unsigned j = 0; j < d; ++j) {
      if (product / levels[j] * (levels[j] + 1) > size || !(variance[j] > 0)) continue;
      const auto left = [&](unsigned i) {
        return variance[i] / (static_cast<double>(levels[i]) * levels[i]);
      };
      if (best == d || left(j) > left(best)) best = j;
    }
    if (best == d) break;
    product = product / levels[best] * (levels[best] + 1);
    ++levels[best];
  }
  CodeVectors book{d, std::vector<float>(d, 0.0f)};
  for (unsigned j = 0; j < d; ++j) {
    const std::vector<float> grid = scalar_levels(vectors, j, levels[j]);
    CodeVectors wider{d, {}};
    for (const float level : grid) {
      for (std::uint32_t k = 0; k < book.size(); ++k) {
        wider.append(book[k]);
        wider[wider.size() - 1][j] = level;
      }
    }
    book = std::move(wider);
  }
  return book;
}

/// Merges the pair whose union adds the least distortion until `size` are left. Each keeps its
/// nearest partner; a merge renews the partners that it takes away.
CodeVectors pnn_codebook(const Vectors& vectors, std::uint32_t size) {
  const auto most = static_cast<std::uint32_t>(
      std::min<std::uint64_t>({vectors.count, std::max<std::uint64_t>(8 * size, 64), 4096}));
  const unsigned d = vectors.dimensions;
  struct Cluster {
    double weight = 1;
    std::vector<double> centre;
    std::size_t partner = 0;
    double cost = 0;
  };
  std::vector<Cluster> clusters;
  for (std::uint32_t m = 0; m < most; ++m) {
    const float* v = vectors[vectors.count * m / most];
    clusters.push_back({1, std::vector<double>(v, v + d), 0, 0});
  }
  const auto find_partner = [&](std::size_t a) {
    Cluster& cluster = clusters[a];
    cluster.cost = std::numeric_limits<double>::infinity();
    for (std::size_t b = 0; b < clusters.size(); ++b) {
      if (b == a) continue;
      double distance = 0;
      for (unsigned j = 0; j < d; ++j)
        distance += (cluster.centre[j] - clusters[b].centre[j]) *
                    (cluster.centre[j] - clusters[b].centre[j]);
      const double cost =
          cluster.weight * clusters[b].weight / (cluster.weight + clusters[b].weight) * distance;
      if (cost < cluster.cost) cluster.cost = cost, cluster.partner = b;
    }
  };
  for (std::size_t a = 0; a < clusters.size(); ++a) find_partner(a);
  while (clusters.size() > size && clusters.size() > 1) {
    std::size_t a = 0;
    for (std::size_t i = 1; i < clusters.size(); ++i) {
      if (clusters[i].cost < clusters[a].cost) a = i;
    }
    std::size_t b = clusters[a].partner;
    if (b < a) std::swap(a, b);
    const double weight = clusters[a].weight + clusters[b].weight;
    for (unsigned j = 0; j < d; ++j) {
      clusters[a].centre[j] = (clusters[a].weight * clusters[a].centre[j] +
                               clusters[b].weight * clusters[b].centre[j]) /
                              weight;
    }
    clusters[a].weight = weight;
    const std::size_t last = clusters.size() - 1;
    if (b != last) clusters[b] = std::move(clusters[last]);
    clusters.pop_back();
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      std::size_t& partner = clusters[i].partner;
      if (i == a || partner == a || partner == b) {
        find_partner(i);
      } else if (partner == last) {
        partner = b;
      }
    }
  }
  CodeVectors book{d, {}};
  for (const Cluster& cluster : clusters) {
    for (const double value : cluster.centre) book.values.push_back(static_cast<float>(value));
  }
  return book;
}

}  // namespace

std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

double squared_distance(const float* a, const float* b, unsigned dimensions) {
  double sum = 0;
  for (unsigned j = 0; j < dimensions; ++j) {
    const double difference = static_cast<double>(a[j]) - static_cast<double>(b[j]);
    sum += difference * difference;
  }
  return sum;
}

void find_nearest(const CodeVectors& book, const Vectors& vectors, std::span<std::uint16_t> codes,
                  unsigned threads) {
  const Groups groups(book);
  volumes::parallel_for(threads, (vectors.count + kChunk - 1) / kChunk,
                        [&](unsigned, std::uint64_t chunk) {
                          const std::uint64_t end = std::min(vectors.count, (chunk + 1) * kChunk);
                          for (std::uint64_t n = chunk * kChunk; n < end; n += Groups::kAbreast) {
                            const float* x[Groups::kAbreast];
                            std::uint16_t found[Groups::kAbreast];
                            for (unsigned v = 0; v < Groups::kAbreast; ++v)
                              x[v] = vectors[std::min(n + v, end - 1)];
                            groups.nearest(x, found);
                            for (unsigned v = 0; v < Groups::kAbreast && n + v < end; ++v)
                              codes[n + v] = found[v];
                          }
                        });
}

double total_distortion(const CodeVectors& book, const Vectors& vectors,
                        std::span<const std::uint16_t> codes, unsigned threads) {
  std::vector<double> partial((vectors.count + kChunk - 1) / kChunk, 0.0);
  volumes::parallel_for(threads, partial.size(), [&](unsigned, std::uint64_t chunk) {
    for (std::uint64_t n = chunk * kChunk; n < std::min(vectors.count, (chunk + 1) * kChunk); ++n) {
      partial[chunk] += squared_distance(vectors[n], book[codes[n]], book.dimensions);
    }
  });
  return std::accumulate(partial.begin(), partial.end(), 0.0);
}

std::vector<double> refine(CodeVectors& book, const Vectors& vectors, const LbgOptions& options,
                           unsigned threads) {
  std::vector<double> history;
  std::vector<std::uint16_t> codes(vectors.count);
  CodeVectors best = book;
  for (unsigned pass = 0; pass <= options.iterations && vectors.count > 0; ++pass) {
    find_nearest(book, vectors, codes, threads);
    const double distortion = total_distortion(book, vectors, codes, threads);
    if (!history.empty() &&
        distortion > history.back()) {  // rounding alone can do this, at the end
      book = std::move(best);
      return history;
    }
    const bool settled =
        !history.empty() && history.back() - distortion <= options.tolerance * history.back();
    history.push_back(distortion);
    const Cells cells(codes, book.size());
    if (distortion == 0) {
      drop_empty_cells(book, cells, options.fixed);
      return history;
    }
    if (pass == options.iterations || settled) break;
    best = book;
    volumes::parallel_for(threads, (book.size() + 63) / 64, [&](unsigned, std::uint64_t chunk) {
      for (std::uint64_t k = std::max<std::uint64_t>(chunk * 64, options.fixed);
           k < std::min<std::uint64_t>(book.size(), chunk * 64 + 64); ++k) {
        const auto members = cells.of(static_cast<std::uint32_t>(k));
        if (members.empty()) continue;
        const std::vector<double> mean = mean_of(vectors, members);
        std::ranges::transform(mean, book[static_cast<std::uint32_t>(k)],
                               [](double m) { return static_cast<float>(m); });
      }
    });
    if (!fill_empty_cells(book, vectors, cells, options.fixed, threads))
      drop_empty_cells(book, cells, options.fixed);
  }
  return history;
}

SplitTree::SplitTree(const Vectors& vectors, std::uint32_t leaves)
    : dimensions_(vectors.dimensions) {
  const unsigned d = dimensions_;
  struct Leaf {
    std::uint64_t begin, end;
    std::vector<double> centre;
    double distortion;
  };
  std::vector<std::uint32_t> order(vectors.count), rest;
  std::iota(order.begin(), order.end(), 0u);
  const auto make_leaf = [&](std::uint64_t begin, std::uint64_t end) {
    const std::span members = std::span<const std::uint32_t>(order).subspan(begin, end - begin);
    Leaf leaf{begin, end, mean_of(vectors, members), 0};
    for (const std::uint32_t n : members) {
      for (unsigned j = 0; j < d; ++j) {
        const double difference = static_cast<double>(vectors[n][j]) - leaf.centre[j];
        leaf.distortion += difference * difference;
      }
    }
    return leaf;
  };
  const auto rounded = [](const std::vector<double>& centre) {
    return std::vector<float>(centre.begin(), centre.end());
  };
  std::vector<Leaf> current;
  current.push_back(make_leaf(0, vectors.count));
  root_ = rounded(current[0].centre);
  using Entry = std::pair<double, std::int64_t>;  // distortion, -leaf: of equals the first leaf
  std::priority_queue<Entry> queue;
  queue.emplace(current[0].distortion, 0);
  std::vector<double> axis(d), next(d);
  while (current.size() < leaves && !queue.empty()) {
    const auto [distortion, negated] = queue.top();
    queue.pop();
    if (!(distortion > 0)) break;
    const auto at = static_cast<std::uint32_t>(-negated);
    const Leaf leaf = current[at];
    const std::span members = std::span(order).subspan(leaf.begin, leaf.end - leaf.begin);
    // Power iteration from the member that is farthest out.
    double farthest = -1;
    for (const std::uint32_t n : members) {
      double distance = 0;
      for (unsigned j = 0; j < d; ++j) {
        next[j] = static_cast<double>(vectors[n][j]) - leaf.centre[j];
        distance += next[j] * next[j];
      }
      if (distance > farthest) farthest = distance, axis = next;
    }
    for (unsigned pass = 0; pass < 3; ++pass) {
      std::ranges::fill(next, 0.0);
      double length = 0;
      for (const double a : axis) length += a * a;
      length = std::sqrt(length);
      if (!(length > 0)) break;
      for (const std::uint32_t n : members) {
        double along = 0;
        for (unsigned j = 0; j < d; ++j)
          along += (static_cast<double>(vectors[n][j]) - leaf.centre[j]) * (axis[j] / length);
        for (unsigned j = 0; j < d; ++j)
          next[j] += along * (static_cast<double>(vectors[n][j]) - leaf.centre[j]);
      }
      if (std::ranges::all_of(next, [](double v) { return v == 0; })) break;
      axis = next;
    }
    rest.clear();
    std::uint64_t kept = leaf.begin;
    for (const std::uint32_t n : members) {
      double along = 0;
      for (unsigned j = 0; j < d; ++j)
        along += (static_cast<double>(vectors[n][j]) - leaf.centre[j]) * axis[j];
      if (along > 0) {
        rest.push_back(n);
      } else {
        order[kept++] = n;
      }
    }
    if (rest.empty() || kept == leaf.begin) continue;  // members that differ by rounding alone
    std::ranges::copy(rest, order.begin() + static_cast<std::ptrdiff_t>(kept));
    Leaf first = make_leaf(leaf.begin, kept), second = make_leaf(kept, leaf.end);
    cuts_.push_back({at, rounded(first.centre), rounded(second.centre)});
    queue.emplace(first.distortion, negated);
    queue.emplace(second.distortion, -static_cast<std::int64_t>(current.size()));
    current[at] = std::move(first);
    current.push_back(std::move(second));
  }
}

CodeVectors SplitTree::codebook(std::uint32_t count) const {
  CodeVectors book{dimensions_, root_};
  for (std::size_t c = 0; c < cuts_.size() && book.size() < count; ++c) {
    std::ranges::copy(cuts_[c].first, book[cuts_[c].leaf]);
    book.append(cuts_[c].second.data());
  }
  return book;
}

CodeVectors initial_codebook(Initialisation how, const Vectors& vectors, std::uint32_t size,
                             std::uint64_t seed) {
  switch (how) {
    case Initialisation::kRandom:
      return random_codebook(vectors, size, seed);
    case Initialisation::kScalar:
      return scalar_codebook(vectors, size);
    case Initialisation::kPnn:
      return pnn_codebook(vectors, size);
    case Initialisation::kSplit:
      break;
  }
  return SplitTree(vectors, size).codebook(size);
}

}  // namespace cvr::codecs::tvq
