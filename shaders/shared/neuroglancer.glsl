// Random access into one compressed_segmentation stream of Neuroglancer with one channel: four
// reads per label.
//
// The words begin with the channel offset 1, to which all other offsets are relative. Two header
// words per block (x fastest): bits 0..23 table offset, bits 24..31 bits per value; value offset.
// Values least significant first, never across a word; table entries of one word, or two (low
// first) for 64-bit labels. The encoder's checks (24-bit table offsets) and the decoder's
// (CompressedSegmentation::open) make every address below legal for voxels inside the extent.
#ifndef CVR_NEUROGLANCER_GLSL
#define CVR_NEUROGLANCER_GLSL

#include "shaders/shared/portable.glsl"

struct NeuroglancerStream {
  uint grid_x;  // blocks along x and y
  uint grid_y;
  uint block_x;  // voxels of a block
  uint block_y;
  uint block_z;
  uint table_words;  // words of a label: 1 or 2
};

CVR_FUNC uint64_t cvr_neuroglancer_label(Words words, NeuroglancerStream s, uint x, uint y,
                                         uint z) {
  uint bx = x / s.block_x;
  uint by = y / s.block_y;
  uint bz = z / s.block_z;
  uint header = 1u + 2u * (bx + s.grid_x * (by + s.grid_y * bz));
  uint table = cvr_read(words, header) & 0xffffffu;
  uint bits = cvr_read(words, header) >> 24;
  uint index = 0u;
  if (bits != 0u) {
    uint voxel = (x - bx * s.block_x) +
                 s.block_x * ((y - by * s.block_y) + s.block_y * (z - bz * s.block_z));
    uint bit = voxel * bits;  // at most 64^3 * 32 bits
    uint value = cvr_read(words, 1u + cvr_read(words, header + 1u) + (bit >> 5)) >> (bit & 31u);
    index = bits == 32u ? value : value & ((1u << bits) - 1u);
  }
  uint entry = 1u + table + index * s.table_words;
  if (s.table_words == 1u) return uint64_t(cvr_read(words, entry));
  return cvr_word64(words, entry);
}

#endif
