// Shape: a convex body as the sum of a polytope, an ellipsoid (maybe flat) and a ball.
//
// Its support function is h(n) = max_i n . v_i + |D n| + r |n|: a box is eight vertices, a cylinder
// two and a flat disk, a capsule two and a ball. The core is the shape without its ball.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "math/vec.hpp"
#include "model/kinds.hpp"
#include "model/support_table.hpp"

namespace wayproof {

struct Shape {
  ShapeKind kind = ShapeKind::sphere;
  Vec3 size;  // as in planning/kernel/shape.py
  // The polytope's vertices in G, padded to a multiple of 8; those of many vertices have a table instead, which copies
  // of the shape share.
  std::vector<double> vx, vy, vz;
  std::shared_ptr<const SupportTable> table;
  Vec3 axes;  // the ellipsoid's semi-axes in G
  double ball = 0;
  std::vector<std::array<double, 4>> planes;  // of hulls: n . x <= d
  Vec3 center;                                // of a bounding sphere, in G
  double radius = 0;                          // of that sphere

  Shape(ShapeKind kind, Vec3 size, const std::vector<Vec3>& vertices, std::vector<std::array<double, 4>> planes);

  // Radius of a sphere around the core: rotating a ball moves no point of it, so neither does a ball about a core.
  double core_radius() const { return radius - ball; }
  // The point of the core that lies farthest along n, in G.
  Vec3 core_support(Vec3 n) const;

 private:
  bool has_few_corners_ = false;  // one or two, on the z axis
};

}  // namespace wayproof
