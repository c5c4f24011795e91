#include "refine/path_velocity.hpp"

#include <algorithm>
#include <cmath>

#include "math/elementary.hpp"
#include "qp/penalty_qp.hpp"

namespace wayproof {
namespace {

// Price of breaking a bound by its own size, against a cost of at most 1.
constexpr double bound_price = 10;
// Least coefficient of b in its bounds, so that b stays bounded where nothing moves [s^2].
constexpr double least_coefficient = 1e-12;
// Least b as a share of its upper bound, so that the motion stops nowhere between its ends.
constexpr double least_share = 1e-9;

// Upper bounds of b at the grid, from velocity, jerk, and loads in one of its variables; 0 at both ends.
std::vector<double> upper_bounds(const CurveGrid& grid, const CurveRates& rates, const LoadPlanes& loads) {
  const std::size_t n = grid.intervals(), nq = rates.coordinates, m = loads.per_interval;
  std::vector<double> coefficients(n + 1, least_coefficient), bounds(n + 1, 0.0);
  const auto raise = [&](std::size_t i, double to) { coefficients[i] = std::max(coefficients[i], to); };
  for (std::size_t i = 0; i < n; ++i) {
    double velocity = 0, jerk = 0;
    for (std::size_t j = 0; j < nq; ++j) velocity = std::max(velocity, std::abs(rates.by_velocity[i * nq + j]));
    raise(i, velocity * velocity);
    for (std::size_t j = 0; j < nq && !rates.third.empty(); ++j)
      jerk = std::max(jerk, std::abs(rates.third[i * nq + j]));
    if (jerk > 0) jerk = cube_root(jerk * jerk), raise(i, jerk), raise(i + 1, jerk);
    for (std::size_t k = i * m; k < (i + 1) * m; ++k) {
      if (loads.high[k] == 0) raise(i, loads.low[k]);
      if (loads.low[k] == 0) raise(i + 1, loads.high[k]);
    }
  }
  for (std::size_t i = 1; i < n; ++i) bounds[i] = 1 / coefficients[i];
  return bounds;
}

// The half planes of an interval, for b in units of its upper bounds.
void planes_of(const CurveGrid& grid, const RateBounds& bounds, const CurveRates& rates, const LoadPlanes& loads,
               std::size_t i, double low_unit, double high_unit, std::vector<HalfPlane>& planes) {
  const std::size_t nq = rates.coordinates, m = loads.per_interval;
  planes.clear();
  for (std::size_t end = 0; end < 2; ++end)
    for (std::size_t j = 0; j < nq; ++j) {
      const std::size_t k = (2 * i + end) * nq + j;
      const double slope = rates.first[k] / (2 * grid.step), second = rates.second[k];
      const double low = (end ? -slope : second - slope) * low_unit, high = (end ? second + slope : slope) * high_unit;
      planes.push_back({low / bounds.highest[j], high / bounds.highest[j]});
      planes.push_back({low / bounds.lowest[j], high / bounds.lowest[j]});
    }
  for (std::size_t k = i * m; k < (i + 1) * m; ++k)
    planes.push_back({loads.low[k] * low_unit, loads.high[k] * high_unit});
}

void add_row(PenaltyQp& program, std::size_t interval, std::size_t intervals, HalfPlane plane) {
  const auto column = static_cast<std::int64_t>(interval) - 1;
  if (interval > 0) program.columns.push_back(column), program.values.push_back(-plane.p);
  if (interval + 1 < intervals) program.columns.push_back(column + 1), program.values.push_back(-plane.q);
  program.starts.push_back(static_cast<std::int64_t>(program.columns.size()));
  program.least.push_back(-1), program.price.push_back(bound_price);
}

// The largest share of a bound that b uses.
double largest_share(const CurveGrid& grid, const RateBounds& bounds, const CurveRates& rates, const LoadPlanes& loads,
                     const std::vector<double>& b) {
  const std::size_t nq = rates.coordinates, m = loads.per_interval;
  double most = 0;
  for (std::size_t i = 0; i < grid.intervals(); ++i) {
    const double u = (b[i + 1] - b[i]) / (2 * grid.step);
    for (std::size_t end = 0; end < 2; ++end)
      for (std::size_t j = 0; j < nq; ++j) {
        const double value = rates.acceleration(i, end, j, b[i + end], u);
        most = std::max({most, value / bounds.lowest[j], value / bounds.highest[j]});
      }
    for (std::size_t k = i * m; k < (i + 1) * m; ++k)
      most = std::max(most, loads.low[k] * b[i] + loads.high[k] * b[i + 1]);
  }
  return most;
}

}  // namespace

void keep_binding(std::vector<HalfPlane>& planes) {
  std::erase_if(planes, [](HalfPlane h) { return !(std::max(h.p, 0.0) + std::max(h.q, 0.0) > 1); });
  if (planes.size() < 2) return;
  // The sides of the square, which other half planes may make superfluous, or be made so by.
  planes.push_back({1, 0}), planes.push_back({0, 1});
  std::sort(planes.begin(), planes.end(), [](HalfPlane a, HalfPlane b) { return a.p != b.p ? a.p < b.p : a.q < b.q; });
  std::size_t size = 0;
  for (const HalfPlane c : planes) {
    const auto turns_left = [&] {
      const HalfPlane a = planes[size - 2], b = planes[size - 1];
      return (b.p - a.p) * (c.q - a.q) - (b.q - a.q) * (c.p - a.p) >= 0;
    };
    // On the upper right, q falls as p rises.
    while (size > 0 && (planes[size - 1].q <= c.q || (size > 1 && turns_left()))) --size;
    planes[size++] = c;
  }
  planes.resize(size);
  std::erase_if(planes, [](HalfPlane h) { return (h.p == 1 && h.q == 0) || (h.p == 0 && h.q == 1); });
}

std::vector<double> minimum_time_path_velocity(const CurveGrid& grid, const RateBounds& bounds, const CurveRates& rates,
                                               const LoadPlanes& loads, double tolerance, int max_steps) {
  const std::size_t n = grid.intervals();
  const std::vector<double> upper = upper_bounds(grid, rates, loads);
  PenaltyQp program;
  program.num_variables = static_cast<int>(n) - 1;
  program.c.assign(n - 1, -1.0 / static_cast<double>(n - 1));
  program.q.assign(n - 1, 0.0), program.lower.assign(n - 1, 0.0), program.upper.assign(n - 1, 1.0);
  program.starts.push_back(0);
  std::vector<HalfPlane> planes;
  for (std::size_t i = 0; i < n; ++i) {
    planes_of(grid, bounds, rates, loads, i, upper[i], upper[i + 1], planes);
    keep_binding(planes);
    for (const HalfPlane plane : planes) add_row(program, i, n, plane);
  }
  const PenaltySolution found = solve(program, tolerance, max_steps);
  std::vector<double> b(n + 1, 0.0);
  for (std::size_t i = 1; i < n; ++i) b[i] = std::clamp(found.x[i - 1], least_share, 1.0) * upper[i];
  // The solver keeps bounds to its tolerance; b as a whole is divided by the largest share.
  const double share = std::max(1.0, largest_share(grid, bounds, rates, loads, b));
  for (double& value : b) value /= share;
  return b;
}

}  // namespace wayproof
