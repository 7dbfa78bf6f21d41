#include "tests/samples/cuckoo.hpp"

#include <algorithm>
#include <bit>

#include "shaders/shared/shared.hpp"

namespace cvr::samples {

namespace {

std::uint32_t bits_of(std::uint32_t size) {
  return static_cast<std::uint32_t>(std::bit_width(size - 1));
}

std::uint32_t first_of(const CuckooCell& cell, std::uint32_t size) {
  return shaders::cvr_cuckoo_first(cell.x, cell.y, cell.z, bits_of(size), size);
}

}  // namespace

CuckooTable::CuckooTable(std::uint32_t size) : size_(size), bits_(bits_of(size)), entries_(size) {}

std::uint32_t CuckooTable::first(const CuckooCell& cell) const { return first_of(cell, size_); }

std::uint32_t CuckooTable::second_of(std::uint32_t key, std::uint32_t first) const {
  return shaders::cvr_cuckoo_second(key, first, bits_, size_);
}

std::uint32_t CuckooTable::second(const CuckooCell& cell) const {
  return second_of(key(cell), first(cell));
}

std::uint32_t CuckooTable::key(const CuckooCell& cell) {
  return shaders::cvr_cuckoo_key(cell.x, cell.y, cell.z, cell.lod);
}

std::optional<std::uint32_t> CuckooTable::find(const CuckooCell& cell) const {
  const std::uint32_t wanted = key(cell);
  for (const bool moved : {false, true}) {
    const auto& entry = entries_[moved ? second(cell) : first(cell)];
    if (entry && entry->key == wanted && entry->moved == moved) return entry->code;
  }
  return std::nullopt;
}

void CuckooTable::insert(const CuckooCell& cell, std::uint32_t code) {
  const std::uint32_t position = first(cell);
  const auto before = std::exchange(entries_[position], Entry{key(cell), code, false});
  if (!before) return;
  if (before->moved) {
    ++losses_;
    return;
  }
  ++ejections_;
  auto& there = entries_[second_of(before->key, position)];
  if (there) ++losses_;
  there = Entry{before->key, before->code, true};
}

std::uint64_t CuckooTable::occupied() const {
  return static_cast<std::uint64_t>(
      std::ranges::count_if(entries_, [](const auto& entry) { return entry.has_value(); }));
}

std::optional<KeyCollision> find_key_collision(const std::vector<CuckooCell>& cells,
                                               std::uint32_t least_size) {
  std::vector<std::pair<std::uint32_t, std::size_t>> keys;
  for (std::size_t i = 0; i < cells.size(); ++i) keys.emplace_back(CuckooTable::key(cells[i]), i);
  std::ranges::sort(keys);
  std::vector<std::pair<CuckooCell, CuckooCell>> same;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].first == keys[i - 1].first)
      same.emplace_back(cells[keys[i - 1].second], cells[keys[i].second]);
  }
  for (std::uint32_t size = least_size; size < 2 * least_size; ++size) {
    for (const auto& [a, b] : same) {
      if (first_of(a, size) == first_of(b, size)) return KeyCollision{a, b, size};
    }
  }
  return std::nullopt;
}

std::optional<Eviction> find_eviction(const std::vector<CuckooCell>& cells, std::uint32_t size) {
  const CuckooTable table(size);
  std::vector<std::pair<std::uint32_t, std::size_t>> firsts;
  for (std::size_t i = 0; i < cells.size(); ++i) firsts.emplace_back(table.first(cells[i]), i);
  std::ranges::sort(firsts);
  for (std::size_t i = 2; i < firsts.size(); ++i) {
    if (firsts[i].first != firsts[i - 2].first) continue;
    const CuckooCell a = cells[firsts[i - 2].second], b = cells[firsts[i - 1].second],
                     c = cells[firsts[i].second];
    const std::uint32_t keys[] = {CuckooTable::key(a), CuckooTable::key(b), CuckooTable::key(c)};
    if (keys[0] == keys[1] || keys[1] == keys[2] || keys[0] == keys[2] ||
        table.second(a) == table.first(a))
      continue;
    const auto there = std::ranges::lower_bound(firsts, std::pair{table.second(a), std::size_t{0}});
    if (there != firsts.end() && there->first == table.second(a))
      return Eviction{a, b, c, cells[there->second]};
  }
  return std::nullopt;
}

}  // namespace cvr::samples
