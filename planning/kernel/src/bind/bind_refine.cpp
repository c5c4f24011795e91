// DistanceQuery and PenaltyQp, on numpy arrays and without the interpreter's lock.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "checker/distance_query.hpp"
#include "qp/penalty_qp.hpp"

namespace wayproof {
namespace {

std::vector<double> copy_of(const Doubles& array, std::size_t count, const char* name) {
  const auto numbers = finite(row(array, count, name), name);
  return {numbers.begin(), numbers.end()};
}

std::vector<std::int64_t> copy_of(const Integers& array, const char* name) {
  const auto numbers = row(array, name);
  return {numbers.begin(), numbers.end()};
}

void make(DistanceQuery* self, const std::shared_ptr<Scene>& scene, const Integers& positions,
          const Integers& velocities, const Doubles& state) {
  Group moving = group(*scene, positions, velocities, state);
  new (self) DistanceQuery(immutable(scene), std::move(moving));
}

auto within(const DistanceQuery& query, const Doubles& qs, const Doubles& reach) {
  const auto nv = static_cast<std::size_t>(query.num_velocities());
  const Table rows = table(qs, static_cast<std::size_t>(query.num_positions()), "qs");
  const auto reaches = ordered(row(reach, query.num_pairs(), "reach"), "reach");
  finite(rows.all(), "qs");
  DistanceRows found;
  {
    nb::gil_scoped_release released;
    found = query.within(rows.all(), rows.rows, reaches);
  }
  const std::size_t count = found.pair.size();
  return nb::make_tuple(array_of(found.configuration, count), array_of(found.pair, count),
                        array_of(found.distance, count), array_of(found.normal, count, 3),
                        array_of(found.gradient, count, nv));
}

// Rows of products: the columns of the first slope of every weight, of which -1 is none; weights and slopes.
ProductRows products_of(const std::tuple<Integers, Doubles, Doubles>& given, std::size_t num_variables) {
  const auto& [columns, weights, slopes] = given;
  if (weights.ndim() != 2 || slopes.ndim() != 2) refuse("weights and slopes of products do not have two dimensions");
  const std::size_t rows = weights.shape(0), num_weights = weights.shape(1), num_slopes = slopes.shape(1);
  if (columns.ndim() != 2 || columns.shape(0) != rows || columns.shape(1) != num_weights)
    refuse("point_columns do not have the shape of weights");
  ProductRows found{num_weights, num_slopes, {columns.data(), columns.data() + columns.size()}, {}, {}};
  for (std::int64_t column : found.columns)
    if (column != -1) index(column, num_variables < num_slopes ? 0 : num_variables - num_slopes + 1, "point_columns");
  const auto w = finite(table(weights, rows, num_weights, "weights").all(), "weights");
  const auto g = finite(table(slopes, rows, num_slopes, "slopes").all(), "slopes");
  found.weights.assign(w.begin(), w.end()), found.slopes.assign(g.begin(), g.end());
  return found;
}

auto solve_rows(const std::tuple<Doubles, Doubles, Doubles, Doubles>& variables,
                const std::tuple<Integers, Integers, Doubles>& rows,
                const std::tuple<Integers, Doubles, Doubles>& products, const Balls& balls, const Doubles& least,
                const Doubles& price, double tolerance, int max_steps) {
  const auto& [c, q, lower, upper] = variables;
  const auto& [starts, columns, values] = rows;
  const std::size_t count = row(c, "c").size(), num_rows = row(least, "least").size();
  const std::size_t entries = row(columns, "columns").size();
  if (max_steps < 0) refuse("max_steps is " + std::to_string(max_steps) + ", not 0 or more");
  PenaltyQp program{static_cast<int>(count),
                    copy_of(c, count, "c"),
                    copy_of(q, count, "q"),
                    copy_of(lower, count, "lower"),
                    copy_of(upper, count, "upper"),
                    copy_of(starts, "starts"),
                    copy_of(columns, "columns"),
                    copy_of(values, entries, "values"),
                    {},
                    products_of(products, count),
                    balls_of(balls, count),
                    copy_of(least, num_rows, "least"),
                    copy_of(price, num_rows, "price")};
  for (std::size_t i = 0; i < count; ++i)
    if (!(program.lower[i] < program.upper[i])) refuse("lower is not below upper at " + std::to_string(i));
  const std::size_t num_others = program.products.rows() + program.balls.size();
  if (num_others > num_rows) refuse("least has fewer numbers than there are products and balls");
  require_starts(program.starts, num_rows - num_others, entries);
  indices(program.columns, count, "columns");
  PenaltySolution found;
  {
    nb::gil_scoped_release released;
    found = solve(std::move(program), tolerance, max_steps);
  }
  return nb::make_tuple(array_of(found.x, found.x.size()), found.steps, found.gap);
}

}  // namespace

void bind_refine(nb::module_& m) {
  nb::class_<DistanceQuery>(m, "DistanceQuery", "Signed distances of near pairs, and their gradients.")
      .def("__init__", &make, nb::arg("scene"), nb::arg("positions"), nb::arg("velocities"), nb::arg("state"))
      .def("within", &within, nb::arg("qs"), nb::arg("reach"));
  m.def("solve_penalty_qp", &solve_rows, nb::arg("variables"), nb::arg("rows"), nb::arg("products"), nb::arg("balls"),
        nb::arg("least"), nb::arg("price"), nb::arg("tolerance"), nb::arg("max_steps"),
        "Minimise c x + q x^2 / 2 + price max(0, least - A x) in a box, with -|c + A x| for balls; x, steps, gap.");
}

}  // namespace wayproof
