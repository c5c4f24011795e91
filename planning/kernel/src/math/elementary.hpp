// exp, log and the cube root, of the basic operations alone: libraries round these functions by instruction set.
#pragma once

#include <cmath>

namespace wayproof {

// e^x for |x| < 0.5, to rounding, by its series.
inline double exp_of_small(double x) {
  double sum = 1;
  for (int k = 15; k >= 1; --k) sum = 1 + x * sum / k;
  return sum;
}

// log x for a normal x > 0, to rounding: 2 atanh z of the fraction, z = (m - 1) / (m + 1) with |z| < 0.18.
inline double log_of(double x) {
  constexpr double log_2 = 0.69314718055994530942, root_of_half = 0.70710678118654752440;
  int exponent;
  double m = std::frexp(x, &exponent);
  if (m < root_of_half) m *= 2, --exponent;
  const double z = (m - 1) / (m + 1), square = z * z;
  double sum = 0;
  for (int k = 21; k >= 1; k -= 2) sum = sum * square + 1.0 / k;
  return 2 * z * sum + exponent * log_2;
}

// The cube root of a normal x > 0, to rounding: Halley's steps from a line through the fraction, each of which triples
// the right digits.
inline double cube_root(double x) {
  int exponent;
  double m = std::frexp(x, &exponent);
  while (exponent % 3) m *= 2, --exponent;
  double y = 0.6 + 0.4 * m;
  for (int step = 0; step < 5; ++step) {
    const double cube = y * y * y;
    y *= (cube + 2 * m) / (2 * cube + m);
  }
  return std::ldexp(y, exponent / 3);
}

}  // namespace wayproof
