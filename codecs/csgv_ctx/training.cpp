#include "codecs/csgv_ctx/training.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <memory>

#include "codecs/csgv_ctx/clustering.hpp"
#include "codecs/csgv_ctx/description_length.hpp"

namespace cvr::codecs::csgv_ctx {

namespace {

using Entry = EventCounts::Entry;

/// A context, or several that agree on the bits that matter.
template <std::size_t N>
struct Sample {
  std::uint32_t context;
  Counts<N> symbols;
};

// What a tree's description costs: measured as a whole it is close to this on real volumes.
constexpr Cost kSplit = bits(5);  ///< the split and its bit
constexpr Cost kLeaf = bits(8);   ///< the leaf and its distribution
constexpr Cost kSymbol =
    bits(3);  ///< each further symbol of a leaf, with half the logarithm of its count
constexpr Cost kFewestStatic = bits(512);  ///< what costs less is not split further, by static bits
constexpr Cost kFewestDynamic = bits(48);  ///< and by dynamic bits

/// Bits that the symbols take with a distribution of their own, and that the distribution takes.
template <std::size_t N>
Cost cost_of(const Counts<N>& counts) {
  std::uint64_t total = 0;
  Cost sum = 0;
  for (const std::uint32_t n : counts) {
    if (n == 0) continue;
    total += n;
    sum += kSymbol + log2_of(n) / 2 - n_log_n(n);
  }
  return total == 0 ? 0 : sum - kSymbol + n_log_n(total) - log2_of(total) / 2;
}

template <std::size_t N>
void add_to(Counts<N>& sum, const Counts<N>& counts) {
  for (unsigned s = 0; s < N; ++s) sum[s] += counts[s];
}

/// Grows one pair of trees. Leaves of second trees name their counts in `leaves`.
template <std::size_t N>
class TreeGrower {
 public:
  using Entries = std::span<Sample<N>>;

  TreeGrower(ContextTrees& trees, const ContextBits& bits)
      : trees_(trees), bits_(bits), place_(std::size_t{1} << kDynamicBits, kNowhere) {}

  /// `events`: ascending.
  void grow(std::span<const Entry> events) {
    events_ = events;
    // The first tree sees the static bits alone: contexts that agree on them are one.
    std::vector<Sample<N>> statics;
    for (std::size_t i = 0; i < events.size(); ++i) {
      const std::uint32_t context = static_of(events[i].event);
      if (statics.empty() || statics.back().context != context) {
        first_[context] = static_cast<std::uint32_t>(i);
        statics.push_back({context, {}});
      }
      statics.back().symbols[symbol_of(events[i].event)] += events[i].count;
    }
    Cost cost = 0;
    trees_.root = split_static(statics, total_of(statics), bits_.statics, cost);
  }

  std::vector<Counts<N>> leaves;

 private:
  struct Split {
    int bit = -1;                     ///< -1: none
    std::uint32_t useful = 0;         ///< bits in which the entries differ
    std::array<Counts<N>, 2> sums{};  ///< of both sides
  };
  static constexpr std::uint32_t kNowhere = ~std::uint32_t{0};

  /// The bit, of those in `asked`, that shortens the description most, to less than `bar`. `sum`:
  /// of all entries.
  static Split best_split(Entries entries, const Counts<N>& sum, std::uint32_t asked, Cost bar) {
    Split best;
    std::uint32_t all = ~std::uint32_t{0};
    std::uint32_t any = 0;
    for (const Sample<N>& entry : entries) {
      all &= entry.context;
      any |= entry.context;
    }
    best.useful = asked & any & ~all;
    std::array<Counts<N>, kStaticBits> ones;
    for (std::uint32_t rest = best.useful; rest != 0; rest &= rest - 1)
      ones[static_cast<unsigned>(std::countr_zero(rest))] = {};
    for (const Sample<N>& entry : entries) {
      for (std::uint32_t rest = entry.context & best.useful; rest != 0; rest &= rest - 1) {
        add_to(ones[static_cast<unsigned>(std::countr_zero(rest))], entry.symbols);
      }
    }
    Cost least = bar;
    for (std::uint32_t rest = best.useful; rest != 0; rest &= rest - 1) {
      const auto bit = static_cast<unsigned>(std::countr_zero(rest));
      Counts<N> zeros;
      for (unsigned s = 0; s < N; ++s) zeros[s] = sum[s] - ones[bit][s];
      const Cost cost = cost_of(zeros) + cost_of(ones[bit]);
      if (cost < least) {
        least = cost;
        best.bit = static_cast<int>(bit);
        best.sums = {zeros, ones[bit]};
      }
    }
    return best;
  }

