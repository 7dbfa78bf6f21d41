// What a frame tells its kernels: the fields of one struct, the same text for GLSL (scalar layout)
// and C++ (gpu/frame.hpp). 64-bit fields come first, so both languages give them the same offsets.
// Addresses on the device.
uint64_t encoding[6];  // the codec's buffers
uint64_t
    bricks;  // u32 a brick: its level of detail, or CVR_EMPTY_BRICK where it holds no visible label
uint64_t materials;  // direct: u32 RGBA a code; hashed: u64 a slot, code | RGBA << 32
uint64_t
    colours;  // 4 floats a pixel: sum of samples and their number, 0: what stands in for the first sample
uint64_t labels;     // u64 a pixel: code of the hit, all ones where none
uint64_t counters;   // u64 each, see counters.glsl
uint64_t status;     // u32 each, see counters.glsl
uint64_t suspended;  // a PixelState a pixel, where the driver bounds loops (march.comp)
uint64_t cache[8];   // the cache strategy's buffers
// The camera, see ray.glsl.
int64_t eye[3];      // 2^-20 voxels
int64_t towards[3];  // direction of the image's centre, in 2^-16 of a direction unit
int64_t right[3];    // half a pixel to the right
int64_t down[3];     // half a pixel down
int64_t light[3];    // direction to the light in voxel space, largest component 2^30
uint extent[3];      // voxels
uint grid[3];        // bricks
uint width;
uint height;
uint samples;     // pixels that have as many are done
uint restart;     // 1: forget earlier samples
uint resume;      // 1: go on with suspended pixels alone
uint focus_mask;  // only tiles whose (hash & focus_mask) == focus_value are drawn
uint focus_value;
uint material_slots;   // direct: codes; hashed: slots - 1, slots a power of two
uint frame;            // counts from 1, below 2^24
uint cache_sizes[8];   // the cache strategy's numbers
float light_world[3];  // unit vector
float ambient;
float background[3];
float ao_distance;       // world units
float inverse_scale[3];  // voxels a world unit
uint ao_roulette;        // 1: rays of ambient occlusion by Russian roulette
