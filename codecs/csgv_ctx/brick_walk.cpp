#include "codecs/csgv_ctx/brick_walk.hpp"

#include <bit>

namespace cvr::codecs::csgv_ctx {

using namespace csgv;

unsigned BrickWalk::palette_operation(std::uint32_t label) {
  if (palette_.back() == label) return kLast;
  const auto in_use = static_cast<std::uint32_t>(palette_.size());
  if (const std::uint32_t entry = index_.find(label); entry != PaletteIndex::kNone) {
    references_.push_back({in_use - 1 - entry, in_use});
    return kDelta;
  }
  index_.remember(label, in_use);
  palette_.push_back(label);
  last_advance_ = event_count_ + 1;
  return kAdvance;
}

/// The children of node n of a level.
void BrickWalk::block(const LabelGrid& grid, const Validity& validity, unsigned level, std::uint32_t n, unsigned valid,
                      unsigned constant) {
  const std::uint32_t* nodes = grid.labels(level + 1);
  const std::uint32_t* labels = nodes + 8 * n;
  const Block block = Block::at(n, level, grid.labels(level), nodes, nodes_of_level(level) - 1, validity.whole(), validity);
  const Lanes lanes = Lanes::load(labels);
  const unsigned other = valid & ~lanes.equal(Lanes::broadcast(block.parent));
  const std::uint32_t depth = depth_of(level + 1, grid.levels()) << kDepth;
  const auto known = [&] {  // children of which the newest entry is the parent's label or a candidate's
    const Lanes last = Lanes::broadcast(palette_.back());
    if (palette_.back() == block.parent) return 0xffu;
    return block.candidates[0].equal(last) | block.candidates[1].equal(last) | block.candidates[2].equal(last);
  };
  unsigned last_is_known = known();
  std::array<unsigned, 3> copies{};  // children that take the label of a candidate
  std::array<std::array<std::uint32_t, 8>, 3> candidates;
  if (other != 0) {
    unsigned rest = other;
    for (unsigned a = 0; a < 3; ++a) {
      copies[a] = rest & lanes.equal(block.candidates[a]);
      rest &= ~copies[a];
      block.candidates[a].store(candidates[a].data());
    }
  }
  for (unsigned left = valid; left != 0; left &= left - 1) {
    const auto c = static_cast<unsigned>(std::countr_zero(left));
    std::uint32_t dynamic = static_cast<std::uint32_t>(kEarlierBits[c][other]) << kEarlier | (last_is_known >> c & 1) << kLastIsKnown |
                            (palette_.size() == 1 ? 1u : 0u) << kSingle;
    if (const unsigned earlier = other & ((1u << c) - 1); earlier != 0) {
      const std::uint32_t newest = labels[std::bit_width(earlier) - 1];
      for (unsigned a = 0; a < 3; ++a) dynamic |= (candidates[a][c] == newest ? 1u : 0u) << (kNewestIs + a);
      dynamic |= (newest == palette_.back() ? 1u : 0u) << kNewestIsLast;
    }
    unsigned operation = kParent;
    if ((other >> c & 1) != 0) {
      const unsigned a = (copies[0] >> c & 1) != 0 ? 0 : (copies[1] >> c & 1) != 0 ? 1 : (copies[2] >> c & 1) != 0 ? 2 : 3;
      operation = a < 3 ? kNeighbourX + a : palette_operation(labels[c]);
      if (operation == kAdvance) last_is_known = known();
    }
    events_[event_count_++] = make_event(block.static_bits(c) | depth, dynamic, operation | (constant >> c & 1) * kStopBit);
  }
}

void BrickWalk::run(const LabelGrid& grid, const Validity& validity) {
  event_count_ = 0;
  references_.clear();
  palette_.assign(1, grid.labels(0)[0]);
  last_advance_ = 0;
  if (grid.constant()) return;
  events_.resize(nodes_before_level(grid.levels()));
  index_.begin(nodes_of_level(grid.levels() - 1));
  index_.remember(palette_[0], 0);
  active_.assign(1, 0);
  for (unsigned level = 0; level + 1 < grid.levels(); ++level) {
    const bool finest = level + 2 == grid.levels();
    next_.clear();
    for (const std::uint32_t n : active_) {
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
  for (std::size_t i = last_advance_; i < event_count_; ++i) events_[i] |= make_event(0, 1u << kExhausted, 0);
}

}  // namespace cvr::codecs::csgv_ctx