  static Counts<N> total_of(Entries entries) {
    Counts<N> sum{};
    for (const Sample<N>& entry : entries) add_to(sum, entry.symbols);
    return sum;
  }

  /// Moves the entries with that bit to the end.
  static std::array<Entries, 2> partition(Entries entries, unsigned bit) {
    const auto middle = std::partition(entries.begin(), entries.end(), [bit](const Sample<N>& e) {
      return (e.context >> bit & 1) == 0;
    });
    return {Entries{entries.begin(), middle}, Entries{middle, entries.end()}};
  }

  std::uint32_t add_node(const TreeNode& node) {
    trees_.nodes.push_back(node);
    return static_cast<std::uint32_t>(trees_.nodes.size() - 1);
  }

  /// What a subtree has added, which can be taken back, the last first.
  struct Mark {
    std::size_t nodes, leaves;
  };
  Mark mark() const { return {trees_.nodes.size(), leaves.size()}; }
  void take_back(const Mark& mark) {
    trees_.nodes.resize(mark.nodes);
    leaves.resize(mark.leaves);
  }

  /// `entries` are static contexts. Grown by what they cost alone; where a split gave two classes
  /// that cost less as one, it is taken back.
  std::uint32_t split_static(Entries entries, const Counts<N>& sum, std::uint32_t asked,
                             Cost& cost) {
    const Cost leaf = cost_of(sum) + kLeaf;
    const Split split = leaf < kFewestStatic
                            ? Split{}
                            : best_split(entries, sum, asked, std::numeric_limits<Cost>::max());
    if (split.bit < 0) {
      ++classes_;
      return one_class(entries, cost);
    }
    const Mark before = mark();
    const std::size_t classes = classes_;
    const auto sides = partition(entries, static_cast<unsigned>(split.bit));
    TreeNode node{split.bit, {}};
    std::array<Cost, 2> costs{};
    for (const unsigned side : {0u, 1u}) {
      node.next[side] = split_static(sides[side], split.sums[side],
                                     split.useful & ~(1u << split.bit), costs[side]);
    }
    cost = kSplit + costs[0] + costs[1];
    if (classes_ - classes > 2 && cost < leaf) return add_node(node);
    const std::vector<TreeNode> nodes(
        trees_.nodes.begin() + static_cast<std::ptrdiff_t>(before.nodes), trees_.nodes.end());
    const std::vector<Counts<N>> counts(leaves.begin() + static_cast<std::ptrdiff_t>(before.leaves),
                                        leaves.end());
    take_back(before);
    Cost whole = 0;
    const std::uint32_t root = one_class(entries, whole);
    if (whole <= cost) {
      classes_ = classes + 1;
      cost = whole;
      return root;
    }
    take_back(before);
    trees_.nodes.insert(trees_.nodes.end(), nodes.begin(), nodes.end());
    leaves.insert(leaves.end(), counts.begin(), counts.end());
    return add_node(node);
  }

  /// A leaf of the first tree with its second tree, which sees the dynamic bits alone.
  std::uint32_t one_class(Entries statics, Cost& cost) {
    std::vector<Sample<N>> entries;
    for (const Sample<N>& one : statics) {
      for (std::size_t i = first_[one.context];
           i < events_.size() && static_of(events_[i].event) == one.context; ++i) {
        const std::uint32_t dynamic = dynamic_of(events_[i].event);
        if (place_[dynamic] == kNowhere) {
          place_[dynamic] = static_cast<std::uint32_t>(entries.size());
          entries.push_back({dynamic, {}});
        }
        entries[place_[dynamic]].symbols[symbol_of(events_[i].event)] += events_[i].count;
      }
    }
    for (const Sample<N>& entry : entries) place_[entry.context] = kNowhere;
    class_bits_ = 0;
    const std::uint32_t root = split_dynamic(entries, total_of(entries), bits_.dynamics, cost);
    cost += bits(1);
    return add_node({-1, {root, 0}});
  }

