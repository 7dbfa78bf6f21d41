// Values above that of transfer entry 0: sums over neighbours then lose nothing to a large offset
// that all voxels share.
float cvr_offset_sample(uvec3 voxel) { return cvr_sample(voxel) - cvr_frame.value_at; }
vec4 cvr_offset_samples(uvec3 voxel) { return cvr_samples(voxel) - cvr_frame.value_at; }
