// Scene and Group, from arrays.
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "checker/near_pairs.hpp"
#include "model/scene.hpp"

namespace wayproof {
namespace {

void require_mutable(const Scene& scene) {
  require(!scene.is_immutable, "the scene is in use by a Checker, Prover or DistanceQuery: nothing is added to it");
}

int coordinates(int count, const char* name) {
  if (count < 0 || count > max_coordinates)
    refuse(std::string(name) + " is " + std::to_string(count) + ", not from 0 to " + std::to_string(max_coordinates));
  return count;
}

std::vector<Sphere> spheres(const Doubles& array, const char* name) {
  const Table rows = table(array, 4, name);
  finite(rows.all(), name);
  std::vector<Sphere> found;
  for (std::size_t i = 0; i < rows.rows; ++i) {
    const double* x = rows.row(i);
    if (x[3] < 0) refuse(std::string(name) + " has a negative radius in row " + std::to_string(i));
    found.push_back({{x[0], x[1], x[2]}, x[3]});
  }
  return found;
}

// First index of a joint's coordinates, of which the scene has `total`.
int first_of(std::int64_t first, int count, int total, const char* name) {
  const int last = total - std::max(count, 1);
  return count == 0 && total == 0 ? 0 : index(first, static_cast<std::size_t>(std::max(last + 1, 0)), name);
}

void add_link(Scene& scene, std::int64_t parent, const Doubles& X_PF, JointKind kind, const Doubles& axis,
              std::int64_t position, std::int64_t velocity) {
  require_mutable(scene);
  Tree& tree = scene.tree;
  tree.links.push_back({link_or_world(parent, scene, "parent"), transform(X_PF, "X_PF"), kind, vec(axis, "axis"),
                        first_of(position, num_positions(kind), tree.num_positions, "position"),
                        first_of(velocity, num_velocities(kind), tree.num_velocities, "velocity")});
}

void add_follower(Scene& scene, std::int64_t follower, std::int64_t leader, std::int64_t follower_velocity,
                  std::int64_t leader_velocity, double multiplier, double offset) {
  require_mutable(scene);
  const auto nq = static_cast<std::size_t>(scene.tree.num_positions);
  const auto nv = static_cast<std::size_t>(scene.tree.num_velocities);
  scene.tree.followers.push_back({index(follower, nq, "follower"), index(leader, nq, "leader"),
                                  finite(multiplier, "multiplier"), finite(offset, "offset"),
                                  index(follower_velocity, nv, "follower_velocity"),
                                  index(leader_velocity, nv, "leader_velocity")});
}

// Sizes that a kind uses are not negative, and those of an ellipsoid, by which it is stretched, are positive.
Vec3 size_of(ShapeKind kind, const Doubles& array) {
  const Vec3 size = vec(array, "size");
  const double least = std::min({size.x, size.y, size.z});
  require(kind == ShapeKind::ellipsoid ? least > 0 : least >= 0,
          "size has a number that is too small: no length is negative, and no semi-axis of an ellipsoid zero");
  return size;
}

Shape shape(ShapeKind kind, const Doubles& size, const Doubles& vertices, const Doubles& planes) {
  const Table points = table(vertices, 3, "vertices"), faces = table(planes, 4, "planes");
  finite(points.all(), "vertices"), finite(faces.all(), "planes");
  if (kind == ShapeKind::hull && (points.rows < 3 || faces.rows < 2))
    refuse("a hull has three vertices and two planes or more, not " + std::to_string(points.rows) + " and " +
           std::to_string(faces.rows));
  std::vector<Vec3> corners;
  for (std::size_t i = 0; i < points.rows; ++i) {
    const double* x = points.row(i);
    corners.push_back({x[0], x[1], x[2]});
  }
  std::vector<std::array<double, 4>> halves;
  for (std::size_t i = 0; i < faces.rows; ++i) {
    const double* p = faces.row(i);
    halves.push_back({p[0], p[1], p[2], p[3]});
  }
  return Shape(kind, size_of(kind, size), corners, std::move(halves));
}

Sphere bound_of(const Doubles& array) {
  const auto x = finite(row(array, 4, "bound"), "bound");
  require(x[3] >= 0, "bound has a negative radius");
  return {{x[0], x[1], x[2]}, x[3]};
}

void add_geometry(Scene& scene, std::int64_t link, const Doubles& X_LG, ShapeKind kind, const Doubles& size,
                  const Doubles& vertices, const Doubles& planes, const Doubles& outer, const Doubles& inner,
                  const Doubles& bound) {
  require_mutable(scene);
  Geometry made{link_or_world(link, scene, "link"),
                transform(X_LG, "X_LG"),
                shape(kind, size, vertices, planes),
                spheres(outer, "outer"),
                spheres(inner, "inner"),
                bound_of(bound)};
  // What moves is in collision where one of its outer spheres is: without any it would be free everywhere.
  require(made.link < 0 || kind == ShapeKind::half_space || !made.outer.empty(),
          "outer has no rows: a geometry on a link is covered by spheres");
  scene.geometries.push_back(std::move(made));
}

void add_pair(Scene& scene, std::int64_t a, std::int64_t b) {
  require_mutable(scene);
  const std::size_t count = scene.geometries.size();
  scene.pairs.push_back({index(a, count, "a"), index(b, count, "b")});
}

// The same for many pairs, as rows a, b, one after the other.
void add_pairs(Scene& scene, const Integers& rows) {
  require_mutable(scene);
  const auto ends = indices(row(rows, "rows"), scene.geometries.size(), "rows");
  if (ends.size() % 2 != 0) refuse("rows has " + std::to_string(ends.size()) + " numbers, not two for each pair");
  scene.pairs.reserve(scene.pairs.size() + ends.size() / 2);
  for (std::size_t i = 0; i < ends.size(); i += 2) scene.pairs.push_back({ends[i], ends[i + 1]});
}

// A copy in which some geometries are elsewhere on their links.
std::shared_ptr<Scene> with_poses(const Scene& scene, const Integers& geometries, const Doubles& X_LG) {
  const auto which = indices(row(geometries, "geometries"), scene.geometries.size(), "geometries");
  const Table poses = table(X_LG, which.size(), 12, "X_LG");
  finite(poses.all(), "X_LG");
  auto moved = std::make_shared<Scene>(scene);
  moved->is_immutable = false;
  for (std::size_t i = 0; i < which.size(); ++i)
    moved->geometries[static_cast<std::size_t>(which[i])].X_LG = transform({poses.row(i), 12});
  return moved;
}

bool is_any_near(const Scene& scene, const Doubles& full, double reach) {
  const auto numbers = finite(row(full, static_cast<std::size_t>(scene.tree.num_positions), "full"), "full");
  finite(reach, "reach");
  nb::gil_scoped_release released;
  return has_near_pair(scene, numbers, reach);
}

auto are_near(const Scene& scene, const Doubles& full, std::int64_t first, double reach) {
  const auto numbers = finite(row(full, static_cast<std::size_t>(scene.tree.num_positions), "full"), "full");
  const int from = index(first, scene.geometries.size() + 1, "first");
  finite(reach, "reach");
  std::vector<std::int64_t> found;
  {
    nb::gil_scoped_release released;
    found = near_geometries(scene, numbers, from, reach);
  }
  return array_of(found, found.size());
}

}  // namespace

void bind_scene(nb::module_& m) {
  nb::class_<Scene>(m, "Scene", "What a loaded world is to the kernel.")
      .def(
          "__init__",
          [](Scene* self, int num_positions, int num_velocities) {
            coordinates(num_positions, "num_positions"), coordinates(num_velocities, "num_velocities");
            new (self) Scene();
            self->tree.num_positions = num_positions;
            self->tree.num_velocities = num_velocities;
          },
          nb::arg("num_positions"), nb::arg("num_velocities"))
      .def("add_link", &add_link, nb::arg("parent"), nb::arg("X_PF"), nb::arg("kind").noconvert(), nb::arg("axis"),
           nb::arg("position"), nb::arg("velocity"))
      .def("add_follower", &add_follower, nb::arg("follower"), nb::arg("leader"), nb::arg("follower_velocity"),
           nb::arg("leader_velocity"), nb::arg("multiplier"), nb::arg("offset"))
      .def("add_geometry", &add_geometry, nb::arg("link"), nb::arg("X_LG"), nb::arg("kind").noconvert(),
           nb::arg("size"), nb::arg("vertices"), nb::arg("planes"), nb::arg("outer"), nb::arg("inner"),
           nb::arg("bound"))
      .def("add_pair", &add_pair, nb::arg("a"), nb::arg("b"))
      .def("add_pairs", &add_pairs, nb::arg("rows"))
      .def("with_poses", &with_poses, nb::arg("geometries"), nb::arg("X_LG"))
      .def("has_near_pair", &is_any_near, nb::arg("full"), nb::arg("reach"))
      .def("near_geometries", &are_near, nb::arg("full"), nb::arg("first"), nb::arg("reach"));
}

}  // namespace wayproof
