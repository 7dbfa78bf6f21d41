// What a frame tells the kernels of scalars: the fields of one struct, the same text for GLSL
// (scalar layout) and C++ (gpu/scalars/frame.hpp).
//
// Slice space: axes (p, q, s), s the axis of the slices, p and q the two others in their order; in
// voxels, voxel centres at integers.
uint64_t encoding[6];  // the codec's buffers
uint64_t ring;         // float a voxel: ring_slices slices, slice s at s modulo their number
uint64_t colours;      // 4 floats a pixel: colour so far, transmittance
uint64_t transfer;     // 4 floats an entry: red, green, blue, density a world unit
uint extent[3];        // of the volume along x, y, z
uint slices[3];        // extent in slice space
uint axis;             // of the slices: 0 x, 1 y, 2 z
uint backwards;        // 1: the view meets the last slice first
uint width;
uint height;
uint ring_slices;  // a power of two
uint samples;      // planes a slab between two slices
float eye[3];      // in slice space
float towards[3];  // direction of the image's centre
float right[3];    // half a pixel to the right
float down[3];     // half a pixel down
float scale[3];    // world units a voxel
float light[3];    // unit vector in world units, axes as in slice space
float ambient;
float background[3];
float value_at;    // value of transfer entry 0
float value_step;  // entries a unit of value
float knee;        // slope from which shading is full, in values a world unit
