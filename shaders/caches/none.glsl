// No cache: each access decodes.
bool cvr_complete = true;

void cvr_enter_brick(uvec3 brick, uint index, uint lod) {}

uint cvr_access(uvec3 cell, uint lod, uvec3 brick, out bool invisible) {
  invisible = false;
  CVR_COUNT(CVR_COUNT_CELLS_DECODED, 1);
  return cvr_decode_cell(cell, lod);
}
