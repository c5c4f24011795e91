#include "checker/batch_model.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "checker/checker.hpp"

namespace wayproof {
namespace {

// The unit roundoff of single precision, and the largest loss of one link's arithmetic in units of it: about ten
// operations on each rotation matrix and its sines, and as many on the position.
constexpr double unit = 6e-8;
constexpr double losses_per_link = 32;
constexpr double endless = 1e15;
// Largest number of checked faces of a hull; the others are left out, which only enlarges it.
constexpr std::size_t max_planes = 32;
// Fewer bound nothing: flat hulls have the two sides of their plane.
constexpr std::size_t min_planes = 4;

void write(const Transform& x, float* R, float* p) {
  for (int i = 0; i < 9; ++i) R[i] = static_cast<float>(x.R.m[i]);
  for (int i = 0; i < 3; ++i) p[i] = static_cast<float>(x.p[i]);
}

// Enlarges the sphere by rounding errors if `grow`, else shrinks it.
BatchSphere batch_sphere(const Transform& x, const Sphere& s, bool grow) {
  const Vec3 c = x * s.center;
  const double rounding = unit * (norm(c) + s.radius) * 4;
  return {static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z),
          static_cast<float>(std::max(0.0, grow ? s.radius + rounding : s.radius - rounding))};
}

// Tangent planes of an ellipsoid along the directions of a refined cube.
std::vector<std::array<double, 4>> tangent_planes(Vec3 axes) {
  std::vector<std::array<double, 4>> planes;
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k) {
        if (!i && !j && !k) continue;
        // Normals of the image of a sphere: evenly spread on long ellipsoids too.
        Vec3 n{i / axes.x, j / axes.y, k / axes.z};
        n = (1 / norm(n)) * n;
        planes.push_back({n.x, n.y, n.z, norm(Vec3{axes.x * n.x, axes.y * n.y, axes.z * n.z})});
      }
  return planes;
}

// A few of many planes, as different as possible: each next one is farthest from those taken.
std::vector<std::array<double, 4>> spread(const std::vector<std::array<double, 4>>& all) {
  if (all.size() <= max_planes) return all;
  std::vector<std::array<double, 4>> taken{all[0]};
  std::vector<double> cosine(all.size(), -2);
  while (taken.size() < max_planes) {
    const auto& last = taken.back();
    std::size_t next = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      cosine[i] = std::max(cosine[i], all[i][0] * last[0] + all[i][1] * last[1] + all[i][2] * last[2]);
      if (cosine[i] < cosine[next]) next = i;
    }
    taken.push_back(all[next]);
  }
  return taken;
}

ObstacleKind obstacle_kind(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::box: return ObstacleKind::box;
    case ShapeKind::sphere: return ObstacleKind::sphere;
    case ShapeKind::cylinder: return ObstacleKind::cylinder;
    case ShapeKind::capsule: return ObstacleKind::capsule;
    case ShapeKind::ellipsoid:
    case ShapeKind::hull: return ObstacleKind::polyhedron;
    case ShapeKind::half_space: return ObstacleKind::half_space;
  }
  throw std::logic_error("a shape of no known kind");
}

struct Builder {
  const Scene& scene;
  const Group& group;
  const std::vector<Transform>& X_WL;
  BatchModelStorage& out;
  std::vector<int> batch_link;
  std::vector<double> depth, extent;      // of every lane link: joints before it, metres of chain
  std::vector<int> body_of, obstacle_of;  // by geometry; -1 for no body or obstacle

  void add_links() {
    batch_link.assign(scene.tree.links.size(), -1);
    for (std::size_t i = 0; i < scene.tree.links.size(); ++i) {
      if (!group.moves[i]) continue;
      const Link& link = scene.tree.links[i];
      const int parent = link.parent < 0 ? -1 : batch_link[link.parent];
      const Transform X = parent < 0 && link.parent >= 0 ? X_WL[link.parent] * link.X_PF : link.X_PF;
      BatchLink made{parent, link.kind, static_cast<int>(out.coordinates.size()), {}, {}, {}};
      write(X, made.R, made.p);
      for (int k = 0; k < 3; ++k) made.axis[k] = static_cast<float>(link.axis[k]);
      add_coordinates(link);
      batch_link[i] = static_cast<int>(out.links.size());
      depth.push_back(parent < 0 ? 1 : depth[parent] + 1);
      extent.push_back(norm(X.p) + (parent < 0 ? 0 : extent[parent]));
      out.links.push_back(made);
    }
  }

