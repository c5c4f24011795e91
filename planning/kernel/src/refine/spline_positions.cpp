#include "refine/spline_positions.hpp"

#include <algorithm>

namespace wayproof {
namespace {

constexpr std::size_t degree = 3;

}  // namespace

// Piegl and Tiller, "The NURBS Book", 1997, algorithm A2.2, with knots in units of their spacing.
SplineWeights spline_weights(std::size_t num_points, double s) {
  const std::size_t num_spans = num_points - degree;
  const double u = s * static_cast<double>(num_spans), last = static_cast<double>(num_spans);
  const std::size_t span = u > 0 ? std::min(static_cast<std::size_t>(u), num_spans - 1) : 0;
  SplineWeights found{span, {1, 0, 0, 0}};
  double left[degree + 1], right[degree + 1];
  for (std::size_t j = 1; j <= degree; ++j) {
    left[j] = u - std::max(0.0, static_cast<double>(span + 1) - static_cast<double>(j));
    right[j] = std::min(last, static_cast<double>(span + j)) - u;
    double saved = 0;
    for (std::size_t r = 0; r < j; ++r) {
      const double share = found.weights[r] / (right[r + 1] + left[j - r]);
      found.weights[r] = saved + right[r + 1] * share;
      saved = left[j - r] * share;
    }
    found.weights[j] = saved;
  }
  return found;
}

std::vector<double> even_positions(std::span<const double> points, std::size_t coordinates, std::size_t num_intervals) {
  std::vector<double> positions((num_intervals + 1) * coordinates);
  for (std::size_t i = 0; i <= num_intervals; ++i) {
    const auto at =
        spline_weights(points.size() / coordinates, static_cast<double>(i) / static_cast<double>(num_intervals));
    const double* from = points.data() + at.first_point * coordinates;
    for (std::size_t j = 0; j < coordinates; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < weights_per_instant; ++k) sum += at.weights[k] * from[k * coordinates + j];
      positions[i * coordinates + j] = sum;
    }
  }
  return positions;
}

}  // namespace wayproof
