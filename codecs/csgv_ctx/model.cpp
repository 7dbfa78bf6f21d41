#include "codecs/csgv_ctx/model.hpp"

#include <algorithm>
#include <bit>

namespace cvr::codecs::csgv_ctx {

namespace {

constexpr std::array<unsigned, 2> kTreeBits{
    kDepth, kStaticBits};              ///< static bits that a pair of trees may ask for
constexpr unsigned kMantissaBits = 3;  ///< of a frequency below its highest bit
constexpr unsigned kBitField = 4;
constexpr unsigned kWidthField = 4;
constexpr unsigned kRowField = 7;

/// A frequency that needs no more than kMantissaBits below its highest bit, rounded down.
std::uint16_t representable(std::uint32_t frequency) {
  const auto width = static_cast<unsigned>(std::bit_width(frequency));
  const unsigned dropped = width > kMantissaBits + 1 ? width - kMantissaBits - 1 : 0;
  return static_cast<std::uint16_t>(frequency >> dropped << dropped);
}

/// All symbols but the most frequent, which has the rest.
void write_distribution(const Distribution& distribution, std::uint32_t possible, BitWriter& out) {
  const auto& f = distribution.frequency;
  const auto most = static_cast<unsigned>(std::ranges::max_element(f) - f.begin());
  out.put(most, 4);
  for (unsigned s = 0; s < kSymbols; ++s) {
    if (s == most || (possible >> s & 1) == 0) continue;
    out.put(f[s] > 1 ? 1 : 0, 1);
    if (f[s] <= 1) continue;
    const auto below = static_cast<unsigned>(std::bit_width(f[s])) - 1;
    out.put(below, kWidthField);
    const unsigned kept = std::min(below, kMantissaBits);
    out.put((f[s] >> (below - kept)) & ((1u << kept) - 1), kept);
  }
}

bool read_distribution(std::uint32_t possible, BitReader& in, Distribution& distribution) {
  std::array<std::uint16_t, kSymbols> f{};
  const std::uint32_t most = in.get(4);
  std::uint32_t sum = 0;
  for (unsigned s = 0; s < kSymbols; ++s) {
    if (s == most || (possible >> s & 1) == 0) continue;
    std::uint32_t frequency = 1;
    if (in.get(1) == 1) {
      const std::uint32_t below = in.get(kWidthField);
      const unsigned kept = std::min(below, kMantissaBits);
      frequency = (1u << kept | in.get(kept)) << (below - kept);
    }
    sum += frequency;
    if (sum >= kProbabilitySum) return false;
    f[s] = static_cast<std::uint16_t>(frequency);
  }
  if ((possible >> most & 1) == 0) return false;
  f[most] = static_cast<std::uint16_t>(kProbabilitySum - sum);
  distribution = Distribution::of(f);
  return !in.failed();
}

void write_tree(const ContextTrees& trees, std::uint32_t node, bool is_static, BitWriter& out) {
  const TreeNode& at = trees.nodes[node];
  out.put(at.bit >= 0 ? 1 : 0, 1);
  if (at.bit >= 0) {
    out.put(static_cast<std::uint32_t>(at.bit), kBitField);
    for (const std::uint32_t next : at.next) write_tree(trees, next, is_static, out);
  } else if (is_static) {
    write_tree(trees, at.next[0], false, out);
  } else {
    out.put(at.next[0], static_cast<unsigned>(std::bit_width(trees.distributions.size() - 1)));
  }
}

const TreeNode& leaf_of(const ContextTrees& trees, std::uint32_t root, std::uint32_t bits) {
  const TreeNode* at = &trees.nodes[root];
  while (at->bit >= 0) at = &trees.nodes[at->next[bits >> at->bit & 1]];
  return *at;
}

/// All bits that a tree asks for.
std::uint32_t bits_of(const ContextTrees& trees, std::uint32_t root) {
  const TreeNode& at = trees.nodes[root];
  return at.bit < 0 ? 0 : 1u << at.bit | bits_of(trees, at.next[0]) | bits_of(trees, at.next[1]);
}

/// Reads trees as write_tree writes them, and asks no bit twice on a path: so its recursion is as
/// deep as there are bits.
class TreeReader {
 public:
  TreeReader(BitReader& in, ContextTrees& trees, unsigned static_bits)
      : in_(in), trees_(trees), static_bits_(static_bits) {}
  bool read() {
    trees_.root = node(true, 0);
    return !bad_ && !in_.failed();
  }

 private:
  std::uint32_t node(bool is_static, std::uint32_t asked) {
    const auto index = static_cast<std::uint32_t>(trees_.nodes.size());
    trees_.nodes.emplace_back();
    TreeNode at;
    if (bad_ || in_.failed()) return index;
    if (in_.get(1) == 1) {
      at.bit = static_cast<std::int32_t>(in_.get(kBitField));
      const std::uint32_t bit = 1u << at.bit;
      bad_ |= static_cast<unsigned>(at.bit) >= (is_static ? static_bits_ : kDynamicBits) ||
              (asked & bit) != 0;
      for (std::uint32_t& next : at.next) next = node(is_static, asked | bit);
    } else if (is_static) {
      at.next[0] = node(false, 0);
      const int dynamic = bad_ ? 0 : std::popcount(bits_of(trees_, at.next[0]));
      entries_ += std::uint64_t{1} << dynamic;
      bad_ |= dynamic > static_cast<int>(kMostDynamic) || entries_ > kMostRowEntries / 2;
    } else {
      at.next[0] = in_.get(static_cast<unsigned>(std::bit_width(trees_.distributions.size() - 1)));
      bad_ |= at.next[0] >= trees_.distributions.size();
    }
    trees_.nodes[index] = at;
    return index;
  }

