// No cache: each access decodes.
#define CVR_LOOKUP_LOOPS CVR_CELL_LOOPS

bool cvr_complete = true;

BrickCells cvr_cells;  // of the current brick

void cvr_enter_brick(uvec3 brick, uint index, uint lod) { cvr_cells = cvr_open_cells(brick, lod); }

bool cvr_lookup(uvec3 cell, uint lod, uvec3 brick, out uint code, out bool invisible) {
  CVR_COUNT(CVR_COUNT_CELLS_DECODED, 1);
  invisible = false;
  code = cvr_decode_cell(cvr_cells, cell, lod);
  return true;
}
