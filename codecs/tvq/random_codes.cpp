#include "codecs/tvq/random_codes.hpp"

#include <algorithm>

#include "codecs/tvq/rounding.hpp"
#include "volumes/generators/random.hpp"

namespace cvr::codecs::tvq {

namespace {

constexpr std::array<double, 2> kOrigin{0, 0};

/// The ends of the domain in samples.
std::array<double, 2> ends_of(const Domain& domain) {
  if (domain.type == VoxelType::kF32)
    return {domain.low / units_of(domain), domain.high / units_of(domain)};
  return {static_cast<double>(domain.low - domain.zero),
          static_cast<double>(domain.high - domain.zero)};
}

std::vector<std::uint16_t> random_codes(std::uint64_t blocks, std::uint64_t size,
                                        volumes::RandomSequence& random) {
  std::vector<std::uint16_t> codes(size == 1 ? 0 : blocks);
  for (std::uint16_t& code : codes) code = static_cast<std::uint16_t>(random.next() % size);
  return codes;
}

}  // namespace

BookSet random_books(const Scheme& scheme, const Domain& domain, const Options& options) {
  BookSet set;
  volumes::RandomSequence random(options.seed);
  const std::array<double, 2> ends = ends_of(domain);
  const double width = ends[1] - ends[0];
  for (unsigned p = 0; p < scheme.books; ++p) {
    Book& book = set.books[p];
    book.size = std::uint32_t{1} << options.bits[p];
    choose_entries(domain, std::max(width, 1.0) / (scheme.dc ? 8 : 2), width * width, book);
    const std::int64_t limit = book.entry_bytes == 1 ? 127 : 32767;
    book.entries.resize(std::size_t{book.size} * scheme.length[p]);
    for (std::int16_t& entry : book.entries) {
      entry = static_cast<std::int16_t>(
          static_cast<std::int64_t>(random.next() % static_cast<std::uint64_t>(2 * limit + 1)) -
          limit);
    }
    if (scheme.zero_vectors()) std::fill_n(book.entries.begin(), scheme.length[p], std::int16_t{0});
  }
  return set;
}

SubVolume random_part(const Scheme& scheme, const Domain& domain, const BookSet& set,
                      const Extent& grid, const Options& options, std::uint64_t part_number) {
  SubVolume part;
  part.blocks = grid;
  volumes::RandomSequence random(
      volumes::hash(options.seed, static_cast<std::int64_t>(part_number), 1));
  const std::array<double, 2> ends = ends_of(domain);
  if (scheme.dc) {
    const DcLattice lattice = dc_lattice(domain, ends[1] > ends[0] ? ends : kOrigin,
                                         options.dc_bits > 0 ? options.dc_bits : 8);
    part.dc_bits = lattice.bits, part.dc_base = lattice.base, part.dc_step = lattice.step;
    part.dc = random_codes(grid.voxels(), std::uint64_t{1} << part.dc_bits, random);
  } else {
    part.dc_base = static_cast<std::int32_t>((ends[0] + ends[1]) / 2 * units_of(domain));
  }
  for (unsigned p = 0; p < scheme.books; ++p)
    part.codes[p] = random_codes(grid.voxels(), set.books[p].size, random);
  return part;
}

}  // namespace cvr::codecs::tvq