  BitReader& in_;
  ContextTrees& trees_;
  unsigned static_bits_;
  std::uint64_t entries_ = 0;
  bool bad_ = false;
};

}  // namespace

Distribution fit_distribution(const std::array<std::uint64_t, kSymbols>& counts,
                              std::uint32_t possible) {
  std::uint64_t total = 0;
  auto most = static_cast<unsigned>(std::countr_zero(possible));
  for (unsigned s = 0; s < kSymbols; ++s) {
    if ((possible >> s & 1) == 0) continue;
    total += counts[s];
    if (counts[s] > counts[most]) most = s;
  }
  std::array<std::uint16_t, kSymbols> f{};
  std::uint32_t sum = 0;
  for (unsigned s = 0; s < kSymbols; ++s) {
    if (s == most || (possible >> s & 1) == 0) continue;
    // The others share less than the sum even where each is rounded up to 1.
    const std::uint64_t share = total == 0 ? 0 : counts[s] * (kProbabilitySum - kSymbols) / total;
    f[s] = std::max<std::uint16_t>(1, representable(static_cast<std::uint32_t>(share)));
    sum += f[s];
  }
  f[most] = static_cast<std::uint16_t>(kProbabilitySum - sum);
  return Distribution::of(f);
}

ContextModel::ContextModel(std::array<ContextTrees, 2> trees,
                           std::array<Distribution, kNumberKinds> numbers)
    : trees_(std::move(trees)), numbers_(numbers) {
  flatten();
}

void ContextModel::flatten() {
  classes_.assign(std::size_t{1} << kStaticBits, 0);
  rows_.clear();
  distributions_.clear();
  for (unsigned pair = 0; pair < 2; ++pair) {
    const ContextTrees& trees = trees_[pair];
    const auto first = static_cast<std::uint32_t>(distributions_.size());
    distributions_.insert(distributions_.end(), trees.distributions.begin(),
                          trees.distributions.end());
    std::vector<std::uint32_t> class_of(trees.nodes.size(), ~0u);  // of the roots of second trees
    const std::uint32_t begin = pair == 0 ? 0 : 1u << kDepth;
    const std::uint32_t end = pair == 0 ? 1u << kDepth : 1u << kStaticBits;
    for (std::uint32_t context = begin; context < end; ++context) {
      const std::uint32_t root = leaf_of(trees, trees.root, context).next[0];
      if (class_of[root] == ~0u) {
        const std::uint32_t asked = bits_of(trees, root);
        class_of[root] = static_cast<std::uint32_t>(rows_.size()) << kDynamicBits | asked;
        for (std::uint32_t i = 0; i < 1u << std::popcount(asked); ++i) {
          const auto bits = static_cast<std::uint32_t>(succinct::deposit_bits(i, asked));
          rows_.push_back(static_cast<std::uint8_t>(first + leaf_of(trees, root, bits).next[0]));
        }
      }
      classes_[context] = class_of[root];
    }
  }
  first_number_ = static_cast<std::uint32_t>(distributions_.size());
  distributions_.insert(distributions_.end(), numbers_.begin(), numbers_.end());
}

void ContextModel::write(BitWriter& out) const {
  for (unsigned pair = 0; pair < 2; ++pair) {
    out.put(static_cast<std::uint32_t>(trees_[pair].distributions.size() - 1), kRowField);
    for (const Distribution& d : trees_[pair].distributions)
      write_distribution(d, kPossible[pair], out);
    write_tree(trees_[pair], trees_[pair].root, true, out);
  }
  for (const Distribution& d : numbers_) write_distribution(d, 0xffff, out);
}

csgv::BrickError ContextModel::read(BitReader& in, ContextModel& model) {
  for (unsigned pair = 0; pair < 2; ++pair) {
    ContextTrees& trees = model.trees_[pair];
    trees.distributions.resize(in.get(kRowField) + 1);
    for (Distribution& d : trees.distributions) {
      if (!read_distribution(kPossible[pair], in, d))
        return "the frequencies of a distribution are more than 4096";
    }
    if (!TreeReader(in, trees, kTreeBits[pair]).read())
      return "a context tree asks for a bit twice or for too many, or ends early";
  }
  for (Distribution& d : model.numbers_) {
    if (!read_distribution(0xffff, in, d))
      return "the frequencies of a distribution are more than 4096";
  }
  if (in.failed()) return "the tables end early";
  model.flatten();
  return nullptr;
}

}  // namespace cvr::codecs::csgv_ctx
