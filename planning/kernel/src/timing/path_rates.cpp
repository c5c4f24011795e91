#include "timing/path_rates.hpp"

#include <algorithm>

#include "math/multiversion.hpp"

namespace wayproof {
namespace {

[[gnu::always_inline]] inline RateFactors factors_at(const PathRates::Group& group, double x) {
  Lanes first{}, second{}, third{};
  for (std::size_t k = group.terms; k-- > 1;) {
    const auto n = static_cast<double>(k);
    const Lanes c = load(group.coefficients + k * group.stride);
    first = first * x + c * n;
    if (k > 1) second = second * x + c * (n * (n - 1));
    if (k > 2) third = third * x + c * (n * (n - 1) * (n - 2));
  }
  const Lanes velocity = load(group.inverse_limits[0]), acceleration = load(group.inverse_limits[1]),
              jerk = load(group.inverse_limits[2]);
  return {first * velocity, first * acceleration, second * acceleration, first * jerk, 3 * second * jerk, third * jerk};
}

WAYPROOF_MULTIVERSION
void write_factors(const PathRates::Group& group, double x, RateFactors* out) { *out = factors_at(group, x); }

}  // namespace

PathRates::PathRates(const PolynomialPath& path, const RateLimits& limits)
    : path_(path),
      groups_((path.joints + num_lanes - 1) / num_lanes),
      coefficients_(path.pieces() * path.terms * groups_ * num_lanes),
      inverse_limits_(3 * groups_ * num_lanes) {
  const std::size_t stride = groups_ * num_lanes;
  for (std::size_t row = 0; row < path.pieces() * path.terms; ++row)
    std::copy_n(&path.coefficients[row * path.joints], path.joints, &coefficients_[row * stride]);
  for (std::size_t order = 0; order < 3; ++order)
    for (std::size_t i = 0; i < path.joints; ++i)
      inverse_limits_[order * stride + i] = 1 / limits[order * path.joints + i];
}

PathRates::Group PathRates::group(std::size_t piece, std::size_t index) const {
  const std::size_t stride = groups_ * num_lanes, first = index * num_lanes;
  const double* inverse = inverse_limits_.data() + first;
  return {coefficients_.data() + piece * path_.terms * stride + first,
          path_.terms,
          stride,
          {inverse, inverse + stride, inverse + 2 * stride}};
}

void PathRates::factors(std::size_t piece, double s, RateFactors* out) const {
  for (std::size_t g = 0; g < groups_; ++g) write_factors(group(piece, g), s - path_.breaks[piece], out + g);
}

}  // namespace wayproof
