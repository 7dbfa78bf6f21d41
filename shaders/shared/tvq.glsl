// Voxels of vq, hvq and tvq: DC and one read into each of up to three books of block entries (Fout
// & Ma 2007, section 4.3).
//
// The words hold a row of CVR_TVQ_ROW words for each sub-volume, then books and records wherever
// the rows say:
//   0     first word of the records, one per block, x fastest, packed bit by bit: DC code, then the code of each book, low bits first
//   1     bits of a record
//   2     bits of the DC code
//   3     units of DC code 0 (as int)
//   4     units a DC code
//   5 + 4p  bits of the code of book p; 0: every code is 0
//   6 + 4p  first word of its entries
//   7 + 4p  units an entry
//   8 + 4p  bit 0: entries of 16 bits, else 8 (signed, low first); bit 1: 8 entries a code vector,
//   one an octant, else 64, one a
//           voxel; bit 2: the book is not there
// A record is read as two or three words, so two words more follow.
#ifndef CVR_TVQ_GLSL
#define CVR_TVQ_GLSL

#include "shaders/shared/portable.glsl"

#define CVR_TVQ_ROW 17u
#define CVR_TVQ_BOOKS 3u

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

// A row, read.
struct TvqRow {
  uint records;
  uint record_bits;  // at most 58
  uint dc_bits;
  uint dc_base;
  uint dc_step;
  uint bits[CVR_TVQ_BOOKS];
  uint first[CVR_TVQ_BOOKS];
  uint scale[CVR_TVQ_BOOKS];
  uint flags[CVR_TVQ_BOOKS];
};

CVR_FUNC TvqRow cvr_tvq_row(Words words, uint at) {
  TvqRow row;
  row.records = cvr_read(words, at);
  row.record_bits = cvr_read(words, at + 1u);
  row.dc_bits = cvr_read(words, at + 2u);
  row.dc_base = cvr_read(words, at + 3u);
  row.dc_step = cvr_read(words, at + 4u);
  CVR_UNROLL for (uint p = 0u; p < CVR_TVQ_BOOKS; ++p) {
    row.bits[p] = cvr_read(words, at + 5u + 4u * p);
    row.first[p] = cvr_read(words, at + 6u + 4u * p);
    row.scale[p] = cvr_read(words, at + 7u + 4u * p);
    row.flags[p] = cvr_read(words, at + 8u + 4u * p);
  }
  return row;
}

// Entry i of a book, 8 or 16 bits.
CVR_FUNC int cvr_tvq_entry(Words words, uint first, uint i, bool wide) {
  if (wide) return int(cvr_read(words, first + (i >> 1)) << (16u - 16u * (i & 1u))) >> 16;
  return int(cvr_read(words, first + (i >> 2)) << (24u - 8u * (i & 3u))) >> 24;
}

// The codes of block n of a sub-volume, the DC code lowest.
CVR_FUNC uint64_t cvr_tvq_record(Words words, TvqRow row, uint64_t n) {
  uint64_t bit = n * uint64_t(row.record_bits);
  uint word = row.records + uint(bit >> 5);
  uint shift = uint(bit) & 31u;
  uint64_t record = 0u;
  if (row.record_bits > 0u) record = cvr_word64(words, word) >> shift;
  if (shift + row.record_bits > 64u)
    record |= uint64_t(cvr_read(words, word + 2u)) << (64u - shift);
  return record;
}

CVR_FUNC int cvr_tvq_dc(TvqRow row, uint64_t record) {
  return int(row.dc_base) + int((uint(record) & ((1u << row.dc_bits) - 1u)) * row.dc_step);
}

// The sum of voxel i = x + 4y + 16z of block n of a sub-volume, from DC and the first `books`
// books.
CVR_FUNC int cvr_tvq_sum(Words words, TvqRow row, uint64_t n, uint i, uint books) {
  uint64_t record = cvr_tvq_record(words, row, n);
  int sum = cvr_tvq_dc(row, record);
  record >>= row.dc_bits;
  CVR_UNROLL for (uint p = 0u; p < CVR_TVQ_BOOKS; ++p) {
    uint code = uint(record) & ((1u << row.bits[p]) - 1u);
    record >>= row.bits[p];
    if (p < books && (row.flags[p] & 4u) == 0u) {
      uint entry = (row.flags[p] & 2u) != 0u
                       ? code * 8u + ((i >> 1) & 1u) + 2u * ((i >> 3) & 1u) + 4u * (i >> 5)
                       : code * 64u + i;
      sum +=
          cvr_tvq_entry(words, row.first[p], entry, (row.flags[p] & 1u) != 0u) * int(row.scale[p]);
    }
  }
  return sum;
}

// The sums of the four voxels 4j to 4j + 3 of a block, side by side along x: entries of 8 bits are
// one word a book.
struct TvqRun {
  int sum[4];
};
CVR_FUNC TvqRun cvr_tvq_run(Words words, TvqRow row, uint64_t n, uint j, uint books) {
  uint64_t record = cvr_tvq_record(words, row, n);
  TvqRun run;
  CVR_UNROLL for (uint x = 0u; x < 4u; ++x) run.sum[x] = cvr_tvq_dc(row, record);
  record >>= row.dc_bits;
  CVR_UNROLL for (uint p = 0u; p < CVR_TVQ_BOOKS; ++p) {
    uint code = uint(record) & ((1u << row.bits[p]) - 1u);
    record >>= row.bits[p];
    if (p < books && (row.flags[p] & 4u) == 0u) {
      bool octants = (row.flags[p] & 2u) != 0u;
      uint low;   // entries 0 and 1, or all four
      uint high;  // entries 2 and 3
      bool wide = (row.flags[p] & 1u) != 0u;
      uint entry = octants ? code * 8u + 2u * ((j >> 1) & 1u) + 4u * (j >> 3) : code * 64u + 4u * j;
      low = cvr_read(words, row.first[p] + (wide ? entry >> 1 : entry >> 2));
      high = wide && !octants ? cvr_read(words, row.first[p] + (entry >> 1) + 1u) : low;
      CVR_UNROLL for (uint x = 0u; x < 4u; ++x) {
        int value;
        if (wide) {
          uint half_ = octants ? x >> 1 : x & 1u;
          value = int((x < 2u ? low : high) << (16u - 16u * half_)) >> 16;
        } else {
          uint quarter = octants ? (entry & 3u) + (x >> 1) : x;
          value = int(low << (24u - 8u * quarter)) >> 24;
        }
        run.sum[x] += value * int(row.scale[p]);
      }
    }
  }
  return run;
}

CVR_FUNC int cvr_tvq_integer(TvqDomain domain, int sum) {
  int value = domain.zero + ((sum + int(1u << domain.fraction >> 1)) >> int(domain.fraction));
  return value < domain.low ? domain.low : value > domain.high ? domain.high : value;
}

// The products are exact (but for denormals), so a device may contract the last one and the
// addition.
CVR_FUNC float cvr_tvq_float(TvqDomain domain, int sum) {
  int inside = sum < domain.low ? domain.low : sum > domain.high ? domain.high : sum;
  return domain.offset + float(inside) * domain.step_a * domain.step_b;
}

#endif
