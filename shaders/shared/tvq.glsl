// Voxels of vq, hvq and tvq: DC and one read into each of up to three books of block entries (Fout & Ma 2007, section 4.3).
//
// The words hold a row of CVR_TVQ_ROW words for each sub-volume, then books and records wherever the rows say:
//   0     first word of the records, one a block, x fastest, packed bit by bit: DC code, then the code of each book, low bits first
//   1     bits of a record
//   2     bits of the DC code
//   3     units of DC code 0 (as int)
//   4     units a DC code
//   5 + 4p  bits of the code of book p; 0: every code is 0
//   6 + 4p  first word of its entries
//   7 + 4p  units an entry
//   8 + 4p  bit 0: entries of 16 bits, else 8 (signed, low first); bit 1: 8 entries a code vector, one an octant, else 64, one a
//           voxel; bit 2: the book is not there
// A record may end in the word after the last, so one word more follows.
#ifndef CVR_TVQ_GLSL
#define CVR_TVQ_GLSL

#define CVR_TVQ_ROW 17u

// How sums become voxels (codecs/tvq/format.hpp, Domain).
struct TvqDomain {
  uint fraction;
  int zero;
  int low;
  int high;
  float offset;
  float step_a;  // their product is a unit of f32; each is a power of two that is no denormal
  float step_b;
};

CVR_FUNC uint cvr_tvq_field(Words words, uint first, uint64_t bit, uint width) {
  if (width == 0u) return 0u;
  uint64_t pair = cvr_word64(words, first + uint(bit >> 5));
  return uint(pair >> (uint(bit) & 31u)) & ((1u << width) - 1u);
}

CVR_FUNC int cvr_tvq_entry(Words words, uint first, uint i, bool wide) {
  if (wide) return int(cvr_read(words, first + (i >> 1)) << (16u - 16u * (i & 1u))) >> 16;
  return int(cvr_read(words, first + (i >> 2)) << (24u - 8u * (i & 3u))) >> 24;
}

// The sum of voxel i = x + 4y + 16z of block n of the sub-volume whose row begins at a word, from DC and the first `books` books.
CVR_FUNC int cvr_tvq_sum(Words words, uint row, uint64_t n, uint i, uint books) {
  uint records = cvr_read(words, row);
  uint64_t bit = n * cvr_read(words, row + 1u);
  uint width = cvr_read(words, row + 2u);
  int sum = int(cvr_read(words, row + 3u)) + int(cvr_tvq_field(words, records, bit, width) * cvr_read(words, row + 4u));
  bit += width;
  for (uint p = 0u; p < books; ++p) {
    uint at = row + 5u + 4u * p;
    width = cvr_read(words, at);
    uint code = cvr_tvq_field(words, records, bit, width);
    bit += width;
    uint flags = cvr_read(words, at + 3u);
    if ((flags & 4u) != 0u) continue;
    uint entry = (flags & 2u) != 0u ? code * 8u + ((i >> 1) & 1u) + 2u * ((i >> 3) & 1u) + 4u * (i >> 5) : code * 64u + i;
    sum += cvr_tvq_entry(words, cvr_read(words, at + 1u), entry, (flags & 1u) != 0u) * int(cvr_read(words, at + 2u));
  }
  return sum;
}

CVR_FUNC int cvr_tvq_integer(TvqDomain domain, int sum) {
  int value = domain.zero + ((sum + int(1u << domain.fraction >> 1)) >> int(domain.fraction));
  return value < domain.low ? domain.low : value > domain.high ? domain.high : value;
}

// The products are exact (but for denormals), so a device may contract the last one and the addition.
CVR_FUNC float cvr_tvq_float(TvqDomain domain, int sum) {
  int inside = sum < domain.low ? domain.low : sum > domain.high ? domain.high : sum;
  return domain.offset + float(inside) * domain.step_a * domain.step_b;
}

#endif
