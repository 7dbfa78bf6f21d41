// Windows: boxes of boundary bits as one number each, bit x + xs * (y + ys * z), and the list of
// those that occur.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codecs/compresso/format.hpp"
#include "codecs/compresso/slice.hpp"

namespace cvr::codecs::compresso {

/// The windows of row `wy` of one layer: planes[0 .. planes.size()) are its slices (fewer than
/// window.z at the far side).
void gather_windows(std::span<const BitPlane> planes, const WindowSize& window, std::uint64_t wy,
                    std::span<std::uint64_t> values);

/// Puts the bits of a window back; bits outside the planes are dropped.
void scatter_window(std::uint64_t value, const WindowSize& window, std::uint64_t wx,
                    std::uint64_t wy, std::span<BitPlane> planes);

/// Collects windows in raster order as words with provisional numbers, which are replaced when all
/// windows are known.
class WindowStream {
 public:
  /// Fails (false) when there are more distinct windows than words can tell apart.
  bool append(std::span<const std::uint64_t> values);
  /// Distinct windows; call once, after the last append. Renumbers.
  const std::vector<std::uint64_t>& sort();
  /// The words, each `bytes` wide (WindowSize::word_bytes).
  void write(std::uint64_t bytes, Buffer& out) const;

 private:
  std::uint32_t number_of(std::uint64_t value);
  void grow();
  void end_run();

  struct Slot {
    std::uint64_t value = 0;  ///< 0: free; the window without boundary is never looked up
    std::uint32_t number = 0;
  };
  static constexpr std::uint64_t kMaxNumber = 0x7fffffff;

  std::vector<Slot> slots_ = std::vector<Slot>(1024);
  std::vector<std::uint64_t> windows_{
      0};  ///< by number; 0 is the window without boundary, present or not
  std::vector<std::uint32_t> words_;  ///< as in the payload, with provisional numbers
  std::vector<std::uint32_t> renumbered_;
  std::uint64_t run_ = 0;
  bool has_empty_ = false;
};

}  // namespace cvr::codecs::compresso
