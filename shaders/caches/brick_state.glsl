// The brick cache's memory (CSGV-R paper, section 4; after shading atlas streaming, Mueller et al.
// 2018).
//
// The cache is an array of units of 2x2x2 label codes. A brick at level of detail l has 8^(L-1-l)
// codes, in Morton order, in 8^(L-2-l) units in a row; the coarsest level is one code, kept for all
// bricks. Free regions of each level are kept on a stack of their own; what no stack has comes from
// the untouched end of the cache.
//
// cache[0] units   cache[1] u32 x 3 a brick: wish (frame << 8 | level wanted), level held, first unit
// cache[2] control, below   cache[3] stacks: `bricks` u32 for each level   cache[4] list of bricks to decode
// cache[5] code of each brick's coarsest level
// cache_sizes[0] units, [1] bricks
#include "shaders/caches/brick_control.glsl"
#include "shaders/shared/portable.glsl"

#define CVR_CONTROL Words32(cvr_frame.cache[2])
#define CVR_ROOTS Words32(cvr_frame.cache[5])

uint cvr_wish_address(uint brick) { return 3u * brick; }
uint cvr_level_address(uint brick) { return 3u * brick + 1u; }
uint cvr_unit_address(uint brick) { return 3u * brick + 2u; }

uint cvr_units_of(uint lod) { return 1u << (3u * (CVR_LEVELS - 2u - lod)); }

Labels cvr_region(uint unit) { return Labels(cvr_frame.cache[0] + 32UL * uint64_t(unit)); }
