// The ray marcher (CSGV-R paper, section 4; gpu/IMAGE.md says what it draws): one invocation a
// pixel, primary and secondary ray by the same loop. A brick without visible labels is stepped over
// as one cell; others cell by cell of the brick's level of detail.
#include "shaders/render/ray.glsl"
#include "shaders/shared/pcg.glsl"

#ifndef CVR_SHADING
#define CVR_SHADING 0
#endif
#define CVR_SHADING_LOCAL 0
#define CVR_SHADING_SHADOW 1
#define CVR_SHADING_AO 2

#define CVR_OPAQUE 250u
const float CVR_LEAST_TRANSMITTANCE = 1.0 / 256.0;

layout(local_size_x = 64) in;

// Loop iterations of an invocation, where the driver bounds them: spent by decoders at the worst,
// and as the slowest of a subgroup.
#ifdef CVR_LOOP_LIMIT
uint cvr_spent = 0u;
#define CVR_SPEND(n) cvr_spent += (n)
#define CVR_SPEND_TOGETHER() cvr_spent = subgroupMax(cvr_spent) + 1u
#define CVR_SPENT_MUCH (cvr_spent > CVR_LOOP_LIMIT / 2u)
#else
#define CVR_SPEND(n)
#define CVR_SPEND_TOGETHER()
#define CVR_SPENT_MUCH false
#endif

layout(buffer_reference, std430, buffer_reference_align = 16) buffer Colours { vec4 c[]; };

// What a ray has gathered.
struct Light {
  vec3 colour;
  float transmittance;
  uint hit;      // code of the first visible cell
  bool any;      // there is one
  bool surface;  // it ended on an opaque cell, of this material:
  uint material;
};

Light cvr_no_light() { return Light(vec3(0.0), 1.0, 0u, false, false, 0u); }

vec3 cvr_albedo(uint rgba) {
  return vec3(rgba & 255u, rgba >> 8 & 255u, rgba >> 16 & 255u) / 255.0;
}

// Takes a visible cell's material where the label has changed; true if the ray ends.
bool cvr_blend(uint code, uint rgba, inout Light light) {
  if (!light.any) {
    light.any = true;
    light.hit = code;
  }
  if (cvr_opacity(rgba) >= CVR_OPAQUE) {
    light.surface = true;
    light.material = rgba;
    return true;
  }
  float alpha = float(cvr_opacity(rgba)) / 255.0;
  light.colour += light.transmittance * alpha * cvr_albedo(rgba);
  light.transmittance *= 1.0 - alpha;
  return light.transmittance < CVR_LEAST_TRANSMITTANCE;
}

ivec3 cvr_axis_mask(int axis) { return ivec3(axis == 0, axis == 1, axis == 2); }

// Where a ray is: the finest voxel that it has just entered, when and through which axis, and the
// label before.
struct Walk {
  ivec3 voxel;
  int axis;
  int64_t t;
  uint last;
  bool fresh;  // no label before
};

