// No cache: each access decodes.
#define CVR_LOOKUP_LOOPS CVR_CELL_LOOPS

bool cvr_complete = true;

void cvr_enter_brick(uvec3 brick, uint index, uint lod) {}

bool cvr_lookup(uvec3 cell, uint lod, uvec3 brick, out uint code, out bool invisible) {
  CVR_COUNT(CVR_COUNT_CELLS_DECODED, 1);
  invisible = false;
  code = cvr_decode_cell(cell, lod);
  return true;
}
