// Rows of loads on numpy arrays and without the interpreter's lock.
#include <nanobind/stl/tuple.h>

#include <string>
#include <tuple>
#include <vector>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "refine/load_rows.hpp"

namespace wayproof {
namespace {

// Of each instant: the first of four control points and its interval; the fraction of the interval before it, and b at
// both ends [n][2]; r' and r'' [2][n][nq]; weights of control points for r, r' and r'' [3][n][4]; and the width of an
// interval.
using Instants = std::tuple<Integers, Integers, Doubles, Doubles, Doubles, Doubles, double>;
// Columns of control points [k][nq] and of b at the grid.
using Layout = std::tuple<Integers, Integers>;

std::span<const double> numbers(const Doubles& array, const std::vector<std::size_t>& shape, const char* name) {
  bool fits = array.ndim() == shape.size();
  for (std::size_t i = 0; fits && i < shape.size(); ++i) fits = array.shape(i) == shape[i];
  if (!fits) refuse(std::string(name) + " do not have the shape that the other arguments have");
  return finite({array.data(), array.size()}, name);
}

void require_columns(std::span<const std::int64_t> columns, const char* name) {
  for (std::int64_t column : columns)
    if (column < -1) refuse(std::string(name) + " has " + std::to_string(column) + ", not -1 or a column");
}

CurveColumns columns_of(const Integers& points, const Integers& path_velocity, std::size_t nq) {
  if (points.ndim() != 2 || points.shape(1) != nq || points.shape(0) < weights_per_instant)
    refuse(
        "point_columns do not have a row for each of four control points or more, and a column for each of the radii");
  const auto of_velocities = row(path_velocity, "velocity_columns");
  CurveColumns columns;
  columns.points.assign(points.data(), points.data() + points.size());
  columns.path_velocity.assign(of_velocities.begin(), of_velocities.end());
  require_columns(columns.points, "point_columns"), require_columns(columns.path_velocity, "velocity_columns");
  if (columns.path_velocity.size() < 2) refuse("velocity_columns are fewer than two");
  return columns;
}

LoadInstants instants_of(const Instants& given, const CurveColumns& columns, std::size_t nq) {
  const auto& [first_points, intervals, fractions, ends, rates, weights, step] = given;
  LoadInstants at{};
  at.coordinates = nq, at.step = positive(step, "step");
  at.first_point = indices(row(first_points, "first_points"), columns.points.size() / nq - (weights_per_instant - 1),
                           "first_points");
  const std::size_t n = at.count = at.first_point.size();
  at.interval = indices(row(intervals, "intervals"), columns.path_velocity.size() - 1, "intervals");
  if (at.interval.size() != n) refuse("intervals are not as many as first_points");
  at.fractions = numbers(fractions, {n}, "fractions").data();
  const auto both = numbers(ends, {n, 2}, "ends");
  for (double b : both)
    if (b < 0) refuse("ends has a negative b");
  for (double fraction : std::span(at.fractions, n))
    if (fraction < 0 || fraction > 1) refuse("fractions has one that is not from 0 to 1");
  at.ends = both.data();
  at.rate = numbers(rates, {2, n, nq}, "rates").data(), at.curvature = at.rate + n * nq;
  const double* all = numbers(weights, {3, n, weights_per_instant}, "weights").data();
  for (std::size_t i = 0; i < 3; ++i) at.weights[i] = all + i * n * weights_per_instant;
  return at;
}

auto rows(const Instants& instants, const Doubles& ratios, const Doubles& derivatives, const Layout& layout,
          const Doubles& radii, double bound, double price, bool is_static, bool is_one_sided) {
  const auto half = row(radii, "radii");
  for (double x : half) positive(x, "radii");
  const std::size_t nq = half.size();
  if (nq < 1) refuse("radii is empty");
  const CurveColumns columns = columns_of(std::get<0>(layout), std::get<1>(layout), nq);
  const LoadInstants at = instants_of(instants, columns, nq);
  if (ratios.ndim() != 3 || ratios.shape(0) != at.count || (ratios.shape(2) != 1 && ratios.shape(2) != 3))
    refuse("ratios do not have the shape (instants, balls, 1 or 3)");
  const std::size_t balls = ratios.shape(1), dims = ratios.shape(2);
  LoadRatios load{balls, dims, numbers(ratios, {at.count, balls, dims}, "ratios").data(), {}, 0, 0};
  const double* all = numbers(derivatives, {3, at.count, balls, dims, nq}, "derivatives").data();
  for (std::size_t i = 0; i < 3; ++i) load.derivatives[i] = all + i * at.count * balls * dims * nq;
  load.bound = positive(bound, "bound"), load.price = positive(price, "price");
  MoreRows found;
  {
    nb::gil_scoped_release released;
    found = load_rows(at, load, columns, {half.begin(), half.end()}, is_static, is_one_sided);
  }
  const BallRows& in_balls = found.balls;
  return nb::make_tuple(nb::make_tuple(array_of(found.starts, found.starts.size()),
                                       array_of(found.columns, found.columns.size()),
                                       array_of(found.values, found.values.size()),
                                       array_of(found.least, found.least.size()),
                                       array_of(found.price, found.price.size())),
                        nb::make_tuple(array_of(in_balls.starts, in_balls.starts.size()),
                                       array_of(in_balls.columns, in_balls.columns.size()),
                                       array_of(in_balls.values, in_balls.values.size()),
                                       array_of(in_balls.centers, in_balls.centers.size()),
                                       array_of(found.ball_price, found.ball_price.size())));
}

}  // namespace

void bind_loads(nb::module_& m) {
  m.def(
      "load_rows", &rows, nb::arg("instants"), nb::arg("ratios"), nb::arg("derivatives"), nb::arg("layout"),
      nb::arg("radii"), nb::arg("bound"), nb::arg("price"), nb::arg("is_static"), nb::arg("is_one_sided"),
      "Of a load within a convex step, rows that can bind and balls: starts, columns, values, bounds, prices of each.");
}

}  // namespace wayproof