// Walks until the ray ends, leaves the volume or reaches `reach` (`ao` alone has an end). True if
// it was suspended: the driver would silently end its loops soon. Cells that the cache knows are
// passed in loops of their own, brick after brick; those that must be decoded wait until all rays
// of the subgroup have come to one or to their end.
bool cvr_march(Ray ray, int64_t reach, inout Walk walk, inout Light light) {
  // Where it ends, cells are cut: a coarse cell may reach beyond the volume.
  int64_t end = min(ray.leave, reach + 1);
  // Of the brick that the ray is in:
  uvec3 brick = uvec3(0);
  uint lod = 0u;
  bool empty = false;
  ivec3 cell = ivec3(0);
  i64vec3 next = i64vec3(0);
  i64vec3 stride = i64vec3(0);
  int brick_shift = 0;
  bool ended = false;
  bool suspend = false;
#ifdef CVR_RESOLVE_LOOPS
  bool known = false;  // the cell's label has just been decoded
  bool hidden = false;
  uint decoded = 0u;
  while (true) {
    bool missing = false;
#endif
    while (true) {
      CVR_SPEND_TOGETHER();
#ifdef CVR_RESOLVE_LOOPS
      if (!known)
#endif
      {
        brick = uvec3(walk.voxel) >> CVR_BRICK_SHIFT;
        uint index = cvr_brick_number(brick);
        lod = Words32(cvr_frame.bricks).w[index];
        empty = lod == CVR_EMPTY_BRICK;
        if (empty) {
          lod = CVR_BRICK_SHIFT;
        } else {
          CVR_COUNT(CVR_COUNT_BRICKS_ENTERED, 1);
          cvr_enter_brick(brick, index, lod);
        }
        cell = walk.voxel >> lod;
        next = cvr_times(ray, (cell + max(ray.sense, ivec3(0))) << lod);
        stride = ray.spacing << lod;
        brick_shift = int(CVR_BRICK_SHIFT - lod);
      }
      ivec3 mask = ivec3(0);
      while (true) {
        bool invisible = empty;
        uint code = 0u;
        if (!empty) {
#ifdef CVR_RESOLVE_LOOPS
          if (known) {
            code = decoded;
            invisible = hidden;
            known = false;
          } else {
            CVR_COUNT(CVR_COUNT_CELLS_READ, 1);
            if (!cvr_lookup(uvec3(cell), lod, brick, code, invisible)) {
              missing = true;
              break;
            }
          }
#else
        CVR_COUNT(CVR_COUNT_CELLS_READ, 1);
        cvr_lookup(uvec3(cell), lod, brick, code, invisible);
#endif
        }
        if (invisible) {
          walk.fresh = true;
        } else if (walk.fresh || code != walk.last) {
          walk.last = code;
          walk.fresh = false;
          uint rgba = cvr_material(code);
          if (cvr_opacity(rgba) != 0u && cvr_blend(code, rgba, light)) {
            ended = true;
            break;
          }
        }
        walk.axis = next.x <= next.y ? (next.x <= next.z ? 0 : 2) : (next.y <= next.z ? 1 : 2);
        mask = cvr_axis_mask(walk.axis);
        walk.t = walk.axis == 0 ? next.x : walk.axis == 1 ? next.y : next.z;
        if (walk.t >= end) {
          ended = true;
          break;
        }
        next += stride * i64vec3(mask);
        cell += ray.sense * mask;
        CVR_SPEND(1u + CVR_LOOKUP_LOOPS);
        suspend = CVR_SPENT_MUCH;
        if (suspend || ((cell >> brick_shift) - ivec3(brick)) * mask != ivec3(0)) break;
      }
      if (ended) break;
#ifdef CVR_RESOLVE_LOOPS
      if (missing) break;
#endif
      // The finest voxel: on the crossed axis beside its plane, on the others by the planes crossed
      // until now.
      ivec3 backwards = ivec3(lessThan(ray.sense, ivec3(0)));
      ivec3 entered = ((cell + backwards) << lod) - backwards;
      ivec3 inside =
          lod == 0u ? cell : cvr_cell_after(ray, cvr_crossed(ray, walk.t, walk.axis), walk.voxel);
      walk.voxel = inside * (1 - mask) + entered * mask;
      if (suspend) break;
    }
#ifdef CVR_RESOLVE_LOOPS
    CVR_SPEND_TOGETHER();
    if (!missing) break;
    decoded = cvr_resolve(uvec3(cell), lod, brick, hidden);
    known = true;
    CVR_SPEND(1u + CVR_RESOLVE_LOOPS);
  }
#endif
  return suspend;
}

#if CVR_SHADING != CVR_SHADING_LOCAL
// The hit point, off the face that the ray came in by on the ray's side.
i64vec3 cvr_surface_point(Ray ray, int64_t t, int axis, i64vec3 origin) {
  ivec3 k = cvr_crossed(ray, t, axis);
  i64vec3 since = i64vec3(t) - ray.t0 - i64vec3(k) * ray.spacing;
  vec3 part = clamp(vec3(since) * ray.frequency, vec3(0.0), vec3(0.99999));
  i64vec3 point = cvr_planes_at(ray.p0 + ray.sense * k) +
                  i64vec3(ray.sense) * i64vec3(part * exp2(float(CVR_ONE_VOXEL)));
  ivec3 mask = cvr_axis_mask(axis);
  point = point * i64vec3(1 - mask) +
          (cvr_planes_at(ray.p0 + ray.sense * k) - i64vec3(ray.sense)) * i64vec3(mask);
  return i64vec3(ray.sense.x == 0 ? origin.x : point.x, ray.sense.y == 0 ? origin.y : point.y,
                 ray.sense.z == 0 ? origin.z : point.z);
}
#endif

