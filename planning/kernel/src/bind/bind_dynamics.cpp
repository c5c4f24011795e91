// InverseDynamics on numpy arrays and without the interpreter's lock.
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "model/dynamics.hpp"

namespace wayproof {
namespace {

// Mass, centre of mass (3) and rotational inertia about it (9, row-major).
constexpr std::size_t inertia_size = 13;

void make(InverseDynamics* self, const std::shared_ptr<Scene>& scene, const Integers& positions,
          const Integers& velocities, const Doubles& state, const Doubles& inertias, const Doubles& rotors,
          const Doubles& gravity) {
  const Tree& tree = scene->tree;
  const Table rows = table(inertias, tree.links.size(), inertia_size, "inertias");
  finite(rows.all(), "inertias");
  std::vector<Inertia> of_links;
  for (std::size_t i = 0; i < rows.rows; ++i) {
    const double* x = rows.row(i);
    if (x[0] < 0) refuse("inertias have a negative mass in row " + std::to_string(i));
    Inertia inertia{x[0], {x[1], x[2], x[3]}, {}};
    for (int k = 0; k < 9; ++k) inertia.about_center.m[k] = x[4 + k];
    of_links.push_back(inertia);
  }
  const auto reflected = finite(row(rotors, static_cast<std::size_t>(tree.num_velocities), "rotors"), "rotors");
  new (self) InverseDynamics(tree, group(*scene, positions, velocities, state), std::move(of_links),
                             {reflected.begin(), reflected.end()}, vec(gravity, "gravity"));
}

auto efforts(const InverseDynamics& dynamics, const Doubles& q, const Doubles& v, const Doubles& vdot) {
  const std::size_t nv = dynamics.num_velocities();
  const Table positions = table(q, dynamics.num_positions(), "q");
  const Table rates = table(v, positions.rows, nv, "v"), changes = table(vdot, positions.rows, nv, "vdot");
  finite(positions.all(), "q"), finite(rates.all(), "v"), finite(changes.all(), "vdot");
  std::vector<double> found(positions.rows * nv);
  {
    nb::gil_scoped_release released;
    InverseDynamics::Work work = dynamics.work();
    for (std::size_t i = 0; i < positions.rows; ++i)
      dynamics.efforts(positions.row(i), rates.row(i), changes.row(i), &found[i * nv], work);
  }
  return array_of(found, positions.rows, nv);
}

auto derivatives(const InverseDynamics& dynamics, const Doubles& q, const Doubles& v, const Doubles& vdot) {
  const std::size_t nv = dynamics.num_velocities();
  if (dynamics.num_positions() != nv) refuse("a joint floats: efforts have no derivatives by its coordinates");
  const Table positions = table(q, nv, "q");
  const std::size_t count = positions.rows;
  const Table rates = table(v, count, nv, "v"), changes = table(vdot, count, nv, "vdot");
  finite(positions.all(), "q"), finite(rates.all(), "v"), finite(changes.all(), "vdot");
  std::vector<double> found(3 * count * nv * nv), one(3 * nv * nv);
  {
    nb::gil_scoped_release released;
    InverseDynamics::Work work = dynamics.work();
    for (std::size_t i = 0; i < count; ++i) {
      dynamics.derivatives(positions.row(i), rates.row(i), changes.row(i), one.data(), work);
      for (std::size_t part = 0; part < 3; ++part)
        std::copy_n(&one[part * nv * nv], nv * nv, &found[(part * count + i) * nv * nv]);
    }
  }
  return array_of(found, 3, count, nv, nv);
}

}  // namespace

void bind_dynamics(nb::module_& m) {
  nb::class_<InverseDynamics>(m, "InverseDynamics", "Joint torques and forces of a group's motion.")
      .def("__init__", &make, nb::arg("scene"), nb::arg("positions"), nb::arg("velocities"), nb::arg("state"),
           nb::arg("inertias"), nb::arg("rotors"), nb::arg("gravity"))
      .def("efforts", &efforts, nb::arg("q"), nb::arg("v"), nb::arg("vdot"),
           "The group's efforts at each row of q, v and vdot.")
      .def("derivatives", &derivatives, nb::arg("q"), nb::arg("v"), nb::arg("vdot"),
           "Their derivatives by q, v and vdot.");
}

}  // namespace wayproof
