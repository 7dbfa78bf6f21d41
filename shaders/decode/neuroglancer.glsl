// `neuroglancer`: single voxels of compressed_segmentation streams, level by level.
//
// Buffers: 0 levels    7 words per level: chunk edge, extent along x and y, chunks along x and y, first chunk, 1 if stored
//          1 starts    first word of each chunk's stream in the buffer of its level, two words, low first
//          2 streams   of the stored levels
//          3 coarser   streams of the other levels
//          4 remap     only where CVR_REMAP_SIZE > 0: all labels, ascending, two words each
// Constants: CVR_NEUROGLANCER_BLOCK_X, _Y, _Z voxels of a block; CVR_NEUROGLANCER_TABLE_WORDS words
// of a label, 1 or 2;
//            CVR_REMAP_SIZE labels that do not fit in 32 bits
#include "shaders/shared/label_codes.glsl"
#include "shaders/shared/neuroglancer.glsl"
#include "shaders/shared/portable.glsl"

// Blocks along an axis of the chunk at `chunk`.
CVR_FUNC uint cvr_chunk_blocks(uint chunk, uint edge, uint extent, uint block) {
  uint rest = extent - chunk * edge;
  return ((rest < edge ? rest : edge) + block - 1u) / block;
}

struct BrickCells {
  uint edge;                // of a chunk of the level
  uint extent_x, extent_y;  // of the level
  uint chunks_x, chunks_y;
  uint first;  // chunk of the level
  uint stored;
};

CVR_FUNC BrickCells cvr_open_cells(uvec3, uint lod) {
  Global levels = CVR_BUFFER(0);
  uint at = 7u * lod;
  BrickCells cells;
  cells.edge = cvr_read_global(levels, at);
  cells.extent_x = cvr_read_global(levels, at + 1u);
  cells.extent_y = cvr_read_global(levels, at + 2u);
  cells.chunks_x = cvr_read_global(levels, at + 3u);
  cells.chunks_y = cvr_read_global(levels, at + 4u);
  cells.first = cvr_read_global(levels, at + 5u);
  cells.stored = cvr_read_global(levels, at + 6u);
  return cells;
}

CVR_FUNC uint cvr_decode_cell(BrickCells cells, uvec3 cell, uint) {
  uvec3 chunk = cell / cells.edge;
  uint index = cells.first + chunk.x + cells.chunks_x * (chunk.y + cells.chunks_y * chunk.z);
  Global start_words = CVR_BUFFER_AT(1, uint64_t(2u) * uint64_t(index));
  uint64_t start = cvr_word64_global(start_words, 0u);

  NeuroglancerStream s;
  s.block_x = uint(CVR_NEUROGLANCER_BLOCK_X);
  s.block_y = uint(CVR_NEUROGLANCER_BLOCK_Y);
  s.block_z = uint(CVR_NEUROGLANCER_BLOCK_Z);
  s.grid_x = cvr_chunk_blocks(chunk.x, cells.edge, cells.extent_x, s.block_x);
  s.grid_y = cvr_chunk_blocks(chunk.y, cells.edge, cells.extent_y, s.block_y);
  s.table_words = uint(CVR_NEUROGLANCER_TABLE_WORDS);

  uvec3 inside = cell - chunk * cells.edge;
  uint64_t label;
  if (cells.stored != 0u) {
    label = cvr_neuroglancer_label(CVR_BUFFER_AT(2, start), s, inside.x, inside.y, inside.z);
  } else {
    label = cvr_neuroglancer_label(CVR_BUFFER_AT(3, start), s, inside.x, inside.y, inside.z);
  }
  CVR_COUNT_HOPS(1u);
  if (uint(CVR_REMAP_SIZE) > 0u) return cvr_code_of(CVR_BUFFER(4), uint(CVR_REMAP_SIZE), label);
  return uint(label);
}

#include "shaders/decode/voxels.glsl"