#if CVR_SHADING == CVR_SHADING_AO
// A cosine-distributed direction about the face normal, in voxel space with its largest component
// 2^30; `reach` in units of t.
i64vec3 cvr_ambient_direction(uvec2 pixel, uint number, int axis, int side, out int64_t reach) {
  uvec3 random = uvec3(pixel, number);
  cvr_pcg3d(random.x, random.y, random.z);
  float u1 = float(random.x >> 8) * exp2(-24.0);
  float phi = 6.283185307179586 * float(random.y >> 8) * exp2(-24.0);
  float a = sqrt(u1) * cos(phi);
  float b = sqrt(u1) * sin(phi);
  float n = sqrt(1.0 - u1) * float(side);
  vec3 world = axis == 0 ? vec3(n, a, b) : axis == 1 ? vec3(b, n, a) : vec3(a, b, n);
  vec3 d = world *
           vec3(cvr_frame.inverse_scale[0], cvr_frame.inverse_scale[1], cvr_frame.inverse_scale[2]);
  float largest = max(max(abs(d.x), abs(d.y)), abs(d.z));
  reach = int64_t(largest * cvr_frame.ao_distance * 65536.0) << 24;
  return i64vec3(d / largest * 1073741824.0);
}
#endif

#if CVR_SHADING == CVR_SHADING_AO
// The largest component of a material's colour, 0 to 255.
uint cvr_largest_component(uint rgba) {
  return max(max(rgba & 255u, rgba >> 8 & 255u), rgba >> 16 & 255u);
}

// Whether Russian roulette lets a surface of this material cast its ray.
bool cvr_survives(uvec2 pixel, uint number, uint rgba) {
  uvec3 random = uvec3(pixel, number);
  cvr_pcg3d(random.x, random.y, random.z);
  return (random.z >> 16) * 255u < cvr_largest_component(rgba) << 16;
}
#endif

// What it takes to go on with a pixel in another dispatch.
struct PixelState {
  i64vec3 origin;
  i64vec3 direction;
  int64_t reach;
  Walk walk;
  Light light;
  Light primary;  // once the secondary ray is on its way
  float cosine;   // of the surface's normal with the light
  bool secondary;
  bool pending;
  bool complete;
};

#ifdef CVR_LOOP_LIMIT
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Suspended { PixelState s[]; };
#endif

i64vec3 cvr_primary_direction(uvec2 pixel) {
  int64_t x = int64_t(2u * pixel.x + 1u) - int64_t(cvr_frame.width);
  int64_t y = int64_t(2u * pixel.y + 1u) - int64_t(cvr_frame.height);
  i64vec3 direction = i64vec3(cvr_frame.towards[0], cvr_frame.towards[1], cvr_frame.towards[2]) +
                      x * i64vec3(cvr_frame.right[0], cvr_frame.right[1], cvr_frame.right[2]) +
                      y * i64vec3(cvr_frame.down[0], cvr_frame.down[1], cvr_frame.down[2]);
  return (direction + 32768) >> 16;
}

// Index of a pixel's position in its 8x8 tile by Morton order, so that a subgroup covers a square.
uvec2 cvr_pixel_in_tile(uint i) {
  return uvec2((i & 1u) | (i >> 1 & 2u) | (i >> 2 & 4u),
               (i >> 1 & 1u) | (i >> 2 & 2u) | (i >> 3 & 4u));
}

