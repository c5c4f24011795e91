// Checker, on numpy arrays and without the interpreter's lock.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>

#include "bind/bind.hpp"
#include "checker/checker.hpp"

namespace wayproof {
namespace {

std::vector<int> integers(const Integers& from) {
  std::vector<int> found;
  for (std::size_t i = 0; i < from.size(); ++i) found.push_back(static_cast<int>(from.data()[i]));
  return found;
}

LaneKernel kernel_named(const std::string& name) {
  LaneKernel all[4];
  const int count = lane_kernels(all, 4);
  for (int i = 0; i < count; ++i)
    if (name.empty() || name == all[i].name) return all[i];
  throw std::invalid_argument("this machine has no lane kernel " + name);
}

Group group(const Scene& scene, const Integers& positions, const Integers& velocities, const Doubles& state) {
  const std::size_t count = scene.tree.num_positions;
  require(state.size() == count, "the state has the wrong length");
  for (std::size_t i = 0; i < positions.size(); ++i)
    require(positions.data()[i] >= 0 && positions.data()[i] < static_cast<std::int64_t>(count), "no such position");
  return Group(scene.tree, integers(positions), integers(velocities), std::vector<double>(state.data(), state.data() + count));
}

auto judge(const Checker& checker, const Doubles& qs) {
  require(qs.ndim() == 2 && qs.shape(1) == static_cast<std::size_t>(checker.num_positions()), "qs has one column per position");
  std::vector<Verdict> verdicts(qs.shape(0));
  {
    nb::gil_scoped_release released;
    checker.judge(qs.data(), static_cast<std::int64_t>(qs.shape(0)), verdicts.data());
  }
  std::vector<std::uint8_t> plain(verdicts.size());
  for (std::size_t i = 0; i < plain.size(); ++i) plain[i] = static_cast<std::uint8_t>(verdicts[i]);
  return array_of(plain, plain.size());
}

int judge_one(const Checker& checker, const Doubles& q) {
  require(q.size() == static_cast<std::size_t>(checker.num_positions()), "q has one number per position");
  Verdict verdict;
  checker.judge(q.data(), 1, &verdict);
  return static_cast<int>(verdict);
}

auto judge_motions(const Checker& checker, const Doubles& origins, const Doubles& displacements, double resolution) {
  const std::size_t count = origins.ndim() ? origins.shape(0) : 0, nq = checker.num_positions();
  require_shape(origins, count, nq, "origins");
  require_shape(displacements, count, nq, "displacements");
  require(resolution > 0, "the resolution is positive");
  std::vector<Verdict> verdicts(count);
  std::vector<Unsure> unsure;
  {
    nb::gil_scoped_release released;
    checker.judge_motions(origins.data(), displacements.data(), resolution, static_cast<std::int64_t>(count), verdicts.data(), unsure);
  }
  std::vector<std::uint8_t> plain(count);
  for (std::size_t i = 0; i < count; ++i) plain[i] = static_cast<std::uint8_t>(verdicts[i]);
  std::vector<std::int64_t> rows;
  for (const Unsure& u : unsure) rows.insert(rows.end(), {u.motion, u.i, u.n});
  return nb::make_tuple(array_of(plain, count), array_of(rows, unsure.size(), 3));
}

// One motion: its verdict alone.
auto judge_motion(const Checker& checker, const Doubles& origin, const Doubles& displacement, double resolution) {
  const std::size_t nq = checker.num_positions();
  require(origin.size() == nq && displacement.size() == nq, "origin and displacement have one number per position");
  require(resolution > 0, "the resolution is positive");
  Verdict verdict;
  std::vector<Unsure> unsure;
  {
    nb::gil_scoped_release released;
    checker.judge_motions(origin.data(), displacement.data(), resolution, 1, &verdict, unsure);
  }
  return static_cast<int>(verdict);
}

// An edge between two lists of numbers: its verdict and its number of samples.
auto judge_edge(const Checker& checker, const std::vector<double>& from, const std::vector<double>& to, double resolution) {
  const std::size_t nq = checker.num_positions();
  require(from.size() == nq && to.size() == nq, "both ends have one number per position");
  require(resolution > 0, "the resolution is positive");
  std::int64_t n = 0;
  Verdict verdict;
  {
    nb::gil_scoped_release released;
    verdict = checker.judge_edge(from.data(), to.data(), resolution, n);
  }
  return std::make_tuple(static_cast<int>(verdict), n);
}

}  // namespace

void bind_checker(nb::module_& m) {
  nb::class_<Checker>(m, "Checker", "Collision verdicts, as the values of Verdict.")
      .def("__init__", [](Checker* self, std::shared_ptr<Scene> scene, const Integers& positions, const Integers& velocities,
                          const Doubles& state, const Doubles& demands, const std::string& kernel) {
        const std::size_t count = scene->pairs.size();
        require_shape(demands, count, 2, "demands");
        std::vector<Demand> demanded;
        for (std::size_t i = 0; i < count; ++i) demanded.push_back({demands.data()[2 * i], demands.data()[2 * i + 1]});
        Group moving = group(*scene, positions, velocities, state);
        new (self) Checker(std::move(scene), std::move(moving), std::move(demanded), kernel_named(kernel));
      }, nb::arg("scene"), nb::arg("positions"), nb::arg("velocities"), nb::arg("state"), nb::arg("demands"), nb::arg("kernel") = "")
      .def("judge", &judge, nb::arg("qs"))
      .def("judge_one", &judge_one, nb::arg("q"))
      .def("judge_motions", &judge_motions, nb::arg("origins"), nb::arg("displacements"), nb::arg("resolution"))
      .def("judge_motion", &judge_motion, nb::arg("origin"), nb::arg("displacement"), nb::arg("resolution"))
      .def("judge_edge", &judge_edge, nb::arg("q0"), nb::arg("q1"), nb::arg("resolution"))
      .def_prop_ro("doubtful_fixed_pairs", &Checker::doubtful_fixed_pairs)
      .def_prop_ro("lane_kernel", [](const Checker& c) { return std::string(c.kernel().name); });
  m.def("lane_kernels", [] {
    LaneKernel all[4];
    const int count = lane_kernels(all, 4);
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) names.emplace_back(all[i].name);
    return names;
  }, "Names of the instruction sets that this machine can run, the fastest first.");
}

}  // namespace wayproof
