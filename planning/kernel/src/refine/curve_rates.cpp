#include "refine/curve_rates.hpp"

#include <cmath>

namespace wayproof {
namespace {

// A derivative at one instant of the curve: its weights times four control points.
void weigh(const double* weights, const double* points, std::size_t coordinates, double* sum) {
  for (std::size_t j = 0; j < coordinates; ++j) {
    double total = 0;
    for (std::size_t k = 0; k < weights_per_instant; ++k) total += weights[k] * points[k * coordinates + j];
    sum[j] = total;
  }
}

}  // namespace

CurveRates rates_of(const CurveGrid& grid, const RateBounds& bounds, const std::vector<double>& points) {
  const std::size_t n = grid.intervals(), nq = bounds.coordinates();
  CurveRates rates{
      nq, std::vector<double>(n * nq), std::vector<double>(2 * n * nq), std::vector<double>(2 * n * nq), {}};
  if (!bounds.jerk.empty()) rates.third.resize(n * nq);
  for (std::size_t i = 0; i < n; ++i) {
    const double* four = &points[static_cast<std::size_t>(grid.first_point[i]) * nq];
    for (std::size_t end = 2 * i; end < 2 * i + 2; ++end) {
      weigh(&grid.first[end * weights_per_instant], four, nq, &rates.first[end * nq]);
      weigh(&grid.second[end * weights_per_instant], four, nq, &rates.second[end * nq]);
    }
    for (std::size_t j = 0; j < nq; ++j)
      rates.by_velocity[i * nq + j] = rates.first[2 * i * nq + j] / bounds.velocity[j];
    for (std::size_t k = 2 * i * nq; k < 2 * (i + 1) * nq; ++k) {
      rates.first[k] /= bounds.acceleration[k % nq];
      rates.second[k] /= bounds.acceleration[k % nq];
    }
    if (bounds.jerk.empty()) continue;
    weigh(&grid.third[i * weights_per_instant], four, nq, &rates.third[i * nq]);
    for (std::size_t j = 0; j < nq; ++j) rates.third[i * nq + j] /= bounds.jerk[j];
  }
  return rates;
}

double duration_of(const CurveGrid& grid, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < grid.intervals(); ++i) sum += 2 * grid.step / (std::sqrt(b[i + 1]) + std::sqrt(b[i]));
  return sum;
}

}  // namespace wayproof
