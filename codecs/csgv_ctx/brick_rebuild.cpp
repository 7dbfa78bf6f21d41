#include "codecs/csgv_ctx/brick_rebuild.hpp"

#include <algorithm>
#include <bit>

#include "codecs/csgv_ctx/reference.hpp"

namespace cvr::codecs::csgv_ctx {

using namespace csgv;

namespace {

class BrickRebuilder {
 public:
  BrickRebuilder(const ContextModel& model, std::span<const std::uint32_t> palette,
                 std::span<const std::uint8_t> stream, const Validity& validity,
                 BrickWorkspace& workspace, SymbolTally* tally)
      : model_(model),
        palette_(palette),
        in_(stream),
        validity_(validity),
        grid_(workspace.grid),
        active_(workspace.active[0].data()),
        next_(workspace.active[1].data()),
        tally_(tally) {}

  BrickError run(unsigned target);

 private:
  unsigned block(unsigned level, std::uint32_t n, unsigned valid);
  std::uint32_t palette_label(unsigned operation);
  std::uint32_t reference();

  const ContextModel& model_;
  std::span<const std::uint32_t> palette_;
  StreamDecoder in_;
  const Validity& validity_;
  LabelGrid& grid_;
  std::uint32_t* active_;
  std::uint32_t* next_;
  SymbolTally* tally_;        ///< counts the symbols, or nullptr
  std::uint32_t in_use_ = 1;  ///< palette entries
  bool bad_ = false;
};

/// Entries before the newest, of an operation "delta".
std::uint32_t BrickRebuilder::reference() {
  const std::uint32_t bound = in_use_ - 1;
  if (bound < 2) return 1;
  const unsigned kind = number_class(bound);
  const unsigned width = in_.next(model_.number(kind));
  if (tally_ != nullptr) {
    tally_->add(model_.first_number() + kind, width);
    tally_->add_plain(bits_below(width));
  }
  std::uint32_t value = width == 0 || width == kWide ? 0 : 1;
  for (unsigned left = bits_below(width); left > 0;) {
    const unsigned count = std::min(left, kProbabilityBits);
    value = value << count | in_.bits(count);
    left -= count;
  }
  return value + 1;
}

std::uint32_t BrickRebuilder::palette_label(unsigned operation) {
  std::uint32_t entry = in_use_ - 1;
  if (operation == kAdvance) {
    bad_ |= in_use_ == palette_.size();
    if (!bad_) entry = in_use_++;
  } else if (operation == kDelta) {
    const std::uint32_t distance = reference();
    bad_ |= distance > entry;
    if (!bad_) entry -= distance;
  }
  return palette_[entry];
}

/// The children of node n of a level; gives those with a stop bit.
unsigned BrickRebuilder::block(unsigned level, std::uint32_t n, unsigned valid) {
  std::uint32_t* nodes = grid_.labels(level + 1);
  const Block block = Block::at(n, level, grid_.labels(level), nodes, nodes_of_level(level) - 1,
                                validity_.whole(), validity_);
  std::array<std::array<std::uint32_t, 8>, 4>
      choices;  // by operation: the parent's label, the candidates
  Lanes::broadcast(block.parent).store(choices[kParent].data());
  for (unsigned a = 0; a < 3; ++a) block.candidates[a].store(choices[kNeighbourX + a].data());
  const std::uint32_t depth = depth_of(level + 1, grid_.levels()) << kDepth;
  std::uint32_t last = palette_[in_use_ - 1];
  const auto known = [&] {
    const Lanes lanes = Lanes::broadcast(last);
    return last == block.parent
               ? 0xffu
               : block.candidates[0].equal(lanes) | block.candidates[1].equal(lanes) |
                     block.candidates[2].equal(lanes);
  };
  unsigned last_is_known = known();
  std::uint32_t palette_state =
      (in_use_ == palette_.size() ? 1u : 0u) << kExhausted | (in_use_ == 1 ? 1u : 0u) << kSingle;
  unsigned other = 0;  // children that do not have the parent's label
  std::uint32_t newest = 0;
  unsigned stops = 0;
  for (unsigned left = valid; left != 0; left &= left - 1) {
    const auto c = static_cast<unsigned>(std::countr_zero(left));
    std::uint32_t dynamic = std::uint32_t{kSiblings[other].earlier[c]} << kEarlier |
                            (last_is_known >> c & 1) << kLastIsKnown | palette_state;
    if (other != 0) {
      for (unsigned a = 0; a < 3; ++a)
        dynamic |= (choices[kNeighbourX + a][c] == newest ? 1u : 0u) << (kNewestIs + a);
      dynamic |= (newest == last ? 1u : 0u) << kNewestIsLast;
    }
    const std::uint32_t row = model_.row(block.static_bits(c) | depth, dynamic);
    const unsigned symbol = in_.next(model_.distribution(row));
    if (tally_ != nullptr) tally_->add(row, symbol);
    const unsigned operation = symbol & 7;
    stops |= symbol >> 3 << c;
    std::uint32_t label;
    if (operation < kAdvance) {
      label = choices[operation][c];
    } else {
      label = palette_label(operation);
      if (operation == kAdvance) {
        last = label;
        last_is_known = known();
        palette_state = (in_use_ == palette_.size() ? 1u : 0u) << kExhausted;
      }
    }
    const bool differs = label != block.parent;
    bad_ |= differs != (operation != kParent);
    other |= (differs ? 1u : 0u) << c;
    if (differs) newest = label;
    nodes[8 * n + c] = label;
  }
  return stops;
}

BrickError BrickRebuilder::run(unsigned target) {
  const std::uint32_t root = palette_[0];
  grid_.labels(0)[0] = root;
  if (palette_.size() == 1) {
    std::fill_n(grid_.labels(target), nodes_of_level(target), root);
    return nullptr;
  }
  std::uint32_t count = 1;
  active_[0] = 0;
  for (unsigned level = 0; level < target; ++level) {
    const bool finest = level + 2 == grid_.levels();
    std::uint32_t next_count = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      const std::uint32_t n = active_[k];
      const unsigned valid = validity_.children(level, n);
      const unsigned stops = block(level, n, valid);
      if (finest) continue;
      for (unsigned rest = stops; rest != 0; rest &= rest - 1) {
        const std::uint32_t child = 8 * n + static_cast<std::uint32_t>(std::countr_zero(rest));
        for (unsigned l = level + 2; l <= target; ++l) {
          const std::uint32_t below = nodes_of_level(l - level - 1);
          std::fill_n(grid_.labels(l) + std::size_t{child} * below, below,
                      grid_.labels(level + 1)[child]);
        }
      }
      for (unsigned open = valid & ~stops; open != 0; open &= open - 1) {
        next_[next_count++] = 8 * n + static_cast<std::uint32_t>(std::countr_zero(open));
      }
    }
    if (bad_) return "a symbol that no encoder writes";
    std::swap(active_, next_);
    count = next_count;
  }
  if (target + 1 == grid_.levels() && !in_.at_end())
    return "the stream does not end with its last symbol";
  return nullptr;
}

}  // namespace

BrickError rebuild_brick(const ContextModel& model, std::span<const std::uint32_t> palette,
                         std::span<const std::uint8_t> stream, const Validity& validity,
                         unsigned target, BrickWorkspace& workspace, SymbolTally* tally) {
  return BrickRebuilder(model, palette, stream, validity, workspace, tally).run(target);
}

}  // namespace cvr::codecs::csgv_ctx