void cvr_draw() {
  uint tiles_x = (cvr_frame.width + 7u) / 8u;
  uint tile = gl_WorkGroupID.x;
  if (((tile * 0x9e3779b1u >> 8) & cvr_frame.focus_mask) != cvr_frame.focus_value) return;
  uvec2 pixel =
      uvec2(tile % tiles_x, tile / tiles_x) * 8u + cvr_pixel_in_tile(gl_LocalInvocationID.x);
  if (pixel.x >= cvr_frame.width || pixel.y >= cvr_frame.height) return;
  uint at = pixel.x + cvr_frame.width * pixel.y;
  vec4 sum = cvr_frame.restart != 0u ? vec4(0.0) : Colours(cvr_frame.colours).c[at];
  if (uint(sum.w) >= cvr_frame.samples) return;

  PixelState state;
#ifdef CVR_LOOP_LIMIT
  if (cvr_frame.resume != 0u) {
    state = Suspended(cvr_frame.suspended).s[at];
    if (!state.pending) return;
    cvr_complete = state.complete;
  }
#endif
  if (cvr_frame.resume == 0u) {
    state.origin = i64vec3(cvr_frame.eye[0], cvr_frame.eye[1], cvr_frame.eye[2]);
    state.direction = cvr_primary_direction(pixel);
    state.reach = CVR_NEVER;
    state.secondary = false;
    state.pending = false;
    state.cosine = 0.0;
    state.light = cvr_no_light();
    state.primary = cvr_no_light();
  }
  vec3 background = vec3(cvr_frame.background[0], cvr_frame.background[1], cvr_frame.background[2]);
  float seen = 1.0;  // transmittance of the secondary ray
  while (true) {
    Ray ray;
    Walk start;
    bool inside = cvr_ray(state.origin, state.direction, ray, start.voxel, start.t, start.axis);
    start.last = 0u;
    start.fresh = true;
    if (!state.pending) {
      state.walk = start;
      CVR_COUNT(CVR_COUNT_RAYS, 1);
    }
    state.pending = inside && cvr_march(ray, state.reach, state.walk, state.light);
#ifdef CVR_LOOP_LIMIT
    if (state.pending) {
      state.complete = cvr_complete;
      Suspended(cvr_frame.suspended).s[at] = state;
      atomicAdd(Words32(cvr_frame.status).w[CVR_STATUS_SUSPENDED], 1u);
      return;
    }
#endif
    if (state.secondary) {
      seen = state.light.surface || state.light.transmittance < CVR_LEAST_TRANSMITTANCE
                 ? 0.0
                 : state.light.transmittance;
#if CVR_SHADING == CVR_SHADING_AO
      if (cvr_frame.ao_roulette != 0u)
        seen *= 255.0 / float(cvr_largest_component(state.primary.material));
#endif
      break;
    }
    state.primary = state.light;
    if (!state.light.surface) break;
    int axis = state.walk.axis;
    if (axis < 0) {
      i64vec3 length = abs(state.direction);
      axis = length.x >= length.y ? (length.x >= length.z ? 0 : 2) : (length.y >= length.z ? 1 : 2);
    }
    int side = -(axis == 0 ? ray.sense.x : axis == 1 ? ray.sense.y : ray.sense.z);
    state.cosine = max(0.0, float(side) * cvr_frame.light_world[axis]);
#if CVR_SHADING == CVR_SHADING_LOCAL
    break;
#else
    if (state.walk.axis < 0) break;
    i64vec3 point = cvr_surface_point(ray, state.walk.t, axis, state.origin);
#if CVR_SHADING == CVR_SHADING_SHADOW
    if (state.cosine <= 0.0) break;
    state.direction = i64vec3(cvr_frame.light[0], cvr_frame.light[1], cvr_frame.light[2]);
#else
    if (cvr_frame.ao_roulette != 0u && !cvr_survives(pixel, uint(sum.w), state.primary.material)) {
      seen = 0.0;
      break;
    }
    state.direction = cvr_ambient_direction(pixel, uint(sum.w), axis, side, state.reach);
#endif
    state.origin = point;
    state.secondary = true;
    state.light = cvr_no_light();
#endif
  }
#ifdef CVR_LOOP_LIMIT
  Suspended(cvr_frame.suspended).s[at].pending = false;
#endif
  Light primary = state.primary;
  vec3 colour = primary.colour;
  if (primary.surface) {
#if CVR_SHADING == CVR_SHADING_SHADOW
    state.cosine *= seen;
    seen = 1.0;
#endif
    float lambert = cvr_frame.ambient + (1.0 - cvr_frame.ambient) * state.cosine;
    colour += primary.transmittance * cvr_albedo(primary.material) * lambert * seen;
  } else if (primary.transmittance >= CVR_LEAST_TRANSMITTANCE) {
    colour += primary.transmittance * background;
  }

  Words64(cvr_frame.labels).w[at] = primary.any ? uint64_t(primary.hit) : ~uint64_t(0);
  if (cvr_complete) {
    Colours(cvr_frame.colours).c[at] = (sum.w == 0.0 ? vec4(0.0) : sum) + vec4(colour, 1.0);
  } else {
    atomicAdd(Words32(cvr_frame.status).w[CVR_STATUS_INCOMPLETE], 1u);
    if (sum.w == 0.0) Colours(cvr_frame.colours).c[at] = vec4(colour, 0.0);
  }
}

void main() {
  cvr_draw();
  cvr_keep_counts();
}
