// Nearness and SoftRows, on numpy arrays and without the interpreter's lock.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>

#include <memory>

#include "bind/bind.hpp"
#include "checker/nearness.hpp"
#include "qp/penalty_qp.hpp"

namespace wayproof {
namespace {

std::vector<int> small(const Integers& from) { return {from.data(), from.data() + from.size()}; }
std::vector<std::int64_t> integers(const Integers& from) { return {from.data(), from.data() + from.size()}; }
std::vector<double> doubles(const Doubles& from) { return {from.data(), from.data() + from.size()}; }

void make(Nearness* self, std::shared_ptr<Scene> scene, const Integers& positions, const Integers& velocities,
          const Doubles& state) {
  require(state.size() == static_cast<std::size_t>(scene->tree.num_positions), "the state has the wrong length");
  for (std::size_t i = 0; i < positions.size(); ++i)
    require(positions.data()[i] >= 0 && positions.data()[i] < scene->tree.num_positions, "no such position");
  for (std::size_t i = 0; i < velocities.size(); ++i)
    require(velocities.data()[i] >= 0 && velocities.data()[i] < scene->tree.num_velocities, "no such velocity");
  Group group(scene->tree, small(positions), small(velocities), doubles(state));
  new (self) Nearness(std::move(scene), std::move(group));
}

auto within(const Nearness& nearness, const Doubles& qs, const Doubles& reach) {
  require(qs.ndim() == 2, "qs has two dimensions");
  require_shape(qs, qs.shape(0), nearness.num_positions(), "qs");
  require(reach.size() == nearness.num_pairs(), "there is one reach per pair");
  Near near;
  {
    nb::gil_scoped_release released;
    near = nearness.within(qs.data(), static_cast<std::int64_t>(qs.shape(0)), reach.data());
  }
  const std::size_t count = near.pair.size();
  return nb::make_tuple(array_of(near.configuration, count), array_of(near.pair, count), array_of(near.distance, count),
                        array_of(near.normal, count, 3), array_of(near.gradient, count, nearness.num_velocities()));
}

auto solve_rows(const std::tuple<Doubles, Doubles, Doubles, Doubles>& variables,
                const std::tuple<Integers, Integers, Doubles>& rows, const Doubles& least, const Doubles& price,
                double tolerance, int max_steps) {
  const auto& [c, q, lower, upper] = variables;
  const auto& [starts, columns, values] = rows;
  SoftRows program{static_cast<int>(c.size()), doubles(c), doubles(q), doubles(lower), doubles(upper), integers(starts),
                   integers(columns), doubles(values), doubles(least), doubles(price)};
  const std::size_t count = program.c.size(), entries = program.columns.size();
  require(program.q.size() == count && program.lower.size() == count && program.upper.size() == count,
          "there is one cost, curvature and box per variable");
  for (std::size_t i = 0; i < count; ++i) require(program.lower[i] < program.upper[i], "the box has an inside");
  require(program.starts.size() == program.least.size() + 1 && program.price.size() == program.least.size() &&
              program.values.size() == entries, "rows, bounds and prices fit");
  require(program.starts.front() == 0 && program.starts.back() == static_cast<std::int64_t>(entries), "rows begin and end");
  for (std::size_t k = 0; k + 1 < program.starts.size(); ++k)
    require(program.starts[k] <= program.starts[k + 1], "rows follow one another");
  for (auto column : program.columns) require(column >= 0 && column < static_cast<std::int64_t>(count), "no such variable");
  SoftSolution found;
  {
    nb::gil_scoped_release released;
    found = solve(program, tolerance, max_steps);
  }
  return nb::make_tuple(array_of(found.x, found.x.size()), found.steps, found.gap);
}

}  // namespace

void bind_refine(nb::module_& m) {
  nb::class_<Nearness>(m, "Nearness", "Signed distances of near pairs, and their gradients.")
      .def("__init__", &make, nb::arg("scene"), nb::arg("positions"), nb::arg("velocities"), nb::arg("state"))
      .def("within", &within, nb::arg("qs"), nb::arg("reach"));
  m.def("solve_soft_rows", &solve_rows, nb::arg("variables"), nb::arg("rows"), nb::arg("least"), nb::arg("price"),
        nb::arg("tolerance"), nb::arg("max_steps"),
        "Minimise c x + q x^2 / 2 + price max(0, least - A x) in a box; x, steps, gap.");
}

}  // namespace wayproof