  /// A second tree: split as long as that pays at once.
  std::uint32_t split_dynamic(Entries entries, const Counts<N>& sum, std::uint32_t asked,
                              Cost& cost) {
    const Cost leaf = cost_of(sum) + kLeaf;
    if (std::popcount(class_bits_) >= static_cast<int>(kMostDynamic)) asked &= class_bits_;
    const Split split = leaf < kFewestDynamic
                            ? Split{}
                            : best_split(entries, sum, asked, leaf - kSplit - 2 * kLeaf);
    if (split.bit >= 0) {
      const Mark before = mark();
      const std::uint32_t bits_before = class_bits_;
      class_bits_ |= 1u << split.bit;
      const auto sides = partition(entries, static_cast<unsigned>(split.bit));
      TreeNode node{split.bit, {}};
      std::array<Cost, 2> costs{};
      // The larger side chooses the bits of the class first.
      const unsigned larger = sides[1].size() > sides[0].size() ? 1 : 0;
      for (const unsigned side : {larger, 1 - larger}) {
        node.next[side] = split_dynamic(sides[side], split.sums[side],
                                        split.useful & ~(1u << split.bit), costs[side]);
      }
      cost = kSplit + costs[0] + costs[1];
      if (cost < leaf) return add_node(node);
      take_back(before);
      class_bits_ = bits_before;
    }
    cost = leaf;
    leaves.push_back(sum);
    return add_node({-1, {static_cast<std::uint32_t>(leaves.size() - 1), 0}});
  }

  ContextTrees& trees_;
  ContextBits bits_;
  std::span<const Entry> events_;
  std::array<std::uint32_t, std::size_t{1} << kStaticBits>
      first_{};                       ///< of events_, for each static context
  std::vector<std::uint32_t> place_;  ///< of one_class: where each dynamic context is
  std::size_t classes_ = 0;
  std::uint32_t class_bits_ = 0;  ///< dynamic bits of the class that is grown
};

/// Makes the counts that the leaves of second trees name into distributions.
void name_distributions(ContextTrees& trees, std::uint32_t node, bool is_static,
                        std::span<const std::uint32_t> distributions) {
  TreeNode& at = trees.nodes[node];
  if (at.bit >= 0) {
    for (const std::uint32_t next : at.next)
      name_distributions(trees, next, is_static, distributions);
  } else if (is_static) {
    name_distributions(trees, at.next[0], false, distributions);
  } else {
    at.next[0] = distributions[at.next[0]];
  }
}

template <std::size_t N>
ContextTrees grow_trees(std::span<const Entry> events, const ContextBits& bits,
                        std::uint32_t possible) {
  ContextTrees trees;
  const auto grower = std::make_unique<TreeGrower<N>>(trees, bits);
  grower->grow(events);
  Clustering<N> clusters(grower->leaves, possible);
  name_distributions(trees, trees.root, true, clusters.nearest);
  trees.distributions = std::move(clusters.distributions);
  return trees;
}

}  // namespace

ContextModel train(const EventCounts& events, const NumberCounts& numbers,
                   const ContextBits& bits) {
  const std::vector<Entry> entries = events.entries();
  const auto others = std::ranges::partition_point(
      entries, [](const Entry& entry) { return static_of(entry.event) >> kDepth == 0; });
  std::array<ContextTrees, 2> trees{
      grow_trees<8>({entries.begin(), others}, bits, kPossible[0]),
      grow_trees<kSymbols>({others, entries.end()}, bits, kPossible[1])};
  std::array<Distribution, kNumberKinds> widths{};
  for (unsigned kind = 0; kind < kNumberKinds; ++kind)
    widths[kind] = fit_distribution(numbers[kind], 0xffff);
  return ContextModel(std::move(trees), widths);
}

}  // namespace cvr::codecs::csgv_ctx
