#include "prover/motion_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace wayproof {
namespace {

constexpr int always = -1;
constexpr double pi = 3.141592653589793;

// Relation of a coordinate of the full q to the group.
struct Source {
  int column = -1;
  double scale = 0;
};

// Quaternions have no source: a ball moves with its link alone.
std::vector<Source> sources(const Tree& tree, const Group& group, const Motion& motion) {
  std::vector<Source> found(tree.num_positions);
  std::vector<char> quaternion(tree.num_positions, 0);
  for (const Link& link : tree.links)
    for (int k = 0; k < 4 && link.kind == JointKind::floating; ++k) quaternion[link.position + k] = 1;
  for (auto [q, v] : motion.plain()) found[group.positions[q]] = {v, 1};
  for (std::size_t round = 0; round < tree.followers.size(); ++round)
    for (std::size_t k = 0; k < tree.followers.size(); ++k) {
      const Follower& f = tree.followers[k];
      if (!group.follows[k]) continue;
      if (quaternion[f.leader] || quaternion[f.follower]) throw std::invalid_argument("a quaternion leads or follows");
      if (const Source& s = found[f.leader]; s.column >= 0) found[f.follower] = {s.column, s.scale * f.multiplier};
    }
  return found;
}

}  // namespace

MotionBounds::MotionBounds(const Scene& scene, const Group& group, const Motion& motion)
    : scene_(scene), group_(group), motion_(motion), full_(group.state), X_WL_(scene.tree.links.size()) {
  const Tree& tree = scene.tree;
  tree.place(full_.data(), X_WL_.data());
  const auto source = sources(tree, group, motion);
  for (std::size_t l = 0; l < tree.links.size(); ++l) {
    const Link& link = tree.links[l];
    chains_.push_back(link.parent < 0 ? std::vector<int>{} : chains_[link.parent]);
    const auto add = [&](bool turns, bool ball, int direction, int column, double scale, int block) {
      chains_[l].push_back(static_cast<int>(axes_.size()));
      axes_.push_back({static_cast<int>(l), turns, ball, direction, column, scale, block});
    };
    const auto plain = [&](bool turns, int direction, int position, bool counted = false) {
      const Source s = source[position];
      if (s.column < 0) return false;
      add(turns, false, direction, s.column, s.scale, counted ? -1 : motion.block_of(s.column));
      return true;
    };
    // Coordinates of one joint that shift together have one bound together, unless they follow others.
    const auto shifts = [&](int position, int count) {
      const Source first = source[position];
      bool together = first.column >= 0 && motion.blocks()[motion.block_of(first.column)].size == count;
      for (int k = 0; k < count; ++k)
        together &= source[position + k].column == first.column + k && source[position + k].scale == 1;
      for (int k = 0; k < count; ++k) plain(false, k, position + k, together && k > 0);
    };
    switch (link.kind) {
      case JointKind::fixed: break;
      case JointKind::revolute: plain(true, -1, link.position); break;
      case JointKind::prismatic: plain(false, -1, link.position); break;
      case JointKind::planar:
        shifts(link.position, 2);
        plain(true, 2, link.position + 2);
        break;
      case JointKind::floating:
        shifts(link.position + 4, 3);
        if (const Source s = source[link.position + 4]; s.column >= 0 && s.scale == 1)
          add(true, true, -1, s.column - 3, 1, motion.block_of(s.column - 3));
        break;
    }
    width_ = std::max(width_, static_cast<int>(chains_[l].size()) + 1);
  }
  directions_.resize(axes_.size());
  origins_.resize(axes_.size());
  sigmas_.assign(axes_.size(), 0);
  chords_.assign(axes_.size(), 0);
  placed_.resize(scene.geometries.size());
  reaches_.resize(scene.geometries.size() * width_);
  arms_.resize(scene.geometries.size() * width_);
}

const std::vector<int>& MotionBounds::chain(int geometry) const {
  const int link = scene_.geometries[geometry].link;
  return link < 0 ? none_ : chains_[link];
}

MotionBounds::Relative MotionBounds::relative(const Pair& pair) const {
  const auto &a = chain(pair.a), &b = chain(pair.b);
  std::size_t common = 0;
  while (common < a.size() && common < b.size() && a[common] == b[common]) ++common;
  return {static_cast<int>(common), static_cast<int>(common), common < a.size() || common < b.size()};
}

void MotionBounds::place(const double* q) {
  group_.embed(scene_.tree, q, full_.data());
  group_.place(scene_.tree, full_.data(), X_WL_.data());
  deviation_ = nullptr;
  ++stamp_;
}

