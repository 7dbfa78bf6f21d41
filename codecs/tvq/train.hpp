// Training of the books of one sub-volume.
#pragma once

#include "codecs/tvq/allocation.hpp"
#include "codecs/tvq/codebook.hpp"
#include "codecs/tvq/samples.hpp"

namespace cvr::codecs::tvq {

struct Options {
  TransformKind transform = TransformKind::kKltSeparable;
  double psnr = 0;  ///< dB, sets what a class may lose; 0: what the books will lose anyway
  double tau =
      0;  ///< what a class may lose, in root mean squared errors of the target; 0: tried out
  std::array<unsigned, kMaxBooks> bits{8, 8, 8};
  double rate = 0;            ///< bits per voxel of planes and books; 0: `bits`
  bool count_device = false;  ///< `rate` counts the books of a device instead of those of the file
  bool operational = true;    ///< bits by measured distortion instead of the model
  bool global = true;  ///< codes from the whole book instead of the chapter of the block's class
  bool classify = true;
  Initialisation initialisation = Initialisation::kSplit;
  bool best = false;         ///< all vectors and more iterations
  bool rough = false;        ///< a few iterations, to compare
  unsigned dc_bits = 0;      ///< 0: by the error of the books
  bool coefficients = true;  ///< books in the file as coefficients
  bool closed_loop = true;   ///< hvq: voxels relative to the coded octants
  std::uint64_t seed = 1;
  bool random_codes =
      false;  ///< nothing is trained: random codes into random books of `bits`, to time decoders
  const Basis* basis = nullptr;  ///< taken instead of one fitted to the blocks
};

/// Blocks whose vectors are not zero, for training: at most `most`, evenly spaced.
std::vector<std::uint32_t> sample_active(const Vectors& vectors, std::uint64_t most);
/// Those vectors, dimensions [first, first + dimensions), side by side.
std::vector<float> gather(const Vectors& vectors, std::span<const std::uint32_t> which,
                          unsigned first, unsigned dimensions);

/// How many training vectors a book of that many code vectors gets.
std::uint64_t training_size(const Options& options, std::uint64_t code_vectors);
unsigned training_iterations(const Options& options);

/// A book of at most 2^bits code vectors, the first of them zero, for all vectors alike.
CodeVectors train_book(const Vectors& vectors, unsigned bits, const Options& options,
                       std::uint64_t seed, unsigned threads);

/// What books of 2^0, 2^1, ... code vectors lose on all vectors: splits of a sample, an iteration
/// each, measured on vectors apart from the sample where there are enough.
std::vector<double> measured_curve(const Vectors& vectors, unsigned most_bits,
                                   const Options& options, unsigned threads);

/// The books of tvq: one chapter a class, composed, and codes of all blocks.
struct ClassifiedBooks {
  std::array<CodeVectors, kPartitions> books;
  std::array<std::vector<Chapter>, kPartitions> chapters;
};
/// `coefficients`: 64 a block in partition order; `classes`: one per block.
ClassifiedBooks train_chapters(std::span<const float> coefficients,
                               std::span<const std::uint8_t> classes,
                               const std::array<unsigned, kPartitions>& bits,
                               const Options& options, unsigned threads);
/// Codes of one partition: from the whole book, or from the chapter that the block's class uses (0
/// where it uses none).
std::vector<std::uint16_t> assign_codes(const CodeVectors& book, std::span<const Chapter> chapters,
                                        unsigned partition, std::span<const float> coefficients,
                                        std::span<const std::uint8_t> classes, bool global,
                                        unsigned threads);

/// The vectors of a partition.
Vectors partition_vectors(std::span<const float> coefficients, unsigned partition);

}  // namespace cvr::codecs::tvq
