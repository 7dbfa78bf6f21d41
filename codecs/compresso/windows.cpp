#include "codecs/compresso/windows.hpp"

#include <algorithm>
#include <numeric>

namespace cvr::codecs::compresso {

namespace {

std::uint64_t low_bits(std::uint32_t n) {
  return n >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1;
}

/// n <= 64 bits of a row from bit x on; zeros behind its last word.
std::uint64_t extract(const std::uint64_t* row, std::uint64_t row_words, std::uint64_t x,
                      std::uint32_t n) {
  const std::uint64_t word = x / 64, shift = x % 64;
  std::uint64_t bits = row[word] >> shift;
  if (shift + n > 64 && word + 1 < row_words) bits |= row[word + 1] << (64 - shift);
  return bits & low_bits(n);
}

}  // namespace

void gather_windows(std::span<const BitPlane> planes, const WindowSize& window, std::uint64_t wy,
                    std::span<std::uint64_t> values) {
  std::ranges::fill(values, 0);
  for (std::uint32_t z = 0; z < planes.size(); ++z) {
    const BitPlane& plane = planes[z];
    const std::uint64_t rows = std::min<std::uint64_t>(window.y, plane.height() - wy * window.y);
    for (std::uint32_t y = 0; y < rows; ++y) {
      const std::uint64_t* row = plane.row(wy * window.y + y);
      const std::uint32_t shift = window.x * (y + window.y * z);
      if (window.x == 8) {
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(row);
        for (std::size_t wx = 0; wx < values.size(); ++wx)
          values[wx] |= std::uint64_t{bytes[wx]} << shift;
      } else {
        for (std::size_t wx = 0; wx < values.size(); ++wx) {
          values[wx] |= extract(row, plane.row_words(), wx * window.x, window.x) << shift;
        }
      }
    }
  }
}

void scatter_window(std::uint64_t value, const WindowSize& window, std::uint64_t wx,
                    std::uint64_t wy, std::span<BitPlane> planes) {
  if (value == 0) return;
  const std::uint64_t x = wx * window.x, word = x / 64, shift = x % 64;
  for (std::uint32_t z = 0; z < planes.size(); ++z) {
    BitPlane& plane = planes[z];
    const std::uint64_t rows = std::min<std::uint64_t>(window.y, plane.height() - wy * window.y);
    for (std::uint32_t y = 0; y < rows; ++y) {
      const std::uint64_t bits = value >> (window.x * (y + window.y * z)) & low_bits(window.x);
      std::uint64_t* row = plane.row(wy * window.y + y);
      row[word] |= (bits << shift) & plane.inside(word);
      if (shift + window.x > 64 && word + 1 < plane.row_words())
        row[word + 1] |= (bits >> (64 - shift)) & plane.inside(word + 1);
    }
  }
}

bool WindowStream::append(std::span<const std::uint64_t> values) {
  for (const std::uint64_t value : values) {
    if (value == 0) {
      if (++run_ == kMaxNumber) end_run();
      continue;
    }
    end_run();
    words_.push_back(2 * number_of(value));
  }
  return windows_.size() <= kMaxNumber;
}

void WindowStream::end_run() {
  if (run_ == 0) return;
  words_.push_back(static_cast<std::uint32_t>(2 * run_ + 1));
  has_empty_ = true;
  run_ = 0;
}

std::uint32_t WindowStream::number_of(std::uint64_t value) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t at = (value * 0x9e3779b97f4a7c15u >> 20) & mask;
  for (; slots_[at].value != 0; at = (at + 1) & mask) {
    if (slots_[at].value == value) return slots_[at].number;
  }
  const auto number = static_cast<std::uint32_t>(windows_.size());
  slots_[at] = {value, number};
  windows_.push_back(value);
  if (windows_.size() * 2 > slots_.size()) grow();
  return number;
}

void WindowStream::grow() {
  std::vector<Slot> old(slots_.size() * 2);
  old.swap(slots_);
  const std::size_t mask = slots_.size() - 1;
  for (const Slot& slot : old) {
    if (slot.value == 0) continue;
    std::size_t at = (slot.value * 0x9e3779b97f4a7c15u >> 20) & mask;
    while (slots_[at].value != 0) at = (at + 1) & mask;
    slots_[at] = slot;
  }
}

const std::vector<std::uint64_t>& WindowStream::sort() {
  end_run();
  slots_ = {};
  std::vector<std::uint32_t> order(windows_.size() - 1);
  std::iota(order.begin(), order.end(), 1u);
  std::ranges::sort(order, {}, [this](std::uint32_t number) { return windows_[number]; });
  renumbered_.assign(windows_.size(), 0);
  std::vector<std::uint64_t> sorted;
  sorted.reserve(windows_.size());
  if (has_empty_) sorted.push_back(0);
  for (const std::uint32_t number : order) {
    renumbered_[number] = static_cast<std::uint32_t>(sorted.size());
    sorted.push_back(windows_[number]);
  }
  windows_ = std::move(sorted);
  return windows_;
}

void WindowStream::write(std::uint64_t bytes, Buffer& out) const {
  const std::uint64_t longest = largest_in_word(bytes);
  const auto put = [&](std::uint64_t word) { out.append(&word, bytes); };
  for (const std::uint32_t word : words_) {
    if ((word & 1) == 0) {
      put(2 * std::uint64_t{renumbered_[word / 2]});
      continue;
    }
    std::uint64_t run = word / 2;
    for (; run > longest; run -= longest) put(2 * longest + 1);
    put(2 * run + 1);
  }
}

}  // namespace cvr::codecs::compresso
