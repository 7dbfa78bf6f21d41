// The hash functions of the voxel cache (CSGV-R paper, section 4.1): positions in one table of
// `size` entries, and 31-bit keys.
//
// An entry has 64 bits: label code low, key high; bit 31 of the key is set where the entry lies at
// its second position. All ones = free; no key is all ones, so no entry looks free.
#ifndef CVR_CUCKOO_GLSL
#define CVR_CUCKOO_GLSL

#include "shaders/shared/pcg.glsl"
#include "shaders/shared/portable.glsl"

#define CVR_CUCKOO_SECOND 0x80000000u

// Positions of tables whose size is no power of two are not evenly used: the first 2^bits - size of
// them are twice as likely.
//
// The `bits` most significant bits of factor * x mod 2^32 (Dietzfelbinger et al. 1997); 1 <= bits
// <= 32.
CVR_FUNC uint cvr_hash_bits(uint factor, uint x, uint bits) { return (factor * x) >> (32u - bits); }

// x mod size for x < 2^bits, where 2^(bits-1) < size <= 2^bits.
CVR_FUNC uint cvr_fold(uint x, uint size) { return x >= size ? x - size : x; }

// First position of a cell; (x, y, z) its first voxel, so that cells of several levels of one
// region collide.
CVR_FUNC uint cvr_cuckoo_first(uint x, uint y, uint z, uint bits, uint size) {
  cvr_pcg3d(x, y, z);
  return cvr_fold(
      cvr_hash_bits(19u, x, bits) ^ cvr_hash_bits(47u, y, bits) ^ cvr_hash_bits(101u, z, bits),
      size);
}

CVR_FUNC uint cvr_cuckoo_key(uint x, uint y, uint z, uint lod) {
  uint w = lod;
  cvr_pcg4d(x, y, z, w);
  uint key = ((5u * x) ^ (149u * y) ^ (61u * z) ^ (2887u * w)) & ~CVR_CUCKOO_SECOND;
  return key == (~CVR_CUCKOO_SECOND) ? key - 1u : key;
}

// Second position of the entry with this key (bit 31 clear) whose first position is `first`.
CVR_FUNC uint cvr_cuckoo_second(uint key, uint first, uint bits, uint size) {
  uint x = key;
  uint y = first;
  cvr_pcg2d(x, y);
  uint mixed = cvr_hash_bits(7u, x, bits) ^ cvr_hash_bits(31u, y, bits) ^
               cvr_hash_bits(97u, x, bits) ^ cvr_hash_bits(173u, y, bits);
  return cvr_fold(mixed, size);
}

#endif
