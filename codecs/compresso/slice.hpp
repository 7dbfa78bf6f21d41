// One slice (a plane of constant z): its boundary bits and the 4-connected components of its other
// voxels.
//
// Source: Compresso (Matejek et al., MICCAI 2017), sections on boundary maps and connected
// components. A voxel is boundary if it differs from its +x or +y neighbour in the slice; in the
// last column or row only the neighbour that exists counts. Hence two neighbouring voxels that are
// both not boundary carry the same label, and so does a component; and a boundary voxel whose left
// or upper neighbour is not boundary has that neighbour's label.
//
// Components are found over runs of voxels along x, not over voxels, and are numbered by their
// first voxel in raster order.
#pragma once

#include <cstdint>
#include <vector>

namespace cvr::codecs::compresso {

/// Rows of bits, 64 voxels a word, bit x % 64 of word x / 64; bits beyond the row are zero.
class BitPlane {
 public:
  void reset(std::uint64_t width, std::uint64_t height) {
    width_ = width;
    height_ = height;
    row_words_ = (width + 63) / 64;
    words_.assign(row_words_ * height, 0);
  }
  std::uint64_t width() const { return width_; }
  std::uint64_t height() const { return height_; }
  std::uint64_t row_words() const { return row_words_; }
  std::uint64_t* row(std::uint64_t y) { return words_.data() + y * row_words_; }
  const std::uint64_t* row(std::uint64_t y) const { return words_.data() + y * row_words_; }
  bool test(std::uint64_t x, std::uint64_t y) const {
    return (row(y)[x / 64] >> (x % 64) & 1) != 0;
  }
  /// The bits of word `word` of row y that lie inside the row.
  std::uint64_t inside(std::uint64_t word) const {
    const std::uint64_t left = width_ - word * 64;
    return left >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << left) - 1;
  }

 private:
  std::uint64_t width_ = 0, height_ = 0, row_words_ = 0;
  std::vector<std::uint64_t> words_;
};

/// Sets the boundary bits of a slice of labels.
template <class T>
void mark_boundaries(const T* labels, std::uint64_t width, std::uint64_t height,
                     BitPlane& boundary);

/// The boundary voxels of one word whose label does not follow from the left or the upper
/// neighbour: those that need a location.
inline std::uint64_t unresolved_bits(const BitPlane& boundary, std::uint64_t word,
                                     std::uint64_t y) {
  const std::uint64_t* row = boundary.row(y);
  const std::uint64_t left = (row[word] << 1) | (word == 0 ? 1 : row[word - 1] >> 63);
  const std::uint64_t up = y == 0 ? ~std::uint64_t{0} : boundary.row(y - 1)[word];
  return row[word] & left & up;
}

/// The voxels begin <= x < end of a row, none of them boundary, both neighbours boundary or
/// outside.
struct Run {
  std::uint64_t begin, end;
  std::uint64_t component;
};

class Components {
 public:
  void find(const BitPlane& boundary);
  std::uint64_t count() const { return firsts_.size(); }
  /// Runs of row y, ascending.
  const Run* begin(std::uint64_t y) const { return runs_.data() + rows_[y]; }
  const Run* end(std::uint64_t y) const { return runs_.data() + rows_[y + 1]; }
  /// The component of a voxel that is not boundary.
  std::uint64_t component_of(std::uint64_t x, std::uint64_t y) const;
  struct Voxel {
    std::uint64_t x, y;
  };
  /// The first voxel in raster order of each component.
  const std::vector<Voxel>& firsts() const { return firsts_; }

 private:
  std::uint64_t root(std::uint64_t run);
  void collect_runs(const BitPlane& boundary, std::uint64_t y);
  void join_rows(std::uint64_t y);

  std::vector<Run>
      runs_;  ///< while components are joined, `component` is a run of the same component, never a later one
  std::vector<std::uint64_t> rows_;
  std::vector<Voxel> firsts_;
};

}  // namespace cvr::codecs::compresso
