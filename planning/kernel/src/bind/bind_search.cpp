// RrtConnect with a Checker's verdicts, where the interpreter is asked about edges that are not sure, and told of the
// work.
#include <nanobind/stl/shared_ptr.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "checker/checker.hpp"
#include "search/rrt_connect.hpp"

namespace wayproof {
namespace {

// Work between two calls of the interpreter, a tenth of a millisecond or so. A sample may need no edge.
constexpr std::int64_t edges_per_report = 32, states_per_report = 4096, samples_per_report = 256;

struct CheckedConnect {
  const Checker* checker;
  double resolution;
  RrtConnect trees;
  std::int64_t num_edges = 0, num_states = 0, num_samples = 0;
};

void make(CheckedConnect* self, const Checker& checker, const Doubles& start, const Doubles& goals,
          const Doubles& lower, const Doubles& upper, double max_step, double resolution, std::uint32_t seed) {
  const auto nq = static_cast<std::size_t>(checker.num_positions());
  const auto from = finite(row(start, nq, "start"), "start");
  const Table to = table(goals, nq, "goals");
  require(to.rows > 0, "goals has no rows: there is nothing to connect to");
  const auto low = finite(row(lower, nq, "lower"), "lower"), high = finite(row(upper, nq, "upper"), "upper");
  for (std::size_t v = 0; v < nq; ++v)
    require(high[v] >= low[v] && std::isfinite(high[v] - low[v]), "upper is not above lower by a finite width");
  ConnectSpace space{{low.begin(), low.end()}, {high.begin(), high.end()}, positive(max_step, "max_step")};
  new (self) CheckedConnect{&checker, positive(resolution, "resolution"),
                            RrtConnect(std::move(space), from, finite(to.all(), "goals"), seed)};
}

auto array_of_row(std::span<const double> q) { return array_of(std::vector<double>(q.begin(), q.end()), q.size()); }

// Whether the trees met before `max_states` or `max_samples` were used up.
bool solve(CheckedConnect& self, const nb::callable& is_free, const nb::callable& report, double max_states,
           double max_samples) {
  std::int64_t reported = self.num_states;
  const auto tell = [&] {
    reported = self.num_states;
    const nb::gil_scoped_acquire held;
    report();
  };
  const auto is_edge_free = [&](std::span<const double> from, std::span<const double> to) {
    if (++self.num_edges % edges_per_report == 0 || self.num_states - reported >= states_per_report) tell();
    std::int64_t steps = 0;
    const Verdict verdict = self.checker->check_edge(from, to, self.resolution, steps);
    self.num_states += steps + 1;
    if (verdict != Verdict::unsure) return verdict == Verdict::free;
    const nb::gil_scoped_acquire held;
    return nb::cast<bool>(is_free(array_of_row(from), array_of_row(to)));
  };
  const auto is_over = [&] {
    if (++self.num_samples % samples_per_report == 0) tell();
    return static_cast<double>(self.num_states) >= max_states || static_cast<double>(self.num_samples) >= max_samples;
  };
  nb::gil_scoped_release released;
  return self.trees.solve(is_edge_free, is_over);
}

auto path(const CheckedConnect& self) {
  const std::vector<double> rows = self.trees.path();
  const auto nq = static_cast<std::size_t>(self.checker->num_positions());
  return array_of(rows, rows.size() / nq, nq);
}

}  // namespace

void bind_search(nb::module_& m) {
  nb::class_<CheckedConnect>(m, "RrtConnect", "Two trees, from the start and from the goals, until they meet.")
      .def("__init__", &make, nb::arg("checker"), nb::arg("start"), nb::arg("goals"), nb::arg("lower"),
           nb::arg("upper"), nb::arg("max_step"), nb::arg("resolution"), nb::arg("seed"), nb::keep_alive<1, 2>())
      .def("solve", &solve, nb::arg("is_free"), nb::arg("report"), nb::arg("max_states"), nb::arg("max_samples"))
      .def("path", &path)
      .def_ro("num_edges_checked", &CheckedConnect::num_edges)
      .def_ro("num_states_checked", &CheckedConnect::num_states)
      .def_prop_ro("num_vertices", [](const CheckedConnect& c) { return c.trees.num_vertices(); })
      .def_prop_ro("num_edges", [](const CheckedConnect& c) { return c.trees.num_edges(); })
      .def_prop_ro("goal_distance", [](const CheckedConnect& c) { return c.trees.goal_distance(); });
}

}  // namespace wayproof
