// Positions of a clamped uniform cubic spline over s = 0 to 1, as weights of its control points.
//
// It is planning/refine/curves/bspline_basis.py in native code, which tests compare with it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "refine/curve_rates.hpp"

namespace wayproof {

// Of an instant: the first of four control points, and their weights.
struct SplineWeights {
  std::size_t first_point = 0;
  double weights[weights_per_instant] = {};
};

// Of a spline with at least four control points, at s from 0 to 1.
SplineWeights spline_weights(std::size_t num_points, double s);

// Positions [num_intervals + 1][coordinates] at s = i / num_intervals, of control points [num_points][coordinates].
std::vector<double> even_positions(std::span<const double> points, std::size_t coordinates, std::size_t num_intervals);

}  // namespace wayproof
