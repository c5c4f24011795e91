// TorqueSeries on numpy arrays and without the interpreter's lock.
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <vector>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "model/kinds.hpp"
#include "series/torque_series.hpp"

namespace wayproof {
namespace {

// Index of the coordinate in q and in v, and the displacement's scale and offset.
using Coordinate = std::tuple<std::int64_t, std::int64_t, double, double>;
// Damping, and the rotor's reflected inertia.
using Drive = std::tuple<double, double>;
// Mass, centre of mass (3), principal second moments about it (3), and their directions as columns (9, row-major).
constexpr std::size_t mass_size = 16;

// Work space is counted in int.
constexpr std::int64_t most_coordinates = 10'000, most_terms = 1000;

int count_of(std::int64_t count, const char* name) {
  if (count < 1 || count > most_coordinates)
    refuse(std::string(name) + " is " + std::to_string(count) + ", not from 1 to " + std::to_string(most_coordinates));
  return static_cast<int>(count);
}

void make(TorqueSeries* self, std::int64_t num_positions, std::int64_t num_velocities, const Doubles& gravity) {
  new (self) TorqueSeries(count_of(num_positions, "num_positions"), count_of(num_velocities, "num_velocities"),
                          vec(gravity, "gravity"));
}

void write(const Vec3& from, double* to) { to[0] = from.x, to[1] = from.y, to[2] = from.z; }

void add_link(TorqueSeries& self, std::int64_t parent, const Doubles& X_PF, JointKind kind, const Doubles& axis,
              const Coordinate& coordinate, const Drive& drive, const Doubles& mass) {
  const auto& [position, velocity, scale, offset] = coordinate;
  if (parent != -1) index(parent, static_cast<std::size_t>(self.num_links()), "parent");
  require(kind == JointKind::revolute || kind == JointKind::prismatic, "kind is neither REVOLUTE nor PRISMATIC");
  MovingLink link{};
  link.parent = static_cast<int>(parent), link.turns = kind == JointKind::revolute;
  link.position = index(position, static_cast<std::size_t>(self.num_positions()), "position");
  link.velocity = index(velocity, static_cast<std::size_t>(self.num_velocities()), "velocity");
  const Transform pose = transform(X_PF, "X_PF");
  std::copy_n(pose.R.m.data(), 9, link.R_PF), write(pose.p, link.p_PF), write(vec(axis, "axis"), link.axis);
  link.scale = finite(scale, "scale"), link.offset = finite(offset, "offset");
  link.damping = finite(std::get<0>(drive), "damping"),
  link.rotor_inertia = finite(std::get<1>(drive), "rotor_inertia");
  require(link.damping >= 0 && link.rotor_inertia >= 0, "damping and rotor_inertia are not 0 or more");
  const auto numbers = finite(row(mass, mass_size, "mass"), "mass");
  require(numbers[0] >= 0, "mass is negative");
  link.mass = numbers[0];
  std::copy_n(&numbers[1], 3, link.center), std::copy_n(&numbers[4], 3, link.moments);
  std::copy_n(&numbers[7], 9, link.principal);
  self.add_link(link);
}

// A motion [pieces][terms][nv], and instants or segments of it.
struct Motion {
  std::size_t terms = 0;
  std::vector<SeriesSegment> segments;
};

Motion motion_of(const TorqueSeries& self, const Doubles& bases, const Doubles& coefficients, const Integers& pieces,
                 const Doubles& middles, const Doubles* halves) {
  const std::size_t nv = static_cast<std::size_t>(self.num_velocities());
  const Table starts = table(bases, static_cast<std::size_t>(self.num_positions()), "bases");
  if (coefficients.ndim() != 3 || coefficients.shape(0) != starts.rows || coefficients.shape(1) < 1 ||
      coefficients.shape(1) > most_terms || coefficients.shape(2) != nv)
    refuse("coefficients do not have the shape (pieces, 1 to 1000, velocities)");
  Motion motion{coefficients.shape(1), {}};
  finite(starts.all(), "bases"), finite({coefficients.data(), coefficients.size()}, "coefficients");
  const auto owners = indices(row(pieces, "pieces"), starts.rows, "pieces");
  const auto at = finite(row(middles, owners.size(), "middles"), "middles");
  const auto half = halves ? finite(row(*halves, owners.size(), "halves"), "halves") : std::span<const double>{};
  for (std::size_t i = 0; i < owners.size(); ++i) {
    require(!halves || half[i] >= 0, "halves has a negative width");
    const auto piece = static_cast<std::size_t>(owners[i]);
    const double* of_piece = coefficients.data() + piece * motion.terms * nv;
    motion.segments.push_back({starts.row(piece), of_piece, at[i], halves ? half[i] : 0});
  }
  return motion;
}

auto polynomials(const TorqueSeries& self, const Doubles& bases, const Doubles& coefficients, const Integers& pieces,
                 const Doubles& middles, const Doubles& halves, int order, const std::string& name) {
  const Motion motion = motion_of(self, bases, coefficients, pieces, middles, &halves);
  if (order < 0 || order > 2) refuse("order is " + std::to_string(order) + ", not 0, 1 or 2");
  const SeriesKernel kernel = kernel_named(name, &series_kernels);
  const std::size_t nv = static_cast<std::size_t>(self.num_velocities()), count = motion.segments.size();
  std::vector<double> taylor(count * torque_terms * nv), errors(count * nv);
  {
    nb::gil_scoped_release released;
    self.of(motion.segments, static_cast<int>(motion.terms), order, kernel, taylor.data(), errors.data());
  }
  return nb::make_tuple(array_of(taylor, count, torque_terms, nv), array_of(errors, count, nv));
}

auto points(const TorqueSeries& self, const Doubles& bases, const Doubles& coefficients, const Integers& pieces,
            const Doubles& middles, const Doubles& point, const std::string& name) {
  const Motion motion = motion_of(self, bases, coefficients, pieces, middles, nullptr);
  const Vec3 fixed = vec(point, "point");
  const SeriesKernel kernel = kernel_named(name, &series_kernels);
  std::vector<double> found(motion.segments.size() * point_terms * 3);
  {
    nb::gil_scoped_release released;
    self.points(motion.segments, static_cast<int>(motion.terms), fixed, kernel, found.data());
  }
  return array_of(found, motion.segments.size(), point_terms, 3);
}

}  // namespace

void bind_torques(nb::module_& m) {
  nb::class_<TorqueSeries>(m, "TorqueSeries", "Joint torques along segments of a motion, as polynomials with errors.")
      .def("__init__", &make, nb::arg("num_positions"), nb::arg("num_velocities"), nb::arg("gravity"))
      .def("add_link", &add_link, nb::arg("parent"), nb::arg("X_PF"), nb::arg("kind").noconvert(), nb::arg("axis"),
           nb::arg("coordinate"), nb::arg("drive"), nb::arg("mass"))
      .def("polynomials", &polynomials, nb::arg("bases"), nb::arg("coefficients"), nb::arg("pieces"),
           nb::arg("middles"), nb::arg("halves"), nb::arg("order"), nb::arg("kernel") = "",
           "Torque coefficients about the middles of segments, and bounds on their errors.")
      .def("points", &points, nb::arg("bases"), nb::arg("coefficients"), nb::arg("pieces"), nb::arg("middles"),
           nb::arg("point"), nb::arg("kernel") = "",
           "Position, velocity and acceleration of a point fixed in the last link, at instants of pieces.");
}

}  // namespace wayproof
