// Load rows: the rows of one load in the program of a convex step, from the load's ratios along a curve and their
// derivatives. It is planning/refine/model/load_linearization.py in native code.
#pragma once

#include <cstdint>
#include <vector>

#include "refine/convex_step.hpp"

namespace wayproof {

// Instants of a motion, each on one interval of the grid, on which u is constant.
struct LoadInstants {
  std::size_t count, coordinates;
  double step;                             // width of an interval
  std::vector<int> first_point, interval;  // the first of four control points in sequence
  const double* fractions;                 // of the interval before the instant
  const double* ends;                      // b at both ends of the interval, [count][2]
  const double *rate, *curvature;          // r' and r'', [count][nq]
  const double* weights[3];                // of control points for r, r' and r'', [count][4]
};

// Vectors of ratios whose norms are bounded: `balls` at each instant, with `dims` components, 1 or 3.
struct LoadRatios {
  std::size_t balls, dims;
  const double* values;          // [count][balls][dims]
  const double* derivatives[3];  // by q, v and vdot, [count][balls][dims][nq]
  double bound, price;
};

// The rows that can bind within a step, and a ball for each vector of three components; `radii` are half of the box's
// sides, [nq]. Static loads depend on the curve alone, and have no instant twice. Numbers are bounded on both sides,
// unless they are on the upper one alone.
MoreRows load_rows(const LoadInstants& instants, const LoadRatios& ratios, const CurveColumns& columns,
                   const std::vector<double>& radii, bool is_static, bool is_one_sided);

}  // namespace wayproof
