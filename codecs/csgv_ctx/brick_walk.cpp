#include "codecs/csgv_ctx/brick_walk.hpp"

#include <bit>

namespace cvr::codecs::csgv_ctx {

using namespace csgv;

namespace {

constexpr std::size_t kMany = 4;   ///< palette entries of a block, where labels hardly repeat
constexpr std::size_t kAhead = 8;  ///< blocks, of which such walks ask for the palette index

}  // namespace

unsigned BrickWalk::palette_operation(std::uint32_t label) {
  if (palette_.back() == label) return kLast;
  const auto in_use = static_cast<std::uint32_t>(palette_.size());
  if (const std::uint32_t entry = index_.find_or_add(label, in_use); entry != PaletteIndex::kNone) {
    references_.push_back({in_use - 1 - entry, in_use});
    return kDelta;
  }
  palette_.push_back(label);
  return kAdvance;
}

/// The children of node n of a level, all eight at once but for those that need the palette.
void BrickWalk::block(const LabelGrid& grid, const Validity& validity, unsigned level,
                      std::uint32_t n, unsigned valid, unsigned constant) {
  const std::uint32_t* nodes = grid.labels(level + 1);
  const std::uint32_t* labels = nodes + 8 * n;
  const Block block = Block::at(n, level, grid.labels(level), nodes, nodes_of_level(level) - 1,
                                validity.whole(), validity);
  const Lanes lanes = Lanes::load(labels);
  const Lanes parent = Lanes::broadcast(block.parent);
  const Lanes as_parent = lanes.same(parent);
  const unsigned other = valid & ~lanes.equal(parent);
  Lanes last =
      Lanes::broadcast(palette_.back());  // the newest palette entry, as each child finds it
  Lanes single = Lanes::broadcast(palette_.size() == 1 ? 1u << kSingle : 0);
  Lanes operations = Lanes::broadcast(kParent);
  Lanes dynamic = Lanes::broadcast(0);
  if (other != 0) {
    unsigned unknown = other;  // children that have no candidate's label
    for (unsigned a = 3; a-- > 0;) {
      const Lanes copied = lanes.same(block.candidates[a]);
      unknown &= ~lanes.equal(block.candidates[a]);
      operations = operations.replaced(Lanes::broadcast(kNeighbourX + a), copied);
    }
    if (unknown != 0) {
      std::array<std::uint32_t, 8> of_palette{};
      for (unsigned left = unknown; left != 0; left &= left - 1) {
        const auto c = static_cast<unsigned>(std::countr_zero(left));
        of_palette[c] = palette_operation(labels[c]);
        if (of_palette[c] != kAdvance) continue;
        last_advance_ =
            event_count_ + static_cast<unsigned>(std::popcount(valid & ((2u << c) - 1)));
        const Lanes later = Lanes::where(0xffu & ~((2u << c) - 1));
        last = last.replaced(Lanes::broadcast(labels[c]), later);
        single = single.without(later);
      }
      operations = operations | Lanes::load(of_palette.data());
    }
    operations = operations.without(as_parent);
    const Siblings& siblings = kSiblings[other];
    const Lanes earlier = Lanes::of_bytes(std::bit_cast<std::uint64_t>(siblings.earlier));
    const Lanes newest =
        lanes.picked(Lanes::of_bytes(std::bit_cast<std::uint64_t>(siblings.newest)));
    for (unsigned a = 0; a < 3; ++a)
      dynamic =
          dynamic | (block.candidates[a].same(newest) & Lanes::broadcast(1u << (kNewestIs + a)));
    dynamic = dynamic | (last.same(newest) & Lanes::broadcast(1u << kNewestIsLast));
    dynamic = dynamic.without(earlier.same(Lanes::broadcast(0))) | earlier << kEarlier;
  }
  const Lanes known = last.same(parent) | last.same(block.candidates[0]) |
                      last.same(block.candidates[1]) | last.same(block.candidates[2]);
  dynamic = dynamic | single | (known & Lanes::broadcast(1u << kLastIsKnown));
  const Lanes symbols = operations | (Lanes::where(constant) & Lanes::broadcast(kStopBit));
  const Lanes statics =
      block.static_bits() | Lanes::broadcast(depth_of(level + 1, grid.levels()) << kDepth);
  const Lanes events = symbols | dynamic << kSymbolBits | statics << (kSymbolBits + kDynamicBits);
  if (valid == 0xff) {
    events.store(events_.data() + event_count_);
    event_count_ += 8;
    return;
  }
  std::array<Event, 8> all;
  events.store(all.data());
  for (unsigned left = valid; left != 0; left &= left - 1)
    events_[event_count_++] = all[static_cast<unsigned>(std::countr_zero(left))];
}

void BrickWalk::run(const LabelGrid& grid, const Validity& validity) {
  event_count_ = 0;
  references_.clear();
  palette_.assign(1, grid.labels(0)[0]);
  last_advance_ = 0;
  if (grid.constant()) return;
  events_.resize(nodes_before_level(grid.levels()));
  index_.begin(nodes_of_level(grid.levels() - 1));
  index_.find_or_add(palette_[0], 0);
  active_.assign(1, 0);
  for (unsigned level = 0; level + 1 < grid.levels(); ++level) {
    const bool finest = level + 2 == grid.levels();
    next_.clear();
    std::size_t entries = 0;  // before the last block
    for (std::size_t i = 0; i < active_.size(); ++i) {
      const std::uint32_t n = active_[i];
      if (palette_.size() - entries > kMany && i + kAhead < active_.size()) {
        const std::uint32_t* later = grid.labels(level + 1) + 8 * active_[i + kAhead];
        for (unsigned c = 0; c < 8; ++c) index_.prefetch(later[c]);
      }
      entries = palette_.size();
      const unsigned valid = validity.children(level, n);
      const unsigned constant = finest ? 0 : grid.constant_children(level, n) & valid;
      block(grid, validity, level, n, valid, constant);
      if (finest) continue;
      for (unsigned open = valid & ~constant; open != 0; open &= open - 1) {
        next_.push_back(8 * n + static_cast<std::uint32_t>(std::countr_zero(open)));
      }
    }
    std::swap(active_, next_);
  }
  for (std::size_t i = last_advance_; i < event_count_; ++i)
    events_[i] |= make_event(0, 1u << kExhausted, 0);
}

}  // namespace cvr::codecs::csgv_ctx
