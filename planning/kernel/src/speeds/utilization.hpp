// Utilization of the limits of rates along a motion: peak over limit, bounded from above as
// planning/retime/limit_utilization.py does it.
#pragma once

#include <cstddef>
#include <span>

namespace wayproof {

// Pieces of polynomials on [0, widths[i]], one for each joint: coefficients [pieces][terms][joints], lowest first.
struct Polynomials {
  std::span<const double> widths, coefficients;
  std::size_t terms, joints;
};

struct Utilization {
  double fraction;    // an upper bound, within a share of 1e-9 of what is attained
  std::size_t joint;  // with the largest one
};

// Of the derivative of an order, 0 to 3.
Utilization utilization(const Polynomials& motion, std::span<const double> limits, std::size_t order);

}  // namespace wayproof
