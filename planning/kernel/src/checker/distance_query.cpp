#include "checker/distance_query.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "model/gjk.hpp"
#include "model/overlap.hpp"

namespace wayproof {
namespace {

// Shapes that overlap are moved this far apart to find their contact point [m].
constexpr double apart = 1e-3;

// Source of a coordinate of the full v in the group's v.
struct Source {
  int column = -1;
  double factor = 0;
};

std::vector<Source> sources(const Tree& tree, const Group& group) {
  std::vector<Source> found(tree.num_velocities);
  for (std::size_t i = 0; i < group.velocities.size(); ++i) found[group.velocities[i]] = {static_cast<int>(i), 1};
  for (const Follower& f : tree.followers) {
    const Source leader = found[f.leader_velocity];
    found[f.follower_velocity] = {leader.column, f.multiplier * leader.factor};
  }
  return found;
}

// More than the rounding of distances and of motions that are added up, as these are near 1 m [m].
constexpr double rounding = 1e-9;
constexpr double inf = std::numeric_limits<double>::infinity();

// At least what any point of a shape moves by from one pose to another: by its centre, and about it. Points at the
// distance r of it move by at most r |R' - R| (spectral norm), which is the Frobenius norm over sqrt(2) for rotations.
double motion_bound(const Shape& shape, const Transform& X, Vec3 center, const Transform& X_next, Vec3 center_next) {
  if (shape.kind == ShapeKind::half_space) return inf;
  double square = 0;
  for (std::size_t k = 0; k < X.R.m.size(); ++k) square += (X_next.R.m[k] - X.R.m[k]) * (X_next.R.m[k] - X.R.m[k]);
  return norm(center_next - center) + shape.core_radius() * std::sqrt(square) / std::numbers::sqrt2;
}

Vec3 unit(int i) { return {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}; }

}  // namespace

// Buffers of one configuration.
struct DistanceQuery::Workspace {
  std::vector<double> full;
  std::vector<Transform> X_WL, X_WG;
  std::vector<Vec3> centers;
  std::vector<Screw> screws;
  std::vector<Features> features;  // of the last search for the distance of each moved pair
  // Bounds on how far each geometry has moved since the first configuration, and on how far the two of each moved pair
  // must have moved together before the pair can be within reach.
  std::vector<double> moved, far_until;
};

DistanceQuery::DistanceQuery(std::shared_ptr<const Scene> scene, Group group)
    : scene_(std::move(scene)), group_(std::move(group)), X_WL_(scene_->tree.links.size()) {
  const Tree& tree = scene_->tree;
  tree.place(group_.state.data(), X_WL_.data());
  const auto from = sources(tree, group_);
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    const Link& link = tree.links[i];
    const auto add = [&](int k, bool turns, bool in_parent, Vec3 axis) {
      const Source source = from[link.velocity + k];
      if (source.column >= 0)
        rates_.push_back({static_cast<int>(i), source.column, source.factor, turns, in_parent, axis});
    };
    switch (link.kind) {
      case JointKind::revolute: add(0, true, false, link.axis); break;
      case JointKind::prismatic: add(0, false, false, link.axis); break;
      case JointKind::planar:
        add(0, false, true, unit(0)), add(1, false, true, unit(1)), add(2, true, true, unit(2));
        break;
      case JointKind::floating:
        for (int k = 0; k < 3; ++k) add(k, true, true, unit(k)), add(3 + k, false, true, unit(k));
        break;
      case JointKind::fixed: break;
    }
  }
  for (std::size_t i = 0; i < scene_->pairs.size(); ++i) {
    const Geometry &a = scene_->geometries[scene_->pairs[i].a], &b = scene_->geometries[scene_->pairs[i].b];
    // Two half spaces overlap without bound at any configuration of the group.
    if (a.shape.kind == ShapeKind::half_space && b.shape.kind == ShapeKind::half_space) continue;
    const auto of_a = rates_of(a.link), of_b = rates_of(b.link);
    MovedPair moved{static_cast<int>(i), {}, {}, a.shape.radius + b.shape.radius};
    std::set_difference(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::back_inserter(moved.of_a));
    std::set_difference(of_b.begin(), of_b.end(), of_a.begin(), of_a.end(), std::back_inserter(moved.of_b));
    if (!moved.of_a.empty() || !moved.of_b.empty()) moved_.push_back(std::move(moved));
  }
}

// Indices of the rates that move a link, in increasing order.
std::vector<int> DistanceQuery::rates_of(int link) const {
  std::vector<int> found;
  for (int i = link; i >= 0; i = scene_->tree.links[i].parent)
    for (std::size_t k = 0; k < rates_.size(); ++k)
      if (rates_[k].link == i) found.push_back(static_cast<int>(k));
  std::sort(found.begin(), found.end());
  return found;
}

