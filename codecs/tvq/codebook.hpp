// Vector quantisation: nearest code vectors, the LBG iteration, and the ways to begin it (Linde,
// Buzo & Gray 1980; Equitz 1989; the principal-axis splits of Schneider & Westermann 2003).
//
// Everything here gives the same bits for any number of threads: sums run over the members of a
// cell in their order, in double precision, and of equals the first is taken.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace cvr::codecs::tvq {

/// `count` vectors of `dimensions` floats; vector n begins at data[n * stride].
struct Vectors {
  const float* data = nullptr;
  std::uint64_t count = 0;
  unsigned dimensions = 0;
  unsigned stride = 0;

  const float* operator[](std::uint64_t n) const { return data + n * stride; }
};

/// Code vectors one after the other.
struct CodeVectors {
  unsigned dimensions = 0;
  std::vector<float> values;

  std::uint32_t size() const { return static_cast<std::uint32_t>(values.size() / dimensions); }
  const float* operator[](std::uint32_t k) const {
    return values.data() + std::size_t{k} * dimensions;
  }
  float* operator[](std::uint32_t k) { return values.data() + std::size_t{k} * dimensions; }
  void append(const float* vector) { values.insert(values.end(), vector, vector + dimensions); }
  /// The first `count` of them.
  void resize(std::uint32_t count) { values.resize(std::size_t{count} * dimensions); }
};

/// A well mixed number of each number (splitmix64): what is random here is so by its place and a
/// seed.
std::uint64_t mix(std::uint64_t x);

double squared_distance(const float* a, const float* b, unsigned dimensions);

/// codes[n] = the code vector nearest to vectors[n]; of equals the lowest. Compares |c|^2 / 2 - x
/// c.
void find_nearest(const CodeVectors& book, const Vectors& vectors, std::span<std::uint16_t> codes,
                  unsigned threads);
/// Sum of the squared distances of vectors from their code vectors.
double total_distortion(const CodeVectors& book, const Vectors& vectors,
                        std::span<const std::uint16_t> codes, unsigned threads);

struct LbgOptions {
  unsigned iterations = 10;
  double tolerance = 1e-4;  ///< ends when the distortion falls by less than this part of it
  std::uint32_t fixed = 0;  ///< the first code vectors stay as they are
};

/// Lloyd's iteration from the vectors in `book`. An empty cell's code vector moves onto the member
/// that is farthest from its code vector in the cell of the largest distortion; where all
/// distortion is gone, code vectors without members are dropped and the book shrinks. Returns the
/// distortion after each assignment, which never rises.
std::vector<double> refine(CodeVectors& book, const Vectors& vectors, const LbgOptions& options,
                           unsigned threads);

/// A tree of cells, each cut through its centroid across its principal axis, the cell of the
/// largest distortion first. The leaves after any number of cuts are a codebook, so one run serves
/// all sizes.
class SplitTree {
 public:
  SplitTree(const Vectors& vectors, std::uint32_t leaves);
  /// Leaves that could be made: fewer than asked for where there are fewer distinct vectors.
  std::uint32_t leaves() const { return static_cast<std::uint32_t>(cuts_.size()) + 1; }
  /// The centroids of the first min(count, leaves()) >= 1 leaves.
  CodeVectors codebook(std::uint32_t count) const;

 private:
  struct Cut {
    std::uint32_t leaf;  ///< this leaf becomes `first`; `second` is appended
    std::vector<float> first, second;
  };
  unsigned dimensions_;
  std::vector<float> root_;
  std::vector<Cut> cuts_;
};

enum class Initialisation : std::uint8_t {
  kSplit,   ///< SplitTree
  kRandom,  ///< distinct vectors in a seeded order
  kScalar,  ///< the grid of independent scalar quantisers of the components
  kPnn,     ///< pairwise nearest neighbours, merged from at most 4096 vectors
};

/// At most `size` >= 1 code vectors to begin with. `vectors` must not be empty.
CodeVectors initial_codebook(Initialisation how, const Vectors& vectors, std::uint32_t size,
                             std::uint64_t seed);

}  // namespace cvr::codecs::tvq
