// PenaltyQp: convex quadratic programs in a box, whose rows may be violated at a linear price.
//
//   minimise  c . x + 1/2 sum_i q_i x_i^2 + sum_k price_k max(0, least_k - a_k . x),  lower <= x <= upper
//
// where -|c_k + A_k x| may be in the place of a_k . x,
// by a primal-dual interior point method with Mehrotra's predictor and corrector ("On the implementation of a
// primal-dual interior point method", 1992). A solution always exists. The normal equations are solved by a Cholesky
// factorisation within their skyline: variables that share rows should have near indices.
#pragma once

#include <cstdint>
#include <vector>

#include "qp/ball_rows.hpp"
#include "qp/lane_rows.hpp"
#include "qp/product_rows.hpp"

namespace wayproof {

struct PenaltyQp {
  int num_variables = 0;
  std::vector<double> c, q, lower, upper;
  std::vector<std::int64_t> starts, columns;  // of the rows' entries, as in compressed sparse rows
  std::vector<double> values;
  LaneRows lanes;                    // more rows, after those
  ProductRows products;              // more rows, after those
  BallRows balls;                    // more rows, after those
  std::vector<double> least, price;  // of all rows
};

struct PenaltySolution {
  std::vector<double> x;
  int steps = 0;
  double gap = 0;  // the mean product of a slack and its multiplier where it stopped
};

// Stops once residuals and gap are below `tolerance`, relative to the cost, where digits are exhausted, or after
// `max_steps`; what it returns is finite.
PenaltySolution solve(PenaltyQp program, double tolerance, int max_steps);

// What is minimised, at x.
double cost_of(const PenaltyQp& program, const std::vector<double>& x);

}  // namespace wayproof
