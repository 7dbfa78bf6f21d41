// Deferred filtering, first pass: decodes the slices cvr_push.x to cvr_push.y - 1 into the ring; one invocation a voxel.
layout(local_size_x = CVR_GROUP) in;

void main() {
  uint area = cvr_frame.slices[0] * cvr_frame.slices[1];
  uint i = gl_GlobalInvocationID.x;
  if (i >= area * (cvr_push.y - cvr_push.x)) return;
  uint slice = cvr_push.x + i / area;
  uint inside = i % area;
  float value = cvr_offset_sample(cvr_voxel(inside % cvr_frame.slices[0], inside / cvr_frame.slices[0], slice));
  Floats(cvr_frame.ring).f[(slice % cvr_frame.ring_slices) * area + inside] = value;
}
