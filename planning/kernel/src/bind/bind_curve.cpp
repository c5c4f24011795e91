// CurveGrid: the least duration of curves, and convex steps of them, on numpy arrays and without the interpreter's
// lock.
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "refine/convex_step.hpp"
#include "refine/path_velocity.hpp"
#include "refine/spline_positions.hpp"

namespace wayproof {
namespace {

// velocity, acceleration, jerk (empty if it is not bounded), and lowest and highest shares of accelerations.
using Bounds = std::tuple<Doubles, Doubles, Doubles, Doubles>;
// Of every instant the first of four control points and their weights; of every margin its instant, itself, its
// gradient; the price of a metre.
using Margins = std::tuple<Integers, Doubles, Integers, Doubles, Doubles, double>;
// Starts, columns, values, bounds and prices of rows.
using Rows = std::tuple<Integers, Integers, Doubles, Doubles, Doubles>;
// Starts, columns, values, centers and prices of balls.
using BallsAndPrices = std::tuple<Integers, Integers, Doubles, Doubles, Doubles>;

std::vector<double> copy_of(std::span<const double> numbers) { return {numbers.begin(), numbers.end()}; }

std::vector<double> all_positive(std::span<const double> numbers, const char* name) {
  for (double x : numbers) positive(x, name);
  return copy_of(numbers);
}

// An array of finite numbers with three dimensions.
std::vector<double> cube(const Doubles& array, std::size_t rows, std::size_t columns, std::size_t depth,
                         const char* name) {
  if (array.ndim() != 3 || array.shape(0) != rows || array.shape(1) != columns || array.shape(2) != depth)
    refuse(std::string(name) + " do not have the shape (intervals, 2, 4)");
  return copy_of(finite({array.data(), array.size()}, name));
}

// Of four control points in sequence.
std::vector<int> first_points_of(const Integers& array, std::size_t num_points, const char* name) {
  return indices(row(array, name), num_points < weights_per_instant ? 0 : num_points - weights_per_instant + 1, name);
}

std::size_t num_points_of(std::int64_t count) {
  if (count < static_cast<std::int64_t>(weights_per_instant) || count > max_coordinates)
    refuse("num_points is not at least 4");
  return static_cast<std::size_t>(count);
}

void make(CurveGrid* self, const Integers& first_points, std::int64_t num_points, const Doubles& first,
          const Doubles& second, const Doubles& third, double step) {
  const std::size_t count = num_points_of(num_points);
  const auto points = first_points_of(first_points, count, "first_points");
  const std::size_t n = points.size();
  if (n < 2) refuse("there are fewer than two intervals");
  new (self) CurveGrid{positive(step, "step"),
                       count,
                       points,
                       cube(first, n, 2, weights_per_instant, "first"),
                       cube(second, n, 2, weights_per_instant, "second"),
                       copy_of(finite(table(third, n, weights_per_instant, "third").all(), "third"))};
}

RateBounds bounds_of(const Bounds& given) {
  const auto& [velocity, acceleration, jerk, range] = given;
  RateBounds bounds;
  bounds.velocity = all_positive(row(velocity, "velocity"), "velocity");
  const std::size_t nq = bounds.velocity.size();
  if (nq < 1) refuse("velocity is empty");
  bounds.acceleration = all_positive(row(acceleration, nq, "acceleration"), "acceleration");
  if (jerk.size() > 0) bounds.jerk = all_positive(row(jerk, nq, "jerk"), "jerk");
  const Table both = table(range, 2, nq, "acceleration_range");
  finite(both.all(), "acceleration_range");
  for (std::size_t j = 0; j < nq; ++j)
    if (!(both.row(0)[j] < 0 && both.row(1)[j] > 0)) refuse("acceleration_range is not negative, then positive");
  bounds.lowest.assign(both.row(0), both.row(0) + nq), bounds.highest.assign(both.row(1), both.row(1) + nq);
  return bounds;
}

std::vector<double> points_of(const CurveGrid& grid, const RateBounds& bounds, const Doubles& points) {
  return copy_of(finite(table(points, grid.num_points, bounds.coordinates(), "points").all(), "points"));
}

auto path_velocity(const CurveGrid& grid, const Bounds& given, const Doubles& points, const Doubles& low,
                   const Doubles& high, double tolerance, int max_steps) {
  const RateBounds bounds = bounds_of(given);
  const auto at = points_of(grid, bounds, points);
  if (low.ndim() != 2 || low.shape(0) != grid.intervals()) refuse("low does not have a row for every interval");
  if (max_steps < 0) refuse("max_steps is " + std::to_string(max_steps) + ", not 0 or more");
  const LoadPlanes loads{low.shape(1), copy_of(finite({low.data(), low.size()}, "low")),
                         copy_of(finite(table(high, grid.intervals(), low.shape(1), "high").all(), "high"))};
  std::vector<double> b;
  double duration = 0;
  {
    nb::gil_scoped_release released;
    b = minimum_time_path_velocity(grid, bounds, rates_of(grid, bounds, at), loads, tolerance, max_steps);
    duration = duration_of(grid, b);
  }
  return nb::make_tuple(array_of(b, b.size()), duration);
}

// None (-1) at both ends, and a column everywhere else.
void require_inner(std::span<const std::int64_t> columns, std::size_t ends, std::size_t count, const char* name) {
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const bool is_end = k < ends || k + ends >= columns.size();
    if (is_end ? columns[k] != -1 : columns[k] == -1)
      refuse(std::string(name) + " are not -1 at both ends and a column everywhere else");
    if (!is_end) index(columns[k], count, name);
  }
}

CurveColumns columns_of(const CurveGrid& grid, std::size_t nq, const Integers& points, const Integers& path_velocity,
                        std::int64_t num_variables) {
  if (num_variables < 1 || num_variables > max_coordinates) refuse("num_variables is not at least 1");
  const auto count = static_cast<std::size_t>(num_variables);
  if (points.ndim() != 2 || points.shape(0) != grid.num_points || points.shape(1) != nq)
    refuse("point_columns do not have the shape of points");
  CurveColumns columns{static_cast<int>(num_variables), {points.data(), points.data() + points.size()}, {}};
  require_inner(columns.points, nq, count, "point_columns");
  for (std::size_t k = nq; k + nq < columns.points.size(); ++k)
    if (columns.points[k] != columns.points[k - k % nq] + static_cast<std::int64_t>(k % nq))
      refuse("point_columns of a control point are not in sequence");
  const auto velocities = row(path_velocity, "velocity_columns");
  if (velocities.size() != grid.intervals() + 1) refuse("velocity_columns are not one more than the intervals");
  require_inner(velocities, 1, count, "velocity_columns");
  columns.path_velocity.assign(velocities.begin(), velocities.end());
  return columns;
}

StepBox box_of(const std::tuple<Doubles, Doubles, Doubles>& given, std::size_t nq) {
  const auto& [radii, lower, upper] = given;
  StepBox box{all_positive(row(radii, nq, "radii"), "radii"), copy_of(ordered(row(lower, nq, "lower"), "lower")),
              copy_of(ordered(row(upper, nq, "upper"), "upper"))};
  for (std::size_t j = 0; j < nq; ++j)
    if (!(box.lower[j] <= box.upper[j])) refuse("lower is above upper at " + std::to_string(j));
  return box;
}

DistanceMargins margins_of(const Margins& given, std::size_t num_points, std::size_t nq) {
  const auto& [first_points, weights, instants, margins, gradients, price] = given;
  DistanceMargins found;
  found.first_point = first_points_of(first_points, num_points, "sample_points");
  const std::size_t count = found.first_point.size(), rows = row(margins, "margins").size();
  found.weights = copy_of(finite(table(weights, count, weights_per_instant, "weights").all(), "weights"));
  found.instant = indices(row(instants, "sample_indices"), count, "sample_indices");
  if (found.instant.size() != rows) refuse("sample_indices are not as many as margins");
  found.margin = copy_of(finite(row(margins, "margins"), "margins"));
  found.gradient = copy_of(finite(table(gradients, rows, nq, "gradients").all(), "gradients"));
  found.price = finite(price, "price");
  return found;
}

MoreRows more_of(const Rows& given, const BallsAndPrices& more, std::size_t num_variables) {
  const auto& [starts, columns, values, least, price] = given;
  const auto& [ball_starts, ball_columns, ball_values, centers, ball_prices] = more;
  BallRows balls = balls_of({ball_starts, ball_columns, ball_values, centers}, num_variables);
  const std::size_t num_balls = balls.size();
  const auto begins = row(starts, "starts"), of = row(columns, "columns");
  const std::size_t rows = row(least, "least").size();
  require_starts(begins, rows, of.size());
  indices(of, num_variables, "columns");
  return {{begins.begin(), begins.end()},
          {of.begin(), of.end()},
          copy_of(finite(row(values, of.size(), "values"), "values")),
          copy_of(finite(row(least, "least"), "least")),
          copy_of(finite(row(price, rows, "price"), "price")),
          std::move(balls),
          copy_of(finite(row(ball_prices, num_balls, "ball_prices"), "ball_prices"))};
}

ModelWeights weights_of(const Doubles& given) {
  const auto w = finite(row(given, 7, "model_weights"), "model_weights");
  return {w[0], w[1], w[2], w[3], w[4], positive(w[5], "model_weights"), positive(w[6], "model_weights")};
}

auto step(const CurveGrid& grid, const Bounds& given, const Doubles& points, const Doubles& path_velocity,
          const std::tuple<Integers, Integers, std::int64_t>& layout, const Doubles& model_weights,
          const std::tuple<Doubles, Doubles, Doubles>& box, const Rows& more, const BallsAndPrices& balls,
          const Margins& margins, double tolerance, int max_steps) {
  const RateBounds bounds = bounds_of(given);
  const std::size_t nq = bounds.coordinates();
  const auto at = points_of(grid, bounds, points);
  const auto b = copy_of(finite(row(path_velocity, grid.intervals() + 1, "path_velocity"), "path_velocity"));
  for (std::size_t i = 0; i < b.size(); ++i)
    if (i == 0 || i + 1 == b.size() ? b[i] != 0 : !(b[i] > 0))
      refuse("path_velocity is not 0 at both ends, else positive");
  const auto columns = columns_of(grid, nq, std::get<0>(layout), std::get<1>(layout), std::get<2>(layout));
  const auto weights = weights_of(model_weights);
  const auto around = box_of(box, nq);
  const auto others = more_of(more, balls, static_cast<std::size_t>(columns.num_variables));
  const auto distances = margins_of(margins, grid.num_points, nq);
  if (max_steps < 0) refuse("max_steps is " + std::to_string(max_steps) + ", not 0 or more");
  ConvexStep found;
  {
    nb::gil_scoped_release released;
    found = convex_step(grid, bounds, columns, weights, around, at, b, others, distances, tolerance, max_steps);
  }
  return nb::make_tuple(array_of(found.points, grid.num_points, nq), found.decrease);
}

// Of every instant the first of four control points, and their weights.
auto position_weights(std::int64_t num_points, const Doubles& s) {
  const std::size_t count = num_points_of(num_points);
  const auto instants = row(s, "s");
  std::vector<std::int64_t> first_points;
  std::vector<double> weights;
  for (double at : instants) {
    if (!(at >= 0 && at <= 1)) refuse("s is not from 0 to 1");
    const SplineWeights found = spline_weights(count, at);
    first_points.push_back(static_cast<std::int64_t>(found.first_point));
    weights.insert(weights.end(), std::begin(found.weights), std::end(found.weights));
  }
  return nb::make_tuple(array_of(first_points, instants.size()),
                        array_of(weights, instants.size(), weights_per_instant));
}

auto positions(const Doubles& points, std::int64_t num_intervals) {
  if (points.ndim() != 2) refuse("points do not have two dimensions");
  num_points_of(static_cast<std::int64_t>(points.shape(0)));
  const std::size_t nq = points.shape(1);
  if (nq < 1) refuse("points have no coordinates");
  if (num_intervals < 1 || num_intervals > max_coordinates) refuse("num_intervals is not at least 1");
  const auto at = finite({points.data(), points.size()}, "points");
  const auto count = static_cast<std::size_t>(num_intervals);
  return array_of(even_positions(at, nq, count), count + 1, nq);
}

}  // namespace