  void add_coordinates(const Link& link) {
    using Kind = BatchCoordinate::Kind;
    const auto add = [&](int offset, Kind kind) { out.coordinates.push_back({link.position + offset, kind}); };
    switch (link.kind) {
      case JointKind::revolute: add(0, Kind::angle); break;
      case JointKind::prismatic: add(0, Kind::length); break;
      case JointKind::planar: add(0, Kind::length), add(1, Kind::length), add(2, Kind::angle); break;
      case JointKind::floating:
        add(0, Kind::quaternion_w);
        for (int k = 1; k < 4; ++k) add(k, Kind::quaternion_xyz);
        for (int k = 4; k < 7; ++k) add(k, Kind::length);
        break;
      case JointKind::fixed: break;
    }
  }

  int body(int geometry) {
    if (body_of[geometry] >= 0) return body_of[geometry];
    const Geometry& g = scene.geometries[geometry];
    BatchBody made{batch_link[g.link],
                   static_cast<int>(out.outer.size()),
                   0,
                   static_cast<int>(out.inner.size()),
                   0,
                   batch_sphere(g.X_LG, g.bound, true)};
    for (const Sphere& s : g.outer) out.outer.push_back(batch_sphere(g.X_LG, s, true));
    for (const Sphere& s : g.inner) out.inner.push_back(batch_sphere(g.X_LG, s, false));
    made.outer_end = static_cast<int>(out.outer.size());
    made.inner_end = static_cast<int>(out.inner.size());
    out.bodies.push_back(made);
    return body_of[geometry] = static_cast<int>(out.bodies.size()) - 1;
  }

  int obstacle(int geometry) {
    if (obstacle_of[geometry] >= 0) return obstacle_of[geometry];
    const Geometry& g = scene.geometries[geometry];
    const Transform X_WO = scene.pose(geometry, X_WL.data());
    BatchObstacle made{};
    made.kind = obstacle_kind(g.shape.kind);
    Transform X{transposed(X_WO.R), X_WO.p};
    write(X, made.R, made.p);
    for (int k = 0; k < 3; ++k) made.size[k] = static_cast<float>(g.shape.size[k]);
    made.bound = batch_sphere(X_WO, {g.shape.center, std::min(g.shape.radius, endless)}, true);
    switch (g.shape.kind) {
      case ShapeKind::ellipsoid: add_planes(made, tangent_planes(g.shape.axes), X_WO, false); break;
      case ShapeKind::hull:
        add_planes(made, spread(g.shape.planes), X_WO,
                   g.shape.planes.size() >= min_planes && g.shape.planes.size() <= max_planes);
        break;
      case ShapeKind::box:
      case ShapeKind::sphere:
      case ShapeKind::cylinder:
      case ShapeKind::capsule:
      case ShapeKind::half_space: break;  // exactly by their sizes
    }
    out.obstacles.push_back(made);
    return obstacle_of[geometry] = static_cast<int>(out.obstacles.size()) - 1;
  }

