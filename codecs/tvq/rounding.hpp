// Rounding: block means to DC codes, code vectors to the entries of a device or to the coefficients
// of a file.
#pragma once

#include <span>
#include <vector>

#include "codecs/tvq/codebook.hpp"
#include "codecs/tvq/samples.hpp"

namespace cvr::codecs::tvq {

inline constexpr unsigned kLeastDcBits = 6;

/// Of blocks of 64 samples.
std::vector<double> block_means(std::span<const float> samples);

struct DcLattice {
  unsigned bits;
  std::int32_t base;
  std::uint32_t step;
};

/// The finest lattice of that many bits that holds all means (in units) and the zero block.
DcLattice dc_lattice(const Domain& domain, std::span<const double> means, unsigned bits);
/// Mean squared, in samples.
double dc_error(const DcLattice& lattice, const Domain& domain);
/// The lattice of at most `bits` bits and the codes of all means.
void code_dc(const Domain& domain, std::span<const double> means, unsigned bits, SubVolume& part);
/// The decoded DC of a block, in samples.
float dc_value(const Domain& domain, const SubVolume& part, std::size_t block);

/// Bytes of an entry on a device: one where its rounding costs less than 2 % of the error; for u8
/// always.
unsigned entry_bytes(const Domain& domain, double largest, double error);
/// entry_bytes and scale of a book whose entries reach to `largest`, in samples.
void choose_entries(const Domain& domain, double largest, double error, Book& book);
/// The step of coefficients that costs 1 % of the error, in samples.
double coefficient_step(unsigned dimensions, double error);
/// Rounds code vectors of samples to entries; `code_vectors` become what the entries say.
void quantise_entries(const Domain& domain, double error, CodeVectors& code_vectors, Book& book);
/// Rounds code vectors of coefficients, so finely that it costs 1 % of the error, and projects
/// them; `code_vectors` become what the coefficients say. `keep`: the file stores them, else the
/// entries.
void quantise_coefficients(const Domain& domain, unsigned partition, const Basis& basis,
                           double error, bool keep, CodeVectors& code_vectors, Book& book);

}  // namespace cvr::codecs::tvq
