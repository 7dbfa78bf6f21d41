// Root and visibility of a brick for texts without bricks of their own: asked of cvr_decode_cell.

CVR_FUNC uint cvr_decode_root(uvec3 brick) {
  uint lod = uint(CVR_BRICK_SHIFT);
  return cvr_decode_cell(cvr_open_cells(brick, lod), brick, lod);
}

CVR_FUNC bool cvr_decode_visible(uvec3 brick, uint part) {
  uvec3 first = brick << uint(CVR_BRICK_SHIFT);
  first.z += part;
  uvec3 end = min(first + (1u << uint(CVR_BRICK_SHIFT)), cvr_extent());
  if (first.z >= end.z) return false;
  BrickCells cells = cvr_open_cells(brick, 0u);
  uint last = cvr_decode_cell(cells, first, 0u);
  if (cvr_code_visible(last)) return true;
  for (uint y = first.y; y < end.y; ++y) {
    for (uint x = first.x; x < end.x; ++x) {
      uint code = cvr_decode_cell(cells, uvec3(x, y, first.z), 0u);
      if (code == last) continue;
      if (cvr_code_visible(code)) return true;
      last = code;
    }
  }
  return false;
}
