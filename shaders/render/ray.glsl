// Rays in exact integers (gpu/IMAGE.md, Precision): every device and every cache visits the same
// cells.
//
// Positions are in 2^-20 voxels, directions integers up to 2^30, the parameter t in 2^-40 of a
// voxel along the dominant axis. On axis b the planes that a ray crosses are evenly spaced: t(k) =
// t0_b + k * spacing_b, k counting planes from reference plane p0_b in the ray's direction. With
// integers it makes no difference whether a ray steps plane by plane or over a brick at once.
// spacing is cut at 2^55, t at +-2^61: no ray crosses two planes 2^15 voxels apart, since no volume
// is larger.
#ifndef CVR_RAY_GLSL
#define CVR_RAY_GLSL

#define CVR_ONE_VOXEL 20
#define CVR_ONE_T 40
const int64_t CVR_NEVER = int64_t(1) << 61;
const int64_t CVR_WIDEST = int64_t(1) << 55;

struct Ray {
  i64vec3 t0;
  i64vec3 spacing;
  ivec3 p0;
  ivec3 sense;     // -1, 0, 1 along each axis
  vec3 frequency;  // 1 / spacing
  int64_t leave;   // when it leaves the volume
};

// trunc(a * b / 2^20), cut at +-2^61; |a| < 2^44, 0 <= b < 2^62.
int64_t cvr_scaled(int64_t a, int64_t b) {
  uint64_t ua = uint64_t(abs(a));
  uint64_t ub = uint64_t(b);
  uint64_t al = ua & 0xffffffffUL;
  uint64_t ah = ua >> 32;
  uint64_t bl = ub & 0xffffffffUL;
  uint64_t bh = ub >> 32;
  uint64_t low = al * bl;
  uint64_t cross_1 = al * bh;
  uint64_t cross_2 = ah * bl;
  uint64_t middle = (low >> 32) + (cross_1 & 0xffffffffUL) + (cross_2 & 0xffffffffUL);
  uint64_t high = ah * bh + (cross_1 >> 32) + (cross_2 >> 32) + (middle >> 32);
  uint64_t rest = (middle << 32) | (low & 0xffffffffUL);
  uint64_t result = high >= (uint64_t(1) << 17) ? uint64_t(CVR_NEVER) : (high << 44) | (rest >> 20);
  return a < 0 ? -int64_t(result) : int64_t(result);
}

// largest / d in two precisions: 2^32 of it, and 2^40 of it, cut; 0 < d <= largest <= 2^30.
struct Slope {
  int64_t coarse;
  int64_t spacing;
};

Slope cvr_slope(int64_t largest, int64_t d) {
  uint64_t dividend = uint64_t(largest) << 32;
  uint64_t quotient = dividend / uint64_t(d);
  uint64_t remainder = dividend - quotient * uint64_t(d);
  bool wide = quotient >= (uint64_t(1) << 47);
  return Slope(int64_t(quotient),
               wide ? CVR_WIDEST : int64_t((quotient << 8) | ((remainder << 8) / uint64_t(d))));
}

// When a plane this far along its axis is crossed. Where the spacing is cut, the first crossing
// still comes when it is due.
int64_t cvr_time(int64_t distance, Slope slope) {
  if (slope.spacing < CVR_WIDEST) return cvr_scaled(distance, slope.spacing);
  return clamp(cvr_scaled(distance, slope.coarse), -(CVR_NEVER >> 8), CVR_NEVER >> 8) << 8;
}

int64_t cvr_max3(i64vec3 v) { return max(max(v.x, v.y), v.z); }
i64vec3 cvr_planes_at(ivec3 plane) { return i64vec3(plane) << CVR_ONE_VOXEL; }

// When the planes are crossed. Axes without movement: never.
i64vec3 cvr_times(Ray ray, ivec3 plane) {
  return ray.t0 + i64vec3((plane - ray.p0) * ray.sense) * ray.spacing;
}

// Planes crossed on each axis at time t, counted from p0; of planes at t itself those of axes up to
// `axis`.
ivec3 cvr_crossed(Ray ray, int64_t t, int axis) {
  i64vec3 until = i64vec3(t) - i64vec3(0, axis < 1 ? 1 : 0, axis < 2 ? 1 : 0) - ray.t0;
  ivec3 k = ivec3(floor(vec3(until) * ray.frequency));  // right or one off
  i64vec3 rest = until - i64vec3(k) * ray.spacing;
  k -= ivec3(lessThan(rest, i64vec3(0)));
  k += ivec3(greaterThanEqual(rest, ray.spacing)) * abs(ray.sense);
  // A cut spacing is wider in truth: of two neighbouring planes at most one lies behind.
  ivec3 least =
      ivec3(ray.spacing.x == CVR_WIDEST ? -1 : k.x, ray.spacing.y == CVR_WIDEST ? -1 : k.y,
            ray.spacing.z == CVR_WIDEST ? -1 : k.z);
  return max(k, least);
}

