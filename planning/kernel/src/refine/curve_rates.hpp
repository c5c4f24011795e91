// CurveRates: derivatives of a clamped uniform cubic spline at the intervals of a grid, over the bounds on rates.
//
// It is planning/refine/curves/path_velocity.py (PathGrid, NormalizedDerivatives) in native code, which tests compare
// with it. On every interval d2s/dt2 is constant, and b = (ds/dt)^2 is linear between its ends.
#pragma once

#include <cstddef>
#include <vector>

namespace wayproof {

// Control points with nonzero weight at an instant.
inline constexpr std::size_t weights_per_instant = 4;

// Weights of derivatives by s at both ends of n intervals.
struct CurveGrid {
  double step = 0;                    // width of an interval
  std::size_t num_points = 0;         // control points
  std::vector<int> first_point;       // [n], of four control points in sequence
  std::vector<double> first, second;  // of r' and r'': [n][2][4]
  std::vector<double> third;          // of r''': [n][4]

  std::size_t intervals() const { return first_point.size(); }
};

// Bounds on the rates of nq coordinates, as RateBounds of planning/refine has them.
struct RateBounds {
  std::vector<double> velocity, acceleration;
  std::vector<double> jerk;             // empty if it is not bounded
  std::vector<double> lowest, highest;  // acceleration over `acceleration`: negative, positive

  std::size_t coordinates() const { return velocity.size(); }
};

struct CurveRates {
  std::size_t coordinates = 0;
  std::vector<double> by_velocity;    // r' over velocity at the low end of every interval, [n][nq]
  std::vector<double> first, second;  // r' and r'' over acceleration, [n][2][nq]
  std::vector<double> third;          // r''' over jerk, [n][nq], or empty

  // Acceleration over its bound at an end of an interval, for a coordinate, if b is `b` there and has slope 2 u.
  double acceleration(std::size_t interval, std::size_t end, std::size_t coordinate, double b, double u) const {
    const std::size_t k = (2 * interval + end) * coordinates + coordinate;
    return second[k] * b + first[k] * u;
  }
};

// Of the curve with control points [num_points][nq].
CurveRates rates_of(const CurveGrid& grid, const RateBounds& bounds, const std::vector<double>& points);

// The duration at a squared path velocity b [n + 1].
double duration_of(const CurveGrid& grid, const std::vector<double>& b);

}  // namespace wayproof
