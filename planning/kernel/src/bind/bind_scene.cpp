// Scene and Group, from arrays.
#include <nanobind/stl/shared_ptr.h>

#include <memory>

#include "bind/bind.hpp"
#include "model/scene.hpp"

namespace wayproof {
namespace {

std::vector<Sphere> spheres(const Doubles& rows) {
  require(rows.ndim() == 2 && rows.shape(1) == 4, "spheres have four columns");
  std::vector<Sphere> found;
  for (std::size_t i = 0; i < rows.shape(0); ++i)
    found.push_back({vec(rows.data() + 4 * i), rows.data()[4 * i + 3]});
  return found;
}

void add_link(Scene& scene, int parent, const Doubles& X_PF, JointKind kind, const Doubles& axis, int position, int velocity) {
  require(parent < static_cast<int>(scene.tree.links.size()), "a link comes after its parent");
  require(X_PF.size() == 12 && axis.size() == 3, "X_PF has 12 numbers, an axis 3");
  scene.tree.links.push_back({parent, transform(X_PF.data()), kind, vec(axis.data()), position, velocity});
}

void add_follower(Scene& scene, std::array<int, 4> where, double multiplier, double offset) {
  for (int i = 0; i < 2; ++i) require(where[i] >= 0 && where[i] < scene.tree.num_positions, "no such position");
  scene.tree.followers.push_back({where[0], where[1], multiplier, offset, where[2], where[3]});
}

void add_geometry(Scene& scene, int link, const Doubles& X_LG, ShapeKind kind, const Doubles& size, const Doubles& vertices,
                  const Doubles& planes, const Doubles& outer, const Doubles& inner, const Doubles& bound) {
  require(link < static_cast<int>(scene.tree.links.size()), "no such link");
  require(X_LG.size() == 12 && size.size() == 3 && bound.size() == 4, "X_LG has 12 numbers, a size 3, a bound 4");
  std::vector<Vec3> points;
  for (std::size_t i = 0; i + 2 < vertices.size(); i += 3) points.push_back(vec(vertices.data() + i));
  require(kind != ShapeKind::hull || points.size() >= 4, "a hull has four vertices or more");
  std::vector<std::array<double, 4>> faces;
  for (std::size_t i = 0; i + 3 < planes.size(); i += 4) {
    const double* p = planes.data() + i;
    faces.push_back({p[0], p[1], p[2], p[3]});
  }
  scene.geometries.push_back({link, transform(X_LG.data()),
                              Shape(kind, vec(size.data()), points, std::move(faces)),
                              spheres(outer), spheres(inner), {vec(bound.data()), bound.data()[3]}});
}

void add_pair(Scene& scene, int a, int b) {
  const int count = static_cast<int>(scene.geometries.size());
  require(a >= 0 && b >= 0 && a < count && b < count, "no such geometry");
  scene.pairs.push_back({a, b});
}

// The same for many pairs, as rows a, b, one after the other.
void add_pairs(Scene& scene, const Integers& rows) {
  require(rows.size() % 2 == 0, "a pair has two geometries");
  scene.pairs.reserve(scene.pairs.size() + rows.size() / 2);
  for (std::size_t i = 0; i < rows.size(); i += 2)
    add_pair(scene, static_cast<int>(rows.data()[i]), static_cast<int>(rows.data()[i + 1]));
}

// A copy in which some geometries are elsewhere on their links.
std::shared_ptr<Scene> with_poses(const Scene& scene, const Integers& geometries, const Doubles& X_LG) {
  require_shape(X_LG, geometries.size(), 12, "X_LG");
  auto moved = std::make_shared<Scene>(scene);
  for (std::size_t i = 0; i < geometries.size(); ++i) {
    const std::int64_t geometry = geometries.data()[i];
    require(geometry >= 0 && geometry < static_cast<std::int64_t>(scene.geometries.size()), "no such geometry");
    moved->geometries[geometry].X_LG = transform(X_LG.data() + 12 * i);
  }
  return moved;
}

}  // namespace

void bind_scene(nb::module_& m) {
  nb::class_<Scene>(m, "Scene", "What a loaded world is to the kernel.")
      .def("__init__", [](Scene* self, int num_positions, int num_velocities) {
        new (self) Scene();
        self->tree.num_positions = num_positions;
        self->tree.num_velocities = num_velocities;
      }, nb::arg("num_positions"), nb::arg("num_velocities"))
      .def("add_link", &add_link, nb::arg("parent"), nb::arg("X_PF"), nb::arg("kind"), nb::arg("axis"),
           nb::arg("position"), nb::arg("velocity"))
      .def("add_follower", [](Scene& s, int a, int b, int va, int vb, double k, double c) { add_follower(s, {a, b, va, vb}, k, c); },
           nb::arg("follower"), nb::arg("leader"), nb::arg("follower_velocity"), nb::arg("leader_velocity"),
           nb::arg("multiplier"), nb::arg("offset"))
      .def("add_geometry", &add_geometry, nb::arg("link"), nb::arg("X_LG"), nb::arg("kind"), nb::arg("size"),
           nb::arg("vertices"), nb::arg("planes"), nb::arg("outer"), nb::arg("inner"), nb::arg("bound"))
      .def("add_pair", &add_pair, nb::arg("a"), nb::arg("b"))
      .def("add_pairs", &add_pairs, nb::arg("rows"))
      .def("with_poses", &with_poses, nb::arg("geometries"), nb::arg("X_LG"));
}

}  // namespace wayproof
