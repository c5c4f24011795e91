// Upper bounds on polynomials in Bernstein form, as planning/certify/intervals/bernstein.py has them.
#pragma once

#include <cstddef>

namespace wayproof {

struct Peak {
  double bound;     // no polynomial is larger anywhere, rounding (some 1e-15 of the coefficients) aside
  std::size_t row;  // which one may be
  double fraction;  // and where on its interval
};

// Halves intervals (de Casteljau) until the bound is within `tolerance` of a value that is taken.
Peak peak(const double* coefficients, std::size_t rows, std::size_t terms, double tolerance);

}  // namespace wayproof
