// PathRates: a path's derivatives over limits, eight joints at once, from which follow those of motions along it:
//
//   q' = r' v,   q'' = r' a + r'' v^2,   q''' = r' j + 3 r'' v a + r''' v^3
#pragma once

#include <vector>

#include "math/lanes.hpp"
#include "timing/speed_profile.hpp"

namespace wayproof {

// Of eight joints at one parameter, over limits: the factors of v; a and v^2; j, v a and v^3.
struct RateFactors {
  Lanes v, a, v2, j, va, v3;
};

class PathRates {
 public:
  // Eight joints on a piece: coefficients `stride` numbers apart, and what their rates are multiplied by.
  struct Group {
    const double* coefficients;
    std::size_t terms, stride;
    const double* inverse_limits[3];
  };

  // The path is not copied.
  PathRates(const PolynomialPath& path, const RateLimits& limits);

  // Groups of eight joints; those of the last one that are missing have the factors 0.
  std::size_t groups() const { return groups_; }
  const PolynomialPath& path() const { return path_; }
  Group group(std::size_t piece, std::size_t index) const;
  // The factors of all groups at a parameter on a piece.
  void factors(std::size_t piece, double s, RateFactors* out) const;

 private:
  const PolynomialPath& path_;
  std::size_t groups_;
  std::vector<double> coefficients_;    // [pieces][terms][groups][8]
  std::vector<double> inverse_limits_;  // [3][groups][8]
};

}  // namespace wayproof
