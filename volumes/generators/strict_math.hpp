// Transcendental functions of + - * alone, in strict IEEE double precision, so that generated
// volumes are the same bytes on every machine; those of libm may differ in the last bit.
#pragma once

#include <cstdint>

namespace cvr::volumes {

/// floor(x) for |x| < 2^62.
inline double floor_strict(double x) {
  const auto whole = static_cast<double>(static_cast<std::int64_t>(x));
  return whole > x ? whole - 1 : whole;
}

/// cos(2 pi t) to 1e-12: Taylor's series over a sixteenth of a turn at most, doubled twice by 2 c^2
/// - 1.
inline double cos_turns(double t) {
  const double x = (t - floor_strict(t + 0.5)) * (6.283185307179586 / 4);
  const double s = x * x;
  double c =
      1 -
      s / 2 *
          (1 -
           s / 12 *
               (1 -
                s / 30 *
                    (1 - s / 56 * (1 - s / 90 * (1 - s / 132 * (1 - s / 182 * (1 - s / 240)))))));
  for (int i = 0; i < 2; ++i) c = 2 * c * c - 1;
  return c;
}

/// 2^x to 1e-15 of it, for |x| <= 4: the series of exp(x ln 2 / 16), squared four times.
inline double exp2_strict(double x) {
  const double y = x * (0.6931471805599453 / 16);
  double e = 1;
  for (int n = 14; n >= 1; --n) e = 1 + y / n * e;
  for (int i = 0; i < 4; ++i) e *= e;
  return e;
}

}  // namespace cvr::volumes
