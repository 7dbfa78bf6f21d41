// The voxel cache's table as a single invocation meets it: what shaders/caches/cuckoo_table.glsl
// does on the device, written again over the hash functions of shaders/shared/cuckoo.glsl; and
// cells that meet in it on purpose.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace cvr::samples {

/// A cell of a level of detail, by its first voxel.
struct CuckooCell {
  std::uint32_t x = 0, y = 0, z = 0, lod = 0;
  bool operator==(const CuckooCell&) const = default;
};

class CuckooTable {
 public:
  /// At least 2 entries.
  explicit CuckooTable(std::uint32_t size);

  std::uint32_t first(const CuckooCell& cell) const;
  std::uint32_t second(const CuckooCell& cell) const;
  static std::uint32_t key(const CuckooCell& cell);

  /// The code that the table holds for the cell, or for another one of the same key and position.
  std::optional<std::uint32_t> find(const CuckooCell& cell) const;
  void insert(const CuckooCell& cell, std::uint32_t code);

  std::uint64_t ejections() const {
    return ejections_;
  }                                                 ///< entries that moved to their second position
  std::uint64_t losses() const { return losses_; }  ///< entries that were overwritten
  std::uint64_t occupied() const;                   ///< entries that hold a cell

 private:
  struct Entry {
    std::uint32_t key, code;
    bool moved;
  };
  std::uint32_t second_of(std::uint32_t key, std::uint32_t first) const;

  std::uint32_t size_, bits_;
  std::vector<std::optional<Entry>> entries_;
  std::uint64_t ejections_ = 0, losses_ = 0;
};

/// Two cells that a table cannot tell apart, and the least size from `least_size` on at which they
/// are so: one key, one first position.
struct KeyCollision {
  CuckooCell a, b;
  std::uint32_t size;
};
/// Among `cells`, which have different voxels or levels; nothing if there is none below twice the
/// size.
std::optional<KeyCollision> find_key_collision(const std::vector<CuckooCell>& cells,
                                               std::uint32_t least_size);

/// Cells that push each other about: `a`, `b` and `c` have one first position and different keys,
/// `d` has its first where `a` has its second.
struct Eviction {
  CuckooCell a, b, c, d;
};
std::optional<Eviction> find_eviction(const std::vector<CuckooCell>& cells, std::uint32_t size);

}  // namespace cvr::samples