// The cell between the last crossed plane and the next; `still` where there is no movement.
ivec3 cvr_cell_after(Ray ray, ivec3 crossed, ivec3 still) {
  ivec3 plane = ray.p0 + ray.sense * crossed;
  ivec3 cell = plane + min(ray.sense, ivec3(0));
  return ivec3(ray.sense.x == 0 ? still.x : cell.x, ray.sense.y == 0 ? still.y : cell.y,
               ray.sense.z == 0 ? still.z : cell.z);
}

// Sets a ray up; false if it misses the volume. `cell` is the first cell, `t` its time, `axis` that
// of the face through which the ray came in, -1 where it begins inside.
bool cvr_ray(i64vec3 origin, i64vec3 direction, out Ray ray, out ivec3 cell, out int64_t t,
             out int axis) {
  ivec3 extent = ivec3(cvr_extent());
  i64vec3 length = abs(direction);
  int64_t largest = cvr_max3(length);
  ray.sense = ivec3(sign(direction));
  ivec3 still = ivec3(origin >> CVR_ONE_VOXEL);
  t = 0;
  axis = -1;
  int64_t leave = CVR_NEVER;
  bool hit = largest > 0;
  Slope slopes[3];
  for (int b = 0; b < 3; ++b) {
    if (length[b] == 0) {
      ray.spacing[b] = 0;
      ray.frequency[b] = 0.0;
      if (still[b] < 0 || still[b] >= extent[b]) hit = false;
      continue;
    }
    Slope slope = cvr_slope(largest, length[b]);
    slopes[b] = slope;
    ray.spacing[b] = slope.spacing;
    ray.frequency[b] = 1.0 / float(ray.spacing[b]);
    int64_t far = int64_t(extent[b]) << CVR_ONE_VOXEL;
    int64_t to_entry = ray.sense[b] > 0 ? -origin[b] : origin[b] - far;
    int64_t to_exit = to_entry + far;
    if (to_exit <= 0) hit = false;
    if (to_entry > 0) {
      int64_t entry = cvr_time(to_entry, slope);
      if (entry >= t) {
        t = entry;
        axis = b;
      }
    }
    leave = min(leave, cvr_time(to_exit, slope));
  }
  if (!hit || t >= leave) return false;
  // Reference planes near the entry keep k small, so that the spacing's rounding stays below 2^-20
  // voxels.
  float steps = float(t) * exp2(-float(CVR_ONE_T));
  for (int b = 0; b < 3; ++b) {
    float at = float(origin[b]) * exp2(-float(CVR_ONE_VOXEL));
    if (length[b] != 0) at += float(direction[b]) / float(largest) * steps;
    int plane = int(floor(at + 0.5));
    if (ray.spacing[b] == CVR_WIDEST) {
      // The next plane ahead: from there on a cut spacing is wide enough.
      int64_t here = origin[b] + (t >> (CVR_ONE_T - CVR_ONE_VOXEL)) * direction[b] / largest;
      plane = ray.sense[b] > 0 ? int(here >> CVR_ONE_VOXEL) + 1 : int((here - 1) >> CVR_ONE_VOXEL);
    }
    ray.p0[b] = clamp(plane, 0, extent[b]);
    int64_t distance = ((int64_t(ray.p0[b]) << CVR_ONE_VOXEL) - origin[b]) * ray.sense[b];
    ray.t0[b] = length[b] == 0 ? CVR_NEVER : cvr_time(distance, slopes[b]);
  }
  ivec3 last = extent * ivec3(greaterThan(ray.sense, ivec3(0)));
  i64vec3 out_of = cvr_times(ray, last);
  for (int b = 0; b < 3; ++b) {
    float planes = float((last[b] - ray.p0[b]) * ray.sense[b]);
    if (planes * float(ray.spacing[b]) > float(CVR_NEVER))
      out_of[b] = CVR_NEVER;  // the product does not fit
  }
  ray.leave = min(min(out_of.x, out_of.y), out_of.z);
  // The clamp mends the last bit of t where the entry plane is not the reference plane.
  cell = clamp(cvr_cell_after(ray, cvr_crossed(ray, t, 2), still), ivec3(0), extent - 1);
  return true;
}

#endif
