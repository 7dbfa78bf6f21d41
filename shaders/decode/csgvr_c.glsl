// `csgvr-c`: single nodes through sampled codes of blocks, whole bricks in one sweep.
//
// Buffers: see groups.glsl (64 voxels per side: shaders/shared/csgvr_c.glsl); 2 tables   of the block codes
#include "shaders/decode/groups.glsl"
#include "shaders/shared/csgvr_c.glsl"
#include "shaders/shared/morton.glsl"
#include "shaders/shared/portable.glsl"

#define CVR_C_GROUP_SHIFT (6u - uint(CVR_BRICK_SHIFT))

CVR_FUNC uint64_t cvr_c_group_word(uvec3 brick) { return cvr_group_word(brick, CVR_C_GROUP_SHIFT); }
CVR_FUNC Global cvr_c_group(uvec3 brick) { return CVR_BUFFER_AT(1, cvr_c_group_word(brick)); }
CVR_FUNC uint cvr_c_member(uvec3 brick) { return cvr_group_member(brick, CVR_C_GROUP_SHIFT); }

struct BrickCells {
  Global global;
  Words words;
  CsgvrcBrick brick;
};

CVR_FUNC BrickCells cvr_open_cells(uvec3 brick, uint) {
  BrickCells cells;
  cells.global = cvr_c_group(brick);
  cells.brick = cvr_c_open(cells.global, cvr_c_member(brick), uint(CVR_LEVELS));
#ifdef CVR_WORDS_SHARED
  cells.words = Words(0u);
  cvr_c_rebase(cells.brick);
#else
  cells.words = cells.global;
#endif
  return cells;
}

CVR_FUNC uint cvr_decode_cell(BrickCells cells, uvec3 cell, uint lod) {
  uint level = uint(CVR_BRICK_SHIFT) - lod;
  uvec3 node = cell & ((1u << level) - 1u);
  uint index;
  uint hops = 0u;
  if (!cvr_c_index(cells.words, CVR_BUFFER(2), cells.brick,
                   cvr_morton_encode(node.x, node.y, node.z), level, index, hops))
    index = 0u;
  CVR_COUNT_HOPS(hops);
  return cvr_c_label(cells.global, cells.brick, index);
}

CVR_FUNC uint cvr_decode_root(uvec3 brick) {
  Global group = cvr_c_group(brick);
  CsgvrcBrick opened = cvr_c_open(group, cvr_c_member(brick), uint(CVR_LEVELS));
  return cvr_c_label(group, opened, opened.root);
}

CVR_FUNC uint cvr_c_code(BrickCells cells, uint index) {
  return cvr_c_label(cells.global, cells.brick, index);
}

// Whether one of the labels of a run is visible.
CVR_FUNC bool cvr_c_run_visible(BrickCells cells, bool fine, uint run) {
  CsgvrcRuns runs = cvr_c_runs(cells.brick, fine);
  uint rest = (fine ? cells.brick.fine_blocks : cells.brick.coarse_blocks) - run * CVR_C_RUN;
  uint at = cvr_c_run_begin(cells.words, runs, run);
  uint labels =
      cvr_c_skip(cells.words, CVR_BUFFER(2), fine, rest < CVR_C_RUN ? rest : CVR_C_RUN, at);
  for (uint k = 0u; k < labels; ++k) {
    if (cvr_code_visible(cvr_c_code(cells, cvr_c_bits(cells.words, at + k * cells.brick.index_bits,
                                                      cells.brick.index_bits))))
      return true;
  }
  return false;
}

CVR_FUNC bool cvr_decode_visible(uvec3 brick, uint part) {
  BrickCells cells = cvr_open_cells(brick, 0u);
  if (part == 0u && cvr_code_visible(cvr_c_code(cells, cells.brick.root))) return true;
  uint coarse = cells.brick.runs[0].count;
  uint runs = coarse + cells.brick.runs[1].count;
  for (uint run = part; run < runs; run += 1u << uint(CVR_BRICK_SHIFT)) {
    bool fine = run >= coarse;
    if (cvr_c_run_visible(cells, fine, fine ? run - coarse : run)) return true;
  }
  return false;
}

// The words of one brick.
CVR_FUNC uint cvr_shared_words(uvec3 brick) {
  return cvr_c_words(cvr_c_find(cvr_c_group(brick), cvr_c_member(brick), uint(CVR_LEVELS)));
}

CVR_FUNC Global cvr_shared_source(uvec3 brick) {
  CsgvrcBrick found = cvr_c_find(cvr_c_group(brick), cvr_c_member(brick), uint(CVR_LEVELS));
  return CVR_BUFFER_AT(1, cvr_c_group_word(brick) + uint64_t(found.begin / 32u));
}

#ifndef CVR_WITHOUT_SERIAL
#define CVR_SERIAL_CSGVR_C
#include "shaders/shared/csgv_serial.glsl"

CVR_FUNC void cvr_decode_brick(uvec3 brick, uint lod, Labels labels) {
  BrickCells cells = cvr_open_cells(brick, lod);
  SerialBrick serial;
  serial.levels = uint(CVR_LEVELS);
  serial.target = uint(CVR_BRICK_SHIFT) - lod;
  serial.opened = cells.brick;
  cvr_serial_decode(cells.global, cells.words, CVR_BUFFER(2), serial, labels);
}
#endif
