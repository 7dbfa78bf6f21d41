// Constants of the brick cache that the host knows too. Same text for GLSL and C++.
#ifndef CVR_BRICK_CONTROL_GLSL
#define CVR_BRICK_CONTROL_GLSL

#define CVR_NO_LEVEL 255u
#define CVR_WANTED 128u  // with the level in the low bits: waits for a region

// Words of the control block.
#define CVR_CONTROL_GROUPS 0  // workgroups of the decoding pass, x y z
#define CVR_CONTROL_DECODE 3  // bricks on the list
#define CVR_CONTROL_REQUESTED 4
#define CVR_CONTROL_REFUSED 5
#define CVR_CONTROL_BUMP 6  // first untouched unit
#define CVR_CONTROL_FREE 7  // entries of each level's stack
#define CVR_CONTROL_WORDS 16

#define CVR_LAST_FRAME 0xfffffeu  // frames are counted from 1 to here and round

#endif