void MotionBounds::enter(const JointDeviation& deviation) {
  place(deviation.q.data());
  deviation_ = &deviation;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const Axis& axis = axes_[k];
    const Link& link = scene_.tree.links[axis.link];
    const Transform& X_WL = X_WL_[axis.link];
    origins_[k] = X_WL.p;
    if (axis.direction < 0) {
      directions_[k] = X_WL.R * link.axis;
    } else if (axis.turns) {
      directions_[k] = {X_WL.R.m[axis.direction], X_WL.R.m[axis.direction + 3], X_WL.R.m[axis.direction + 6]};
    } else {
      const Vec3 unit{axis.direction == 0 ? 1.0 : 0.0, axis.direction == 1 ? 1.0 : 0.0,
                      axis.direction == 2 ? 1.0 : 0.0};
      const Vec3 in_parent = link.X_PF.R * unit;
      directions_[k] = link.parent < 0 ? in_parent : X_WL_[link.parent].R * in_parent;
    }
    sigmas_[k] = axis.block < 0 ? 0 : std::abs(axis.scale) * deviation.block[axis.block];
    chords_[k] = axis.turns ? 2 * std::sin(std::min(sigmas_[k], pi) / 2) : sigmas_[k];
  }
}

const Transform& MotionBounds::pose(int geometry) {
  Placed& placed = placed_[geometry];
  if (placed.pose_stamp != stamp_ && placed.pose_stamp != always) {
    placed.pose_stamp = chain(geometry).empty() ? always : stamp_;
    placed.X_WG = scene_.pose(geometry, X_WL_.data());
    placed.center = placed.X_WG * scene_.geometries[geometry].shape.center;
  }
  return placed.X_WG;
}

Vec3 MotionBounds::center(int geometry) {
  pose(geometry);
  return placed_[geometry].center;
}

double MotionBounds::approach(const Pair& pair, const Relative& relative) {
  const auto [by_a, by_b] = shares(pair, relative);
  return by_a + by_b;
}

std::pair<double, double> MotionBounds::shares(const Pair& pair, const Relative& relative) {
  const auto is_flat = [this](int geometry) { return scene_.geometries[geometry].shape.kind == ShapeKind::half_space; };
  if (is_flat(pair.b)) return {reach(pair.a, relative.a), swing(pair.b, relative.b, pair.a)};
  if (is_flat(pair.a)) return {swing(pair.a, relative.a, pair.b), reach(pair.b, relative.b)};
  return {reach(pair.a, relative.a), reach(pair.b, relative.b)};
}

bool MotionBounds::depends(int geometry, int from, int first, int last) const {
  const auto& axes = chain(geometry);
  for (std::size_t i = from; i < axes.size(); ++i)
    if (const int column = axes_[axes[i]].column; column >= first && column < last) return true;
  return false;
}

double MotionBounds::swing(int carrier, int from, int geometry) {
  const auto& axes = chain(carrier);
  const double radius = scene_.geometries[geometry].shape.core_radius();
  double sum = 0;
  for (std::size_t i = from; i < axes.size(); ++i) {
    const int k = axes[i];
    if (chords_[k] == 0) continue;
    const Vec3 away = center(geometry) - origins_[k];
    const double arm = radius + norm(axes_[k].ball ? away : cross(directions_[k], away));
    sum += axes_[k].turns ? chords_[k] * arm : chords_[k];
  }
  return sum;
}

double MotionBounds::reach(int geometry, int from) {
  Placed& placed = placed_[geometry];
  double* sums = &reaches_[static_cast<std::size_t>(geometry) * width_];
  if (placed.reach_stamp != stamp_) {
    placed.reach_stamp = stamp_;
    const auto& axes = chain(geometry);
    double* arms = &arms_[static_cast<std::size_t>(geometry) * width_];
    const Vec3 c = center(geometry);
    const double radius = scene_.geometries[geometry].shape.core_radius();
    int i = static_cast<int>(axes.size());
    sums[i] = 0;
    while (--i >= 0) {
      const int k = axes[i];
      if (!axes_[k].turns || chords_[k] == 0) {
        arms[i] = axes_[k].turns ? 0 : 1;
        sums[i] = sums[i + 1] + chords_[k];
        continue;
      }
      const Vec3 away = c - origins_[k];
      const double rho = radius + norm(axes_[k].ball ? away : cross(directions_[k], away));
      arms[i] = rho + sums[i + 1];
      sums[i] = sums[i + 1] + chords_[k] * rho;
    }
  }
  return sums[from];
}

}  // namespace wayproof
