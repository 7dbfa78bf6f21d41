// Counters of instrumented kernels, and the status words that the host reads after each frame. Same
// text for GLSL and C++.
#ifndef CVR_COUNTERS_GLSL
#define CVR_COUNTERS_GLSL

#define CVR_COUNT_RAYS 0
#define CVR_COUNT_BRICKS_ENTERED 1
#define CVR_COUNT_CELLS_READ 2
#define CVR_COUNT_CELLS_DECODED 3
#define CVR_COUNT_CHAIN_HOPS 4
#define CVR_COUNT_WORDS_TOUCHED 5  // 32-bit words of the encoding that were read
#define CVR_COUNT_CACHE_HITS 6
#define CVR_COUNT_CACHE_MISSES 7
#define CVR_COUNT_CACHE_EJECTIONS 8  // entries that moved to their second position
#define CVR_COUNT_CACHE_LOSSES 9     // entries that were overwritten
#define CVR_COUNT_WRONG_LABELS 10    // cache hits whose label is another one's: two keys collide
#define CVR_COUNT_EMPTY_SPACE_SKIPS 11
#define CVR_COUNT_EMPTY_SPACE_MARKS 12
#define CVR_COUNT_BRICKS_REQUESTED 13
#define CVR_COUNT_BRICKS_DECODED 14
#define CVR_COUNT_PLACEHOLDER_CELLS 15
#define CVR_COUNTERS 16

#define CVR_STATUS_INCOMPLETE 0  // pixels whose ray met a placeholder
#define CVR_STATUS_SUSPENDED 1   // pixels that go on in another dispatch
#define CVR_STATUS_WORDS 4

#define CVR_PIXEL_STATE_BYTES 256  // room for a PixelState

#define CVR_EMPTY_BRICK 255u

#endif
