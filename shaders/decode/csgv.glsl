// `csgv-nibble` and `csgv-rans`: whole bricks in one sweep; they have no access to single nodes.
//
// Constants: CVR_CSGV_RANS 0 or 1, CVR_CSGV_DELTA 0 or 1. Buffers: see bricks.glsl; with rANS 2
// tables: 2 x 2^14 slots.
#include "shaders/decode/bricks.glsl"

#if CVR_CSGV_RANS
#define CVR_SERIAL_RANS
#else
#define CVR_SERIAL_NIBBLE
#endif
#define CVR_SERIAL_STOP_BITS 1
#define CVR_SERIAL_DELTA CVR_CSGV_DELTA
#include "shaders/decode/serial.glsl"
