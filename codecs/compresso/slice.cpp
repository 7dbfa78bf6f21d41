#include "codecs/compresso/slice.hpp"

#include <algorithm>
#include <bit>
#include <type_traits>

#if defined(__AVX2__) && !defined(CVR_SCALAR)
#include <immintrin.h>
#define CVR_COMPRESSO_AVX2 1
#endif

namespace cvr::codecs::compresso {

namespace {

/// Bit i: a[i] != b[i], for n <= 64 labels.
template <class T>
std::uint64_t differences_of_some(const T* a, const T* b, std::uint64_t n) {
  std::uint64_t bits = 0;
  for (std::uint64_t i = 0; i < n; ++i) bits |= std::uint64_t{a[i] != b[i]} << i;
  return bits;
}

/// Bit i: a[i] != b[i], for 64 labels.
template <class T>
std::uint64_t differences(const T* a, const T* b) {
#if defined(CVR_COMPRESSO_AVX2)
  const auto equal = [](const T* p, const T* q) {
    const __m256i u = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
    const __m256i v = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(q));
    if constexpr (sizeof(T) == 1) return _mm256_cmpeq_epi8(u, v);
    if constexpr (sizeof(T) == 2) return _mm256_cmpeq_epi16(u, v);
    if constexpr (sizeof(T) == 4) return _mm256_cmpeq_epi32(u, v);
    if constexpr (sizeof(T) == 8) return _mm256_cmpeq_epi64(u, v);
  };
  constexpr int kLanes = 32 / sizeof(T);
  std::uint64_t same = 0;
  for (int i = 0; i < 64; i += kLanes) {
    std::uint64_t bits = 0;
    if constexpr (sizeof(T) == 1) {
      bits = static_cast<std::uint32_t>(_mm256_movemask_epi8(equal(a + i, b + i)));
    } else if constexpr (sizeof(T) == 2) {
      // One byte per label, put back in order after the packing within halves.
      const __m256i packed = _mm256_packs_epi16(equal(a + i, b + i), _mm256_setzero_si256());
      bits =
          static_cast<std::uint16_t>(_mm256_movemask_epi8(_mm256_permute4x64_epi64(packed, 0xd8)));
    } else if constexpr (sizeof(T) == 4) {
      bits =
          static_cast<std::uint8_t>(_mm256_movemask_ps(_mm256_castsi256_ps(equal(a + i, b + i))));
    } else {
      bits =
          static_cast<std::uint8_t>(_mm256_movemask_pd(_mm256_castsi256_pd(equal(a + i, b + i))));
    }
    same |= bits << i;
  }
  return ~same;
#else
  return differences_of_some(a, b, 64);
#endif
}

}  // namespace

template <class T>
void mark_boundaries(const T* labels, std::uint64_t width, std::uint64_t height,
                     BitPlane& boundary) {
  boundary.reset(width, height);
  for (std::uint64_t y = 0; y < height; ++y) {
    const T* row = labels + y * width;
    // The last row is compared with itself: no difference.
    const T* below = y + 1 < height ? row + width : row;
    std::uint64_t* out = boundary.row(y);
    for (std::uint64_t word = 0; word < boundary.row_words(); ++word) {
      const std::uint64_t x = word * 64;
      if (x + 65 <= width) {
        out[word] = differences(row + x, row + x + 1) | differences(row + x, below + x);
      } else {
        const std::uint64_t n = std::min<std::uint64_t>(64, width - x);
        out[word] = differences_of_some(row + x, row + x + 1, n - (x + n == width ? 1 : 0)) |
                    differences_of_some(row + x, below + x, n);
      }
    }
  }
}

template void mark_boundaries(const std::uint8_t*, std::uint64_t, std::uint64_t, BitPlane&);
template void mark_boundaries(const std::uint16_t*, std::uint64_t, std::uint64_t, BitPlane&);
template void mark_boundaries(const std::uint32_t*, std::uint64_t, std::uint64_t, BitPlane&);
template void mark_boundaries(const std::uint64_t*, std::uint64_t, std::uint64_t, BitPlane&);

void Components::find(const BitPlane& boundary) {
  runs_.clear();
  firsts_.clear();
  rows_.assign(1, 0);
  for (std::uint64_t y = 0; y < boundary.height(); ++y) {
    collect_runs(boundary, y);
    if (y > 0) join_rows(y);
  }
  // Roots come before the other runs of their component, so one pass in raster order numbers
  // everything.
  std::uint64_t y = 0;
  for (std::uint64_t i = 0; i < runs_.size(); ++i) {
    while (i >= rows_[y + 1]) ++y;
    Run& run = runs_[i];
    if (run.component == i) {
      run.component = firsts_.size();
      firsts_.push_back({run.begin, y});
    } else {
      run.component = runs_[run.component].component;
    }
  }
}

void Components::collect_runs(const BitPlane& boundary, std::uint64_t y) {
  const std::uint64_t* row = boundary.row(y);
  bool open = false;
  for (std::uint64_t word = 0; word < boundary.row_words(); ++word) {
    // Toggles: bit x is set where a run begins or ends.
    const std::uint64_t free = ~row[word] & boundary.inside(word);
    std::uint64_t toggles = free ^ ((free << 1) | std::uint64_t{open});
    for (; toggles != 0; toggles &= toggles - 1) {
      const std::uint64_t x = word * 64 + static_cast<std::uint64_t>(std::countr_zero(toggles));
      if (open) {
        runs_.back().end = x;
      } else {
        runs_.push_back({x, 0, runs_.size()});
      }
      open = !open;
    }
  }
  if (open) runs_.back().end = boundary.width();
  rows_.push_back(runs_.size());
}

std::uint64_t Components::root(std::uint64_t run) {
  while (runs_[run].component != run) {
    runs_[run].component = runs_[runs_[run].component].component;
    run = runs_[run].component;
  }
  return run;
}

void Components::join_rows(std::uint64_t y) {
  std::uint64_t above = rows_[y - 1], here = rows_[y];
  while (above < rows_[y] && here < rows_[y + 1]) {
    const Run& a = runs_[above];
    const Run& b = runs_[here];
    if (a.begin < b.end && b.begin < a.end) {
      const std::uint64_t u = root(above), v = root(here);
      runs_[std::max(u, v)].component = std::min(u, v);
    }
    if (a.end < b.end) {
      ++above;
    } else {
      ++here;
    }
  }
}

std::uint64_t Components::component_of(std::uint64_t x, std::uint64_t y) const {
  const Run* after = std::upper_bound(
      begin(y), end(y), x, [](std::uint64_t value, const Run& run) { return value < run.begin; });
  return after[-1].component;
}

}  // namespace cvr::codecs::compresso
