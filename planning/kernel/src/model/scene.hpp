// Scene: a loaded world in the kernel; immutable once it is in use.
#pragma once

#include <vector>

#include "model/shape.hpp"
#include "model/tree.hpp"

namespace wayproof {

struct Sphere {
  Vec3 center;
  double radius = 0;
};

// Collision geometry G on a link; -1 is the world.
struct Geometry {
  int link = -1;
  Transform X_LG;
  Shape shape;
  std::vector<Sphere> outer, inner;  // in G; none for half spaces
  Sphere bound;                      // in G
};

// Two geometries that may collide.
struct Pair {
  int a = 0, b = 0;
};

struct Scene {
  Tree tree;
  std::vector<Geometry> geometries;
  std::vector<Pair> pairs;
  bool is_immutable = false;  // in use by objects that have sized their tables by it

  // Whether a group moves a geometry.
  bool is_moved(const Group& group, int geometry) const {
    const int link = geometries[geometry].link;
    return link >= 0 && group.moves[link];
  }

  // Whether a group moves a half space of a pair.
  bool moves_half_space(const Group& group, Pair pair) const {
    const auto moves = [&](int g) { return geometries[g].shape.kind == ShapeKind::half_space && is_moved(group, g); };
    return moves(pair.a) || moves(pair.b);
  }

  Transform pose(int geometry, const Transform* X_WL) const {
    const Geometry& g = geometries[geometry];
    return g.link < 0 ? g.X_LG : X_WL[g.link] * g.X_LG;
  }
};

}  // namespace wayproof
