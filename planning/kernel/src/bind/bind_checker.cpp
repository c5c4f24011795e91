// Checker, on numpy arrays and without the interpreter's lock.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "checker/checker.hpp"

namespace wayproof {
namespace {

static_assert(sizeof(Verdict) == sizeof(std::uint8_t), "arrays of verdicts are arrays of bytes");

std::vector<std::uint8_t> numbers_of(const std::vector<Verdict>& verdicts) {
  std::vector<std::uint8_t> numbers(verdicts.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::uint8_t>(verdicts[i]);
  return numbers;
}

// Whether each is not known to collide.
auto flags_of(const std::vector<Verdict>& verdicts) {
  std::vector<bool> flags(verdicts.size());
  for (std::size_t i = 0; i < flags.size(); ++i) flags[i] = verdicts[i] != Verdict::colliding;
  return array_of(flags, flags.size());
}

// Rows of motion, i and n.
auto samples_of(const std::vector<Unsure>& unsure) {
  std::vector<std::int64_t> rows;
  for (const Unsure& u : unsure) rows.insert(rows.end(), {u.motion, u.i, u.n});
  return array_of(rows, unsure.size(), 3);
}

std::size_t columns(const Checker& checker) { return static_cast<std::size_t>(checker.num_positions()); }

auto check(const Checker& checker, const Doubles& qs) {
  const Table rows = table(qs, columns(checker), "qs");
  std::vector<Verdict> verdicts(rows.rows);
  {
    nb::gil_scoped_release released;
    checker.check(rows.all(), verdicts);
  }
  return array_of(numbers_of(verdicts), verdicts.size());
}

// Whether each does not collide, and the numbers of those that are unsure.
auto check_free(const Checker& checker, const Doubles& qs) {
  const Table rows = table(qs, columns(checker), "qs");
  std::vector<Verdict> verdicts(rows.rows);
  {
    nb::gil_scoped_release released;
    checker.check(rows.all(), verdicts);
  }
  std::vector<std::int64_t> unsure;
  for (std::size_t i = 0; i < verdicts.size(); ++i)
    if (verdicts[i] == Verdict::unsure) unsure.push_back(static_cast<std::int64_t>(i));
  return nb::make_tuple(flags_of(verdicts), array_of(unsure, unsure.size()));
}

int check_one(const Checker& checker, const Doubles& q) {
  Verdict verdict{};
  checker.check(row(q, columns(checker), "q"), {&verdict, 1});
  return static_cast<int>(verdict);
}

auto check_motions(const Checker& checker, const Doubles& origins, const Doubles& displacements, double resolution) {
  const Table from = table(origins, columns(checker), "origins");
  const Table by = table(displacements, from.rows, columns(checker), "displacements");
  positive(resolution, "resolution");
  std::vector<Verdict> verdicts(from.rows);
  std::vector<Unsure> unsure;
  {
    nb::gil_scoped_release released;
    checker.check_motions(from.all(), by.all(), resolution, verdicts, unsure);
  }
  return nb::make_tuple(array_of(numbers_of(verdicts), from.rows), samples_of(unsure));
}

// Rows of edges: whether each does not collide, samples that are unsure, and how many samples there are; None if those
// are more than `most`.
nb::object check_edges(const Checker& checker, const Doubles& q0s, const Doubles& q1s, double resolution,
                       std::int64_t most) {
  const Table from = table(q0s, columns(checker), "q0s");
  const Table to = table(q1s, from.rows, columns(checker), "q1s");
  positive(resolution, "resolution");
  std::vector<Verdict> verdicts(from.rows);
  std::vector<Unsure> unsure;
  std::int64_t total = 0;
  {
    nb::gil_scoped_release released;
    total = checker.check_edges(from.all(), to.all(), resolution, most, verdicts, unsure);
  }
  if (total > most) return nb::none();
  return nb::make_tuple(flags_of(verdicts), samples_of(unsure), total);
}

// The first edge that does not collide: its index, whether that is sure, and how many samples were asked for.
auto first_edge(const Checker& checker, const Doubles& q0s, const Doubles& q1s, double resolution, std::int64_t most) {
  const Table from = table(q0s, columns(checker), "q0s"), to = table(q1s, columns(checker), "q1s");
  require(from.rows == to.rows || from.rows == 1 || to.rows == 1, "q0s and q1s differ in their number of rows");
  positive(resolution, "resolution");
  const std::size_t count = from.rows && to.rows ? std::max(from.rows, to.rows) : 0;
  nb::gil_scoped_release released;
  const FirstEdge found = checker.first_edge(from.all(), to.all(), count, resolution, most);
  return std::make_tuple(found.index, found.verdict != Verdict::unsure, found.num_samples);
}

// One motion: its verdict alone.
int check_motion(const Checker& checker, const Doubles& origin, const Doubles& displacement, double resolution) {
  const auto from = row(origin, columns(checker), "origin"), by = row(displacement, columns(checker), "displacement");
  positive(resolution, "resolution");
  Verdict verdict{};
  std::vector<Unsure> unsure;
  {
    nb::gil_scoped_release released;
    checker.check_motions(from, by, resolution, {&verdict, 1}, unsure);
  }
  return static_cast<int>(verdict);
}

// An edge between two lists of numbers: its verdict and its number of samples.
auto check_edge(const Checker& checker, const std::vector<double>& from, const std::vector<double>& to,
                double resolution) {
  const std::size_t nq = columns(checker);
  if (from.size() != nq || to.size() != nq)
    refuse("q0 and q1 have " + std::to_string(from.size()) + " and " + std::to_string(to.size()) + " numbers, not " +
           std::to_string(nq) + " each");
  positive(resolution, "resolution");
  std::int64_t n = 0;
  Verdict verdict{};
  {
    nb::gil_scoped_release released;
    verdict = checker.check_edge(from, to, resolution, n);
  }
  return std::make_tuple(static_cast<int>(verdict), n);
}

void make(Checker* self, const std::shared_ptr<Scene>& scene, const Integers& positions, const Integers& velocities,
          const Doubles& state, const Doubles& thresholds, const std::string& kernel) {
  const Table rows = table(thresholds, scene->pairs.size(), 2, "thresholds");
  ordered(rows.all(), "thresholds");
  std::vector<PairThreshold> limits;
  limits.reserve(rows.rows);
  for (std::size_t i = 0; i < rows.rows; ++i) limits.push_back({rows.row(i)[0], rows.row(i)[1]});
  const BatchKernel chosen = kernel_named(kernel, &batch_kernels);
  Group moving = group(*scene, positions, velocities, state);
  new (self) Checker(immutable(scene), std::move(moving), std::move(limits), chosen);
}

}  // namespace

void bind_checker(nb::module_& m) {
  nb::class_<Checker>(m, "Checker", "Collision verdicts, as the values of Verdict.")
      .def("__init__", &make, nb::arg("scene"), nb::arg("positions"), nb::arg("velocities"), nb::arg("state"),
           nb::arg("thresholds"), nb::arg("kernel") = "")
      .def("check", &check, nb::arg("qs"))
      .def("check_free", &check_free, nb::arg("qs"))
      .def("check_one", &check_one, nb::arg("q"))
      .def("check_motions", &check_motions, nb::arg("origins"), nb::arg("displacements"), nb::arg("resolution"))
      .def("check_motion", &check_motion, nb::arg("origin"), nb::arg("displacement"), nb::arg("resolution"))
      .def("check_edges", &check_edges, nb::arg("q0s"), nb::arg("q1s"), nb::arg("resolution"), nb::arg("most"))
      .def("first_edge", &first_edge, nb::arg("q0s"), nb::arg("q1s"), nb::arg("resolution"), nb::arg("most"))
      .def("check_edge", &check_edge, nb::arg("q0"), nb::arg("q1"), nb::arg("resolution"))
      .def_prop_ro("undecided_static_pairs", &Checker::undecided_static_pairs)
      .def_prop_ro("batch_kernel", [](const Checker& c) { return std::string(c.kernel().name); });
  m.def(
      "batch_kernels",
      [] {
        BatchKernel all[4];
        const int count = batch_kernels(all, 4);
        std::vector<std::string> names;
        names.reserve(static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i) names.emplace_back(all[i].name);
        return names;
      },
      "Names of the instruction sets that this machine can run, the fastest first.");
}

}  // namespace wayproof
