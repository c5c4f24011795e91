// ConvexStep: one step of refinement: the convex model of a curve's duration around a curve, and its minimum in a box.
//
// It is planning/refine/model/curve_model.py in native code, which says what the model is and which tests compare with
// it. Variables are control points in units of the box and b in units of itself; the cost is in durations.
#pragma once

#include <cstdint>
#include <vector>

#include "qp/penalty_qp.hpp"
#include "refine/curve_rates.hpp"

namespace wayproof {

// Columns of the variables; -1 for none.
struct CurveColumns {
  int num_variables = 0;
  std::vector<std::int64_t> points;         // [num_points][nq], none for the first and the last point
  std::vector<std::int64_t> path_velocity;  // [n + 1], none at both ends
};

// The numbers of the model that are chosen (see curve_model.py).
struct ModelWeights {
  double proximal;                         // cost of moving a control point by half of the box's side
  double most_decrease, most_increase;     // of b, relative
  double least_acceleration, least_speed;  // shares of bounds below which rates have no row
  double rate_price;                       // of breaking a bound by its own size
  double least_width;                      // of the box
};

// The box around control points: half of its sides, and the limits of positions.
struct StepBox {
  std::vector<double> radii, lower, upper;  // [nq]
};

// Signed margins that are to be positive, at instants of the curve.
struct DistanceMargins {
  std::vector<int> first_point;          // of every instant, of four control points in sequence
  std::vector<double> weights;           // of these, [instants][4]
  std::vector<int> instant;              // of every margin
  std::vector<double> margin, gradient;  // [margins], [margins][nq]
  double price = 0;                      // of a metre too little
};

// Rows of the same program that come from elsewhere.
struct MoreRows {
  std::vector<std::int64_t> starts{0}, columns;
  std::vector<double> values, least, price;
  BallRows balls;
  std::vector<double> ball_price;
};

// Which rows are in a program: those that are left out are not broken at its minimum, which is that of all rows then.
struct TakesPart {
  std::vector<char> more, balls, distances;
};

struct ConvexStep {
  std::vector<double> points;  // control points of the minimum, [num_points][nq]
  double decrease = 0;         // of the cost, as the model predicts it [s]
};

// The program around the curve with control points `points` and squared path velocity b; of the rows, those that
// take part.
PenaltyQp program_of(const CurveGrid& grid, const RateBounds& bounds, const CurveColumns& columns,
                     const ModelWeights& weights, const StepBox& box, const std::vector<double>& points,
                     const std::vector<double>& b, const MoreRows& more, const DistanceMargins& margins,
                     const TakesPart& takes_part);

ConvexStep convex_step(const CurveGrid& grid, const RateBounds& bounds, const CurveColumns& columns,
                       const ModelWeights& weights, const StepBox& box, const std::vector<double>& points,
                       const std::vector<double>& b, const MoreRows& more, const DistanceMargins& margins,
                       double tolerance, int max_steps);

}  // namespace wayproof
