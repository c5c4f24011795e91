// SpeedProfile: the path parameter over time, as planning/retime/profile.py has it; and the path that it is along.
#pragma once

#include <cstddef>
#include <vector>

namespace wayproof {

// Phases of constant jerk: s has one more entry than v, a, j and h.
struct SpeedProfile {
  std::vector<double> s, v, a, j, h;

  double duration() const {
    double sum = 0;
    for (double x : h) sum += x;
    return sum;
  }
};

// Pieces of polynomials in (s - breaks[i]), one for each joint, with coefficients [pieces][terms][joints].
struct PolynomialPath {
  std::size_t terms = 0, joints = 0;
  std::vector<double> breaks, coefficients;

  std::size_t pieces() const { return breaks.size() - 1; }
  const double* piece(std::size_t i) const { return coefficients.data() + i * terms * joints; }
  // The piece on which a parameter lies.
  std::size_t locate(double s) const;
};

// Limits of velocity, acceleration and jerk, [3][joints].
using RateLimits = std::vector<double>;

}  // namespace wayproof
