// Motions along a path: the fastest profile through its cells with given speeds at their edges, and the composition
// q(t) = r(s(t)) as polynomials. As planning/retime/{line_profile,compose}.py has both, number for number.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "timing/speed_profile.hpp"

namespace wayproof {

// Cells of a path with the limits on them.
struct CellLimits {
  std::span<const double> edges;
  std::span<const bool> is_line;
  std::span<const double> speed, acceleration, braking;  // on lines
};

// Squared speeds at the edges, `x`; not zero at both ends of a curved cell.
SpeedProfile profile_between(const CellLimits& cells, std::span<const double> x);

// A motion in pieces.
struct PathMotion {
  std::size_t terms = 0;
  std::vector<double> times, coefficients;
  std::vector<std::int64_t> pieces;  // of the path
};

PathMotion compose(const PolynomialPath& path, const SpeedProfile& profile);

// Appends the coefficients of p(x + offset), by repeated synthetic division.
void append_shifted(const double* coefficients, std::size_t terms, std::size_t joints, double offset,
                    std::vector<double>& to);

}  // namespace wayproof
