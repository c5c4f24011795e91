// Upper bounds on polynomials in Bernstein form, as planning/certify/intervals/bernstein.py has them.
#pragma once

#include <cstddef>
#include <span>

namespace wayproof {

struct Peak {
  double bound;     // no polynomial is larger anywhere, apart from rounding (some 1e-15 of the coefficients)
  std::size_t row;  // row of the largest polynomial
  double fraction;  // and its position on the interval
};

// Halves intervals (de Casteljau) until the bound is within `tolerance` of an attained value. Coefficients:
// [rows][terms].
Peak peak(std::span<const double> coefficients, std::size_t terms, double tolerance);

}  // namespace wayproof
