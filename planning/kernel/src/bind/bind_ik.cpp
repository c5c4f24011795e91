// Kinematics of a frame that a group moves, on numpy arrays and without the interpreter's lock.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <memory>
#include <new>

#include "bind/bind.hpp"
#include "ik/ik_model.hpp"
#include "model/kinematics.hpp"
#include "model/scene.hpp"

namespace wayproof {
namespace {

std::vector<int> integers(const Integers& from, int below, const char* message) {
  std::vector<int> found;
  for (std::size_t i = 0; i < from.size(); ++i) {
    require(from.data()[i] >= 0 && from.data()[i] < below, message);
    found.push_back(static_cast<int>(from.data()[i]));
  }
  return found;
}

Chain chain(const Scene& scene, const Integers& positions, const Integers& velocities,
            const Doubles& state, int link, const Doubles& X_LT) {
  const Tree& tree = scene.tree;
  require(state.size() == static_cast<std::size_t>(tree.num_positions), "the state has the wrong length");
  require(link < static_cast<int>(tree.links.size()), "no such link");
  require(X_LT.size() == 12, "X_LT has 12 numbers");
  const Group group(tree, integers(positions, tree.num_positions, "no such position"),
                    integers(velocities, tree.num_velocities, "no such velocity"),
                    std::vector<double>(state.data(), state.data() + state.size()));
  return Chain(tree, group, link, transform(X_LT.data()));
}

std::size_t rows(const Chain& c, const Doubles& qs) {
  require(qs.ndim() == 2 && qs.shape(1) == static_cast<std::size_t>(c.num_positions),
          "qs has one column per position");
  return qs.shape(0);
}

auto poses(const Chain& c, const Doubles& qs) {
  const std::size_t count = rows(c, qs);
  std::vector<double> found(12 * count);
  {
    nb::gil_scoped_release released;
    for (std::size_t i = 0; i < count; ++i) {
      const Transform X = c.pose(qs.data() + i * c.num_positions);
      for (int k = 0; k < 9; ++k) found[12 * i + k] = X.R.m[k];
      for (int k = 0; k < 3; ++k) found[12 * i + 9 + k] = X.p[k];
    }
  }
  return array_of(found, count, 12);
}

auto jacobians(const Chain& c, const Doubles& qs) {
  const std::size_t count = rows(c, qs);
  std::vector<double> found(6 * c.num_velocities * count);
  {
    nb::gil_scoped_release released;
    for (std::size_t i = 0; i < count; ++i)
      c.jacobian(qs.data() + i * c.num_positions, found.data() + 6 * c.num_velocities * i);
  }
  return array_of(found, count, 6, c.num_velocities);
}

IkKernel kernel_named(const std::string& name) {
  IkKernel all[4];
  const int count = ik_kernels(all, 4);
  for (int i = 0; i < count; ++i)
    if (name.empty() || name == all[i].name) return all[i];
  throw std::invalid_argument("this machine has no lane kernel " + name);
}

IkTolerance tolerance(const Doubles& box, Freedom freedom, int axis, double bound) {
  require(box.size() == 3, "a box has three half-widths");
  require(axis >= 0 && axis <= 2, "no such axis");
  return {{box.data()[0], box.data()[1], box.data()[2]}, freedom, axis, bound};
}

auto solve(const Chain& c, const Doubles& seeds, const Integers& target_of, const Doubles& targets,
           const Doubles& lower, const Doubles& upper, const IkTolerance& wanted, std::int64_t enough,
           int max_iterations, const std::string& name) {
  const std::size_t count = rows(c, seeds), nq = c.num_positions;
  require(lower.size() == nq && upper.size() == nq, "limits have one number per position");
  require(targets.ndim() == 2 && targets.shape(1) == 12, "targets have 12 columns");
  require(target_of.size() == count, "every seed has a target");
  for (std::size_t i = 0; i < count; ++i)
    require(target_of.data()[i] >= 0 && target_of.data()[i] < static_cast<std::int64_t>(targets.shape(0)),
            "no such target");
  const IkStorage storage(c, lower.data(), upper.data());
  const IkKernel kernel = kernel_named(name);
  std::vector<double> q(count * nq);
  std::vector<std::uint8_t> converged(count);
  std::vector<std::int64_t> iterations(count);
  const IkTask task{storage.view(), wanted, static_cast<std::int64_t>(count), enough, max_iterations,
                    seeds.data(), targets.data(), target_of.data(), q.data(), converged.data(),
                    iterations.data()};
  std::int64_t tried = 0;
  {
    nb::gil_scoped_release released;
    const auto size = static_cast<std::size_t>(ik_scratch_doubles(task.model, kernel.width));
    auto* scratch = static_cast<double*>(::operator new[](size * sizeof(double), std::align_val_t{64}));
    tried = kernel.solve(task, scratch);
    ::operator delete[](scratch, std::align_val_t{64});
  }
  q.resize(tried * nq);
  converged.resize(tried);
  iterations.resize(tried);
  return nb::make_tuple(array_of(converged, tried), array_of(q, tried, nq), array_of(iterations, tried));
}

}  // namespace

void bind_ik(nb::module_& m) {
  nb::class_<IkTolerance>(m, "IkTolerance", "How far a pose may be missed.")
      .def("__init__", [](IkTolerance* self, const Doubles& box, Freedom freedom, int axis, double bound) {
        new (self) IkTolerance(tolerance(box, freedom, axis, bound));
      }, nb::arg("box"), nb::arg("freedom"), nb::arg("axis"), nb::arg("bound"));
  nb::class_<Chain>(m, "Chain", "How a frame depends on a group's q.")
      .def("__init__", [](Chain* self, std::shared_ptr<Scene> scene, const Integers& positions,
                          const Integers& velocities, const Doubles& state, int link, const Doubles& X_LT) {
        new (self) Chain(chain(*scene, positions, velocities, state, link, X_LT));
      }, nb::arg("scene"), nb::arg("positions"), nb::arg("velocities"), nb::arg("state"), nb::arg("link"),
         nb::arg("X_LT"))
      .def("poses", &poses, nb::arg("qs"))
      .def("jacobians", &jacobians, nb::arg("qs"))
      .def("solve", &solve, nb::arg("seeds"), nb::arg("target_of"), nb::arg("targets"), nb::arg("lower"),
           nb::arg("upper"), nb::arg("tolerance"), nb::arg("enough"),
           nb::arg("max_iterations"), nb::arg("kernel") = "");
}

}  // namespace wayproof