void bind_curve(nb::module_& m) {
  m.def("spline_weights", &position_weights, nb::arg("num_points"), nb::arg("s"),
        "Of every instant the first of four control points of a spline, and their weights.");
  m.def("spline_positions", &positions, nb::arg("points"), nb::arg("num_intervals"),
        "Positions of a spline at the ends of equal intervals.");
  nb::class_<CurveGrid>(m, "CurveGrid", "Weights of a spline's derivatives at both ends of the intervals of a grid.")
      .def("__init__", &make, nb::arg("first_points"), nb::arg("num_points"), nb::arg("first"), nb::arg("second"),
           nb::arg("third"), nb::arg("step"))
      .def("path_velocity", &path_velocity, nb::arg("bounds"), nb::arg("points"), nb::arg("low"), nb::arg("high"),
           nb::arg("tolerance"), nb::arg("max_steps"),
           "The largest squared path velocity of a curve, and the duration.")
      .def("step", &step, nb::arg("bounds"), nb::arg("points"), nb::arg("path_velocity"), nb::arg("layout"),
           nb::arg("model_weights"), nb::arg("box"), nb::arg("rows"), nb::arg("balls"), nb::arg("margins"),
           nb::arg("tolerance"), nb::arg("max_steps"),
           "The control points of a convex step, and the decrease that the model predicts.");
}

}  // namespace wayproof
