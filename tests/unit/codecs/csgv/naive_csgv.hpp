// The label multigrid and the operations of one brick, once more, by their definitions alone: plain
// 3D arrays, coordinates instead of Morton codes, one node at a time, no code of the codecs. Slow,
// and meant to be compared with by eye.
//
// Rules (CSGV-R paper, section 2.5, with the ties and borders of codecs/csgv/FORMAT.md):
//   label      the most frequent of the valid children, on a tie the first in the order x, y, z; outside: no vote
//   constant   all valid children have the same label and, above the second finest level, are constant
//   operation  the first that fits: parent, neighbour x, y, z, last, delta (if enabled), advance;
//   the root always advances
//   neighbour  the node beside the own 2x2x2 block: at -1 of the same level, or the parent of the
//   node at +1
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

namespace cvr::naive {

struct Node {
  std::uint32_t label = 0;
  bool valid = false;     ///< inside the volume
  bool constant = false;  ///< may carry a stop bit
};

/// A cube of nodes.
struct Level {
  int side = 0;
  std::vector<Node> nodes;
  Node& at(int x, int y, int z) { return nodes[x + side * (y + side * z)]; }
  const Node& at(int x, int y, int z) const { return nodes[x + side * (y + side * z)]; }
};

/// Levels of one brick, coarsest first.
using Grid = std::vector<Level>;
/// Label of the brick's voxel (x, y, z), and whether it lies inside the volume.
using Voxel = std::function<bool(int x, int y, int z, std::uint32_t& label)>;

inline Level coarser(const Level& fine, bool fine_is_finest) {
  Level coarse{fine.side / 2, std::vector<Node>(static_cast<std::size_t>(fine.side / 2) *
                                                (fine.side / 2) * (fine.side / 2))};
  for (int z = 0; z < coarse.side; ++z) {
    for (int y = 0; y < coarse.side; ++y) {
      for (int x = 0; x < coarse.side; ++x) {
        std::vector<Node> children;
        for (int c = 0; c < 8; ++c) {
          const Node& child = fine.at(2 * x + c % 2, 2 * y + c / 2 % 2, 2 * z + c / 4);
          if (child.valid) children.push_back(child);
        }
        Node& node = coarse.at(x, y, z);
        if (children.empty()) continue;
        node.valid = true;
        std::ptrdiff_t most = 0;
        for (const Node& child : children) {
          const auto votes = std::ranges::count(children, child.label, &Node::label);
          if (votes > most) {
            most = votes;
            node.label = child.label;
          }
        }
        node.constant = std::ranges::all_of(children, [&](const Node& child) {
          return child.label == node.label && (fine_is_finest || child.constant);
        });
      }
    }
  }
  return coarse;
}

inline Grid make_grid(int brick, const Voxel& voxel) {
  Grid grid;
  Level finest{brick, std::vector<Node>(static_cast<std::size_t>(brick) * brick * brick)};
  for (int z = 0; z < brick; ++z) {
    for (int y = 0; y < brick; ++y) {
      for (int x = 0; x < brick; ++x)
        finest.at(x, y, z).valid = voxel(x, y, z, finest.at(x, y, z).label);
    }
  }
  grid.push_back(finest);
  while (grid.front().side > 1) grid.insert(grid.begin(), coarser(grid.front(), grid.size() == 1));
  return grid;
}

/// For formats that code every node: nodes outside take their parent's label; with nothing inside
/// below, they are constant.
inline void fill_outside(Grid& grid) {
  for (std::size_t l = 1; l < grid.size(); ++l) {
    for (int z = 0; z < grid[l].side; ++z) {
      for (int y = 0; y < grid[l].side; ++y) {
        for (int x = 0; x < grid[l].side; ++x) {
          Node& node = grid[l].at(x, y, z);
          if (node.valid) continue;
          node.label = grid[l - 1].at(x / 2, y / 2, z / 2).label;
          node.constant = l + 1 < grid.size();
        }
      }
    }
  }
}

enum Code : std::uint8_t { kParent, kX, kY, kZ, kAdvance, kLast, kDelta };

struct Options {
  bool stop_bits, keep_outside, delta;
};

struct Position {
  int x, y, z;
};

/// What a brick's stream holds, in order.
struct Operations {
  struct Symbol {
    std::uint8_t code = 0;
    bool stop = false;
    bool digit = false;  ///< a digit of a distance: code 0..7, `stop` = more follow
    std::uint8_t nibble() const { return static_cast<std::uint8_t>(code + (stop ? 8 : 0)); }
  };
  std::vector<Symbol> symbols;
  std::vector<std::uint32_t> level_starts;
  std::vector<std::uint32_t> palette;
  std::vector<std::vector<Position>> nodes;  ///< coded nodes of each level, in stream order
};

/// The operation of one node; the palette is not yet advanced. `distance` is set for kDelta.
inline Code choose(const Grid& grid, std::size_t l, const Position& p, const Options& options,
                   const std::vector<std::uint32_t>& palette, std::size_t& distance) {
  const Level& level = grid[l];
  const Level& above = grid[l - 1];
  const std::uint32_t label = level.at(p.x, p.y, p.z).label;
  if (above.at(p.x / 2, p.y / 2, p.z / 2).label == label) return kParent;
  for (int axis = 0; axis < 3; ++axis) {
    Position q = p;
    int& along = axis == 0 ? q.x : axis == 1 ? q.y : q.z;
    const bool backwards = along % 2 == 0;
    along += backwards ? -1 : 1;
    if (along < 0 || along >= level.side) continue;
    const Node& neighbour =
        backwards ? level.at(q.x, q.y, q.z) : above.at(q.x / 2, q.y / 2, q.z / 2);
    if ((neighbour.valid || options.keep_outside) && neighbour.label == label)
      return static_cast<Code>(kX + axis);
  }
  if (palette.back() == label) return kLast;
  for (distance = 1; options.delta && distance < palette.size(); ++distance) {
    if (palette[palette.size() - 1 - distance] == label) return kDelta;
  }
  return kAdvance;
}

inline void append_distance(std::size_t distance, std::vector<Operations::Symbol>& symbols) {
  std::vector<Operations::Symbol> digits;
  for (std::size_t rest = distance - 1; digits.empty() || rest > 0; rest /= 8) {
    digits.insert(digits.begin(), {static_cast<std::uint8_t>(rest % 8), !digits.empty(), true});
  }
  symbols.insert(symbols.end(), digits.begin(), digits.end());
}

inline Operations make_operations(const Grid& grid, const Options& options) {
  Operations out;
  out.level_starts.push_back(0);
  out.palette.push_back(grid[0].at(0, 0, 0).label);
  out.symbols.push_back({kAdvance, options.stop_bits && grid[0].at(0, 0, 0).constant});
  out.nodes.push_back({{0, 0, 0}});
  for (std::size_t l = 1; l < grid.size(); ++l) {
    out.level_starts.push_back(static_cast<std::uint32_t>(out.symbols.size()));
    out.nodes.emplace_back();
    for (const Position& parent : out.nodes[l - 1]) {
      if (options.stop_bits && grid[l - 1].at(parent.x, parent.y, parent.z).constant) continue;
      for (int c = 0; c < 8; ++c) {
        const Position p{2 * parent.x + c % 2, 2 * parent.y + c / 2 % 2, 2 * parent.z + c / 4};
        const Node& node = grid[l].at(p.x, p.y, p.z);
        if (!node.valid && !options.keep_outside) continue;
        std::size_t distance = 0;
        const Code code = choose(grid, l, p, options, out.palette, distance);
        out.symbols.push_back({code, options.stop_bits && l + 1 < grid.size() && node.constant});
        out.nodes[l].push_back(p);
        if (code == kAdvance) out.palette.push_back(node.label);
        if (code == kDelta) append_distance(distance, out.symbols);
      }
    }
  }
  return out;
}

}  // namespace cvr::naive
