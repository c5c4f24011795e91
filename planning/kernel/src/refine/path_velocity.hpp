// The least duration of a curve, rest to rest: the largest squared path velocity b = (ds/dt)^2 at the points of a grid
// (Verscheure et al., "Time-optimal path tracking for robots", 2009).
//
// Every bound on accelerations or loads is a half plane p b_low + q b_high <= 1 of the values at both ends of an
// interval. Since b is not negative, only those on the upper right of the convex hull of all (p, q) can bind: a handful
// of each interval is left, for which the linear program is solved.
#pragma once

#include <vector>

#include "refine/curve_rates.hpp"

namespace wayproof {

// More half planes: low[i][k] b_i + high[i][k] b_{i+1} <= 1 on every interval i.
struct LoadPlanes {
  std::size_t per_interval = 0;
  std::vector<double> low, high;  // [n][per_interval]
};

// Returns b [n + 1], 0 at both ends, which keeps all bounds.
std::vector<double> minimum_time_path_velocity(const CurveGrid& grid, const RateBounds& bounds, const CurveRates& rates,
                                               const LoadPlanes& loads, double tolerance, int max_steps);

// A half plane p x + q y <= 1.
struct HalfPlane {
  double p, q;
};

// Leaves those that bind somewhere in the unit square, in order of p; their order before does not matter.
void keep_binding(std::vector<HalfPlane>& planes);

}  // namespace wayproof
