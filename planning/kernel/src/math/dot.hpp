// dot: a scalar product whose rounding does not depend on the instruction set.
#pragma once

namespace wayproof {

inline constexpr int pad = 4;

// In four sums, so that every instruction set adds in the same order.
inline double dot(const double* a, const double* b, int count) {
  double sums[pad] = {0, 0, 0, 0};
  int k = 0;
  for (; k + pad <= count; k += pad)
    for (int l = 0; l < pad; ++l) sums[l] += a[k + l] * b[k + l];
  for (; k < count; ++k) sums[0] += a[k] * b[k];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

}  // namespace wayproof