  void add_planes(BatchObstacle& made, const std::vector<std::array<double, 4>>& planes, const Transform& X_WO,
                  bool are_all) {
    made.planes_are_all = are_all;
    made.planes_begin = static_cast<int>(out.planes.size());
    for (const auto& p : planes) {
      const Vec3 n = X_WO.R * Vec3{p[0], p[1], p[2]};
      out.planes.push_back({static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z),
                            static_cast<float>(p[3] + dot(n, X_WO.p))});
    }
    made.planes_end = static_cast<int>(out.planes.size());
  }

  double rounding_of_body(int geometry) const {
    const Geometry& g = scene.geometries[geometry];
    const int link = batch_link[g.link];
    const double reach = extent[link] + norm(g.X_LG.p) + g.shape.radius;
    return unit * losses_per_link * (depth[link] + 1) * reach;
  }

  double rounding_of_obstacle(int geometry) const {
    const Geometry& g = scene.geometries[geometry];
    const Vec3 size = g.shape.size;
    double reach = norm(scene.pose(geometry, X_WL.data()).p) + norm(size);
    if (g.shape.kind == ShapeKind::hull) reach += g.shape.radius + norm(g.shape.center);
    return unit * 12 * reach;
  }

  void add_pair(int index, const PairThreshold& threshold) {
    auto [a, b] = scene.pairs[index];
    const bool both = scene.is_moved(group, a) && scene.is_moved(group, b);
    if (!scene.is_moved(group, a) ||
        (both && batch_link[scene.geometries[a].link] > batch_link[scene.geometries[b].link]))
      std::swap(a, b);
    const double slack = exact_slack + rounding_of_body(a) + (both ? rounding_of_body(b) : rounding_of_obstacle(b));
    const int first = body(a), other = both ? body(b) : obstacle(b);
    const BatchPair pair{first, other, static_cast<float>(std::max(threshold.margin, 0.0) + slack),
                         static_cast<float>(threshold.touching - slack)};
    (both ? among_bodies : with_obstacles)
        .push_back(
            {batch_link[scene.geometries[a].link], both ? batch_link[scene.geometries[b].link] : other, pair, index});
  }

  struct BuiltPair {
    int link, other;
    BatchPair pair;
    int index;
  };
  std::vector<BuiltPair> with_obstacles, among_bodies;

  // Sorts pairs by link and obstacle or other link, and records the range of each such group.
  void group_pairs(std::vector<BuiltPair>& made, std::vector<BatchPair>& pairs, std::vector<BatchGroup>& groups) {
    std::stable_sort(made.begin(), made.end(), [](const BuiltPair& x, const BuiltPair& y) {
      return x.link != y.link ? x.link < y.link : x.other < y.other;
    });
    for (const BuiltPair& m : made) {
      const int at = static_cast<int>(pairs.size());
      if (groups.empty() || groups.back().link != m.link || groups.back().other != m.other)
        groups.push_back({m.link, m.other, at, at, m.pair.free_above});
      groups.back().end = at + 1;
      groups.back().far = std::max(groups.back().far, m.pair.free_above);
      pairs.push_back(m.pair);
      out.pair_of.push_back(m.index);
    }
  }

  // One sphere about the bounding spheres of each link's bodies, around their mean.
  void bound_links() {
    for (std::size_t link = 0; link < out.links.size(); ++link) {
      Vec3 sum;
      double count = 0, radius = 0;
      for (const BatchBody& b : out.bodies)
        if (b.link == static_cast<int>(link)) sum = sum + Vec3{b.bound.x, b.bound.y, b.bound.z}, ++count;
      const Vec3 center = count ? (1 / count) * sum : sum;
      for (const BatchBody& b : out.bodies)
        if (b.link == static_cast<int>(link))
          radius = std::max(radius, norm(Vec3{b.bound.x, b.bound.y, b.bound.z} - center) + b.bound.r);
      out.link_bounds.push_back(batch_sphere({}, {center, radius}, true));
    }
  }
};

}  // namespace

BatchModelStorage::BatchModelStorage(const Scene& scene, const Group& group,
                                     const std::vector<PairThreshold>& thresholds, const std::vector<Transform>& X_WL) {
  const std::vector<int> none(scene.geometries.size(), -1);
  Builder builder{scene, group, X_WL, *this, {}, {}, {}, none, none, {}, {}};
  builder.add_links();
  for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
    const auto [a, b] = scene.pairs[i];
    const bool moved = scene.is_moved(group, a) || scene.is_moved(group, b);
    if (moved && !scene.moves_half_space(group, {a, b}) && scene.geometries[a].link != scene.geometries[b].link)
      builder.add_pair(static_cast<int>(i), thresholds[i]);
  }
  builder.group_pairs(builder.with_obstacles, obstacle_pairs, obstacle_groups);
  builder.group_pairs(builder.among_bodies, body_pairs, link_groups);
  builder.bound_links();
  double deepest = 0;
  for (double d : builder.depth) deepest = std::max(deepest, d);
  slack_per_metre = unit * losses_per_link * (deepest + 1) * 2;
}

BatchModel BatchModelStorage::view() const {
  return {links.data(),
          static_cast<int>(links.size()),
          bodies.data(),
          static_cast<int>(bodies.size()),
          outer.data(),
          static_cast<int>(outer.size()),
          inner.data(),
          static_cast<int>(inner.size()),
          obstacles.data(),
          planes.data(),
          obstacle_pairs.data(),
          static_cast<int>(obstacle_pairs.size()),
          body_pairs.data(),
          static_cast<int>(body_pairs.size()),
          link_bounds.data(),
          obstacle_groups.data(),
          static_cast<int>(obstacle_groups.size()),
          link_groups.data(),
          static_cast<int>(link_groups.size()),
          static_cast<int>(coordinates.size())};
}

}  // namespace wayproof