void DistanceQuery::slope(const MovedPair& moved, const Workspace& w, Vec3 n, Vec3 p_A, Vec3 p_B,
                          double* gradient) const {
  const auto add = [&](const std::vector<int>& rates, Vec3 p, double sign) {
    for (int k : rates) {
      const Screw& screw = w.screws[k];
      const Vec3 rate = rates_[k].turns ? cross(screw.axis, p - screw.p) : screw.axis;
      gradient[rates_[k].column] += sign * rates_[k].factor * dot(n, rate);
    }
  };
  add(moved.of_a, p_A, 1);
  add(moved.of_b, p_B, -1);
}

void DistanceQuery::look(const MovedPair& moved, double reach, Workspace& w, std::int64_t configuration,
                         DistanceRows& rows) const {
  const Pair pair = scene_->pairs[moved.pair];
  const auto index = static_cast<std::size_t>(&moved - moved_.data());
  const double so_far = w.moved[pair.a] + w.moved[pair.b];
  if (so_far < w.far_until[index]) return;
  const auto is_far = [&](double lower) { w.far_until[index] = so_far + (lower - reach) - rounding; };
  const Vec3 between = w.centers[pair.a] - w.centers[pair.b];
  const double far = reach + moved.bound, square = dot(between, between);
  if (square >= far * far && far >= 0) return is_far(std::sqrt(square) - moved.bound);
  const Shape &a = scene_->geometries[pair.a].shape, &b = scene_->geometries[pair.b].shape;
  const Transform &X_WA = w.X_WG[pair.a], &X_WB = w.X_WG[pair.b];
  ClosestPoints met = closest_points(a, X_WA, b, X_WB, reach, w.features[index]);
  double distance = met.separation.lower;
  if (distance >= reach) return is_far(distance);
  const bool has_half_space = a.kind == ShapeKind::half_space || b.kind == ShapeKind::half_space;
  Vec3 n = met.separation.direction, shift;
  if (!has_half_space && distance <= 0) {
    const Overlap over = overlap(a, X_WA, b, X_WB);
    if (over.width >= reach) return;
    distance = over.width, n = over.n, shift = (apart - distance) * n;
    Transform X_WC = X_WA;
    X_WC.p = X_WA.p + shift;
    Features along;
    along.direction = n;
    met = closest_points(a, X_WC, b, X_WB, 1e9, along);
  }
  rows.configuration.push_back(configuration);
  rows.pair.push_back(moved.pair);
  rows.distance.push_back(distance);
  rows.normal.insert(rows.normal.end(), {n.x, n.y, n.z});
  rows.gradient.resize(rows.gradient.size() + num_velocities(), 0.0);
  slope(moved, w, n, met.p_W - shift, met.p_W, rows.gradient.data() + rows.gradient.size() - num_velocities());
}

DistanceRows DistanceQuery::within(std::span<const double> qs, std::size_t count, std::span<const double> reach) const {
  const Tree& tree = scene_->tree;
  const std::size_t num_geometries = scene_->geometries.size();
  Workspace w{group_.state, X_WL_, {}, {}, {}, std::vector<Features>(moved_.size()), {}, {}};
  w.X_WG.resize(num_geometries), w.centers.resize(num_geometries), w.screws.resize(rates_.size());
  w.moved.resize(num_geometries), w.far_until.assign(moved_.size(), -inf);
  DistanceRows rows;
  for (std::size_t i = 0; i < count; ++i) {
    group_.embed(tree, qs.data() + i * static_cast<std::size_t>(num_positions()), w.full.data());
    group_.place(tree, w.full.data(), w.X_WL.data());
    for (std::size_t g = 0; g < num_geometries; ++g) {
      if (i && !scene_->is_moved(group_, static_cast<int>(g))) continue;
      const Shape& shape = scene_->geometries[g].shape;
      const Transform X_WG = scene_->pose(static_cast<int>(g), w.X_WL.data());
      const Vec3 center = X_WG * shape.center;
      if (i) w.moved[g] += motion_bound(shape, w.X_WG[g], w.centers[g], X_WG, center);
      w.X_WG[g] = X_WG, w.centers[g] = center;
    }
    for (std::size_t k = 0; k < rates_.size(); ++k) {
      const Link& link = tree.links[rates_[k].link];
      const Mat3 R_WP = link.parent < 0 ? Mat3{} : w.X_WL[link.parent].R;
      const Mat3 R = rates_[k].in_parent ? R_WP * link.X_PF.R : w.X_WL[rates_[k].link].R;
      w.screws[k] = {R * rates_[k].axis, w.X_WL[rates_[k].link].p};
    }
    for (const MovedPair& moved : moved_) look(moved, reach[moved.pair], w, static_cast<std::int64_t>(i), rows);
  }
  return rows;
}

}  // namespace wayproof
