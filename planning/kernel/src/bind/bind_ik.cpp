// Kinematics of a frame that a group moves, on numpy arrays and without the interpreter's lock.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <memory>
#include <utility>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "ik/distinct.hpp"
#include "ik/ik_model.hpp"
#include "math/aligned.hpp"
#include "model/kinematics.hpp"
#include "model/scene.hpp"

namespace wayproof {
namespace {

std::size_t positions_of(const Chain& c) { return static_cast<std::size_t>(c.num_positions); }
std::size_t velocities_of(const Chain& c) { return static_cast<std::size_t>(c.num_velocities); }

void make(Chain* self, const std::shared_ptr<Scene>& scene, const Integers& positions, const Integers& velocities,
          const Doubles& state, std::int64_t link, const Doubles& X_LT) {
  const Group moving = group(*scene, positions, velocities, state);
  new (self) Chain(scene->tree, moving, link_or_world(link, *scene, "link"), transform(X_LT, "X_LT"));
}

auto poses(const Chain& c, const Doubles& qs) {
  const Table rows = table(qs, positions_of(c), "qs");
  std::vector<double> found(12 * rows.rows);
  {
    nb::gil_scoped_release released;
    for (std::size_t i = 0; i < rows.rows; ++i) {
      const Transform X = c.pose({rows.row(i), rows.columns});
      for (int k = 0; k < 9; ++k) found[12 * i + k] = X.R.m[k];
      for (int k = 0; k < 3; ++k) found[12 * i + 9 + k] = X.p[k];
    }
  }
  return array_of(found, rows.rows, 12);
}

auto jacobians(const Chain& c, const Doubles& qs) {
  const Table rows = table(qs, positions_of(c), "qs");
  const std::size_t size = 6 * velocities_of(c);
  std::vector<double> found(size * rows.rows);
  {
    nb::gil_scoped_release released;
    for (std::size_t i = 0; i < rows.rows; ++i)
      c.jacobian({rows.row(i), rows.columns}, {found.data() + size * i, size});
  }
  return array_of(found, rows.rows, 6, velocities_of(c));
}

auto velocities(const Chain& c, const Doubles& qs, const Doubles& vs) {
  const Table rows = table(qs, positions_of(c), "qs");
  const Table rates = table(vs, rows.rows, velocities_of(c), "vs");
  std::vector<double> found;
  found.reserve(3 * rows.rows);
  {
    nb::gil_scoped_release released;
    for (std::size_t i = 0; i < rows.rows; ++i) {
      const Vec3 velocity = c.velocity({rows.row(i), rows.columns}, {rates.row(i), rates.columns});
      found.insert(found.end(), {velocity.x, velocity.y, velocity.z});
    }
  }
  return array_of(found, rows.rows, 3);
}

auto velocity_gradients(const Chain& c, const Doubles& qs, const Doubles& vs) {
  const Table rows = table(qs, positions_of(c), "qs");
  const Table rates = table(vs, rows.rows, velocities_of(c), "vs");
  require(c.quaternions.empty(), "a joint floats: velocities have no gradient by its coordinates");
  const std::size_t size = 3 * velocities_of(c);
  std::vector<double> found(size * rows.rows);
  {
    nb::gil_scoped_release released;
    for (std::size_t i = 0; i < rows.rows; ++i)
      c.velocity_gradient({rows.row(i), rows.columns}, {rates.row(i), rates.columns}, {found.data() + size * i, size});
  }
  return array_of(found, rows.rows, 3, velocities_of(c));
}

IkTolerance tolerance(const Doubles& box, Freedom freedom, std::int64_t axis, double bound) {
  const Vec3 widths = vec(box, "box");
  return {{widths.x, widths.y, widths.z}, freedom, index(axis, 3, "axis"), finite(bound, "bound")};
}

auto solve(const Chain& c, const Doubles& seeds, const Integers& target_of, const Doubles& targets,
           const Doubles& lower, const Doubles& upper, const IkTolerance& wanted, std::int64_t enough,
           int max_iterations, const std::string& name) {
  const Table begins = table(seeds, positions_of(c), "seeds"), goals = table(targets, 12, "targets");
  const std::size_t count = begins.rows, nq = begins.columns;
  require(count > 0, "seeds has no rows: there is nothing to solve from");
  const auto low = ordered(row(lower, nq, "lower"), "lower"), high = ordered(row(upper, nq, "upper"), "upper");
  const auto which = row(target_of, "target_of");
  if (which.size() != count)
    refuse("target_of has " + std::to_string(which.size()) + " numbers, not " + std::to_string(count) +
           ": one for each seed");
  indices(which, goals.rows, "target_of");
  const IkStorage storage(c, low, high);
  const IkKernel kernel = kernel_named(name, &ik_kernels);
  std::vector<double> q(count * nq);
  std::vector<std::uint8_t> converged(count);
  std::vector<std::int64_t> iterations(count);
  const IkTask task{storage.view(),   wanted,           static_cast<std::int64_t>(count),
                    enough,           max_iterations,   begins.data,
                    goals.data,       which.data(),     q.data(),
                    converged.data(), iterations.data()};
  std::int64_t tried = 0;
  {
    nb::gil_scoped_release released;
    Aligned<double> scratch(static_cast<std::size_t>(ik_scratch_doubles(task.model, kernel.width)));
    tried = kernel.solve(task, scratch.data());
  }
  const auto prefix = static_cast<std::size_t>(tried);
  q.resize(prefix * nq);
  converged.resize(prefix);
  iterations.resize(prefix);
  return nb::make_tuple(array_of(converged, prefix), array_of(q, prefix, nq), array_of(iterations, prefix));
}

auto distinct(const Doubles& rows, const Integers& targets,
              const nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>& is_periodic,
              double tolerance) {
  const std::size_t nq = is_periodic.shape(0);
  require(nq > 0, "is_periodic is empty");
  const Table configurations = table(rows, nq, "rows");
  const auto which = row(targets, "targets");
  require(which.size() == configurations.rows, "targets does not have a number for each row");
  const std::vector<bool> periodic(is_periodic.data(), is_periodic.data() + nq);
  const auto first =
      first_of_clusters(finite(configurations.all(), "rows"), which, periodic, positive(tolerance, "tolerance"));
  return array_of(first, first.size());
}

}  // namespace

void bind_ik(nb::module_& m) {
  nb::class_<IkTolerance>(m, "IkTolerance", "How far a pose may be missed.")
      .def(
          "__init__",
          [](IkTolerance* self, const Doubles& box, Freedom freedom, std::int64_t axis, double bound) {
            new (self) IkTolerance(tolerance(box, freedom, axis, bound));
          },
          nb::arg("box"), nb::arg("freedom").noconvert(), nb::arg("axis"), nb::arg("bound"));
  nb::class_<Chain>(m, "Chain", "How a frame depends on a group's q.")
      .def("__init__", &make, nb::arg("scene"), nb::arg("positions"), nb::arg("velocities"), nb::arg("state"),
           nb::arg("link"), nb::arg("X_LT"))
      .def("poses", &poses, nb::arg("qs"))
      .def("jacobians", &jacobians, nb::arg("qs"))
      .def("velocities", &velocities, nb::arg("qs"), nb::arg("vs"))
      .def("velocity_gradients", &velocity_gradients, nb::arg("qs"), nb::arg("vs"))
      .def("solve", &solve, nb::arg("seeds"), nb::arg("target_of"), nb::arg("targets"), nb::arg("lower"),
           nb::arg("upper"), nb::arg("tolerance"), nb::arg("enough"), nb::arg("max_iterations"),
           nb::arg("kernel") = "");
  m.def("first_of_clusters", &distinct, nb::arg("rows"), nb::arg("targets"), nb::arg("is_periodic"),
        nb::arg("tolerance"));
}

}  // namespace wayproof
