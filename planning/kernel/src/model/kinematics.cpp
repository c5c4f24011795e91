#include "model/kinematics.hpp"

#include <algorithm>
#include <stdexcept>

namespace wayproof {
namespace {

int find(const std::vector<int>& all, int wanted) {
  const auto at = std::find(all.begin(), all.end(), wanted);
  return at == all.end() ? -1 : static_cast<int>(at - all.begin());
}

// Coordinates are resolved in the order of the couplings, as in Tree::follow: a coupling reads what those before it
// have written.
ChainCoordinate resolve(const Tree& tree, const Group& group, int position, int before) {
  for (int k = before - 1; k >= 0; --k) {
    const Follower& f = tree.followers[k];
    if (f.follower != position) continue;
    const ChainCoordinate leader = resolve(tree, group, f.leader, k);
    return {leader.source, f.multiplier * leader.multiplier, f.multiplier * leader.offset + f.offset};
  }
  const int source = find(group.positions, position);
  return source < 0 ? ChainCoordinate{-1, 0, group.state[position]} : ChainCoordinate{source, 1, 0};
}

ChainRate resolve_rate(const Tree& tree, const Group& group, int velocity, int before) {
  for (int k = before - 1; k >= 0; --k) {
    const Follower& f = tree.followers[k];
    if (f.follower_velocity != velocity) continue;
    const ChainRate leader = resolve_rate(tree, group, f.leader_velocity, k);
    return {leader.column, f.multiplier * leader.factor};
  }
  return {find(group.velocities, velocity), 1};
}

// Whether a coordinate of a joint is an angle about an axis that does not move with the joint.
bool is_angle(JointKind kind, int coordinate) {
  switch (kind) {
    case JointKind::revolute: return true;
    case JointKind::planar: return coordinate == 2;
    case JointKind::fixed:
    case JointKind::prismatic:
    case JointKind::floating: return false;
  }
  throw std::logic_error("a joint of no known kind");
}

// A rotation that takes z to a unit axis.
Mat3 to_axis(Vec3 a) {
  const Vec3 other = std::abs(a.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 side = cross(other, a);
  const Vec3 x = (1 / norm(side)) * side, y = cross(a, x);
  return {{x.x, y.x, a.x, x.y, y.y, a.y, x.z, y.z, a.z}};
}

Transform moved(const ChainJoint& joint, std::span<const double> q) {
  double x[max_joint_positions];
  for (int k = 0; k < num_positions(joint.kind); ++k) {
    const ChainCoordinate& c = joint.coordinates[k];
    x[k] = c.source < 0 ? c.offset : c.multiplier * q[c.source] + c.offset;
  }
  Link link;
  link.kind = joint.kind;
  link.axis = {0, 0, 1};
  return joint_transform(link, x);
}

void add_coordinates(Chain& chain, const Tree& tree, const Group& group, const Link& link) {
  if (link.kind == JointKind::fixed) return;
  const bool floats = link.kind == JointKind::floating;
  const int q = find(group.positions, link.position);
  if (q < 0) return;
  const int v = find(group.velocities, link.velocity);
  if (floats) chain.quaternions.push_back({q, v});
  const int first_q = floats ? 4 : 0, first_v = floats ? 3 : 0;
  for (int k = 0; first_q + k < num_positions(link.kind); ++k) {
    bool turns = is_angle(link.kind, k);
    for (const Follower& f : tree.followers) turns &= f.leader != link.position + k;
    chain.flat.push_back({q + first_q + k, v + first_v + k, turns});
  }
}

void put(std::span<double> J, int nv, const ChainRate& rate, Vec3 w, Vec3 v) {
  if (rate.column < 0) return;
  double* column = J.data() + rate.column;
  const double entries[6] = {w.x, w.y, w.z, v.x, v.y, v.z};
  for (int i = 0; i < 6; ++i) column[i * nv] += rate.factor * entries[i];
}

Vec3 axis_of(const Mat3& R, int i) { return {R.m[i], R.m[3 + i], R.m[6 + i]}; }

}  // namespace

Chain::Chain(const Tree& tree, const Group& group, int link, const Transform& X_LT)
    : num_positions(static_cast<int>(group.positions.size())),
      num_velocities(static_cast<int>(group.velocities.size())) {
  std::vector<int> path;
  for (int i = link; i >= 0; i = tree.links[i].parent) path.push_back(i);
  std::reverse(path.begin(), path.end());
  const int all = static_cast<int>(tree.followers.size());
  Transform X_BL;
  for (int i : path) {
    const Link& at = tree.links[i];
    X_BL = X_BL * at.X_PF;
    ChainJoint joint;
    joint.kind = at.kind;
    bool moves = false;
    for (int k = 0; k < wayproof::num_positions(at.kind); ++k) {
      joint.coordinates[k] = resolve(tree, group, at.position + k, all);
      moves |= joint.coordinates[k].source >= 0;
    }
    if (!moves) {
      X_BL = X_BL * joint_transform(at, group.state.data());
      continue;
    }
    for (int k = 0; k < wayproof::num_velocities(at.kind); ++k)
      joint.rates[k] = resolve_rate(tree, group, at.velocity + k, all);
    const bool has_axis = at.kind == JointKind::revolute || at.kind == JointKind::prismatic;
    const Transform turn{has_axis ? to_axis(at.axis) : Mat3{}, {}};
    joint.X_BF = X_BL * turn;
    joints.push_back(joint);
    X_BL = turn.inverse();
  }
  X_MT = X_BL * X_LT;
  for (const Link& at : tree.links) add_coordinates(*this, tree, group, at);
}

Transform Chain::pose(std::span<const double> q) const {
  Transform X_WM;
  for (const ChainJoint& joint : joints) X_WM = X_WM * joint.X_BF * moved(joint, q);
  return X_WM * X_MT;
}

template <typename Visit>
void Chain::visit_rates(std::span<const double> q, Visit visit) const {
  const Vec3 p_WT = pose(q).p;
  Transform X_WM;
  for (const ChainJoint& joint : joints) {
    const Transform X_WF = X_WM * joint.X_BF;
    X_WM = X_WF * moved(joint, q);
    const Vec3 arm = p_WT - X_WM.p;
    const auto turning = [&](int rate, int i) {
      visit(joint.rates[rate], axis_of(X_WF.R, i), cross(axis_of(X_WF.R, i), arm));
    };
    const auto sliding = [&](int rate, int i) { visit(joint.rates[rate], Vec3{}, axis_of(X_WF.R, i)); };
    switch (joint.kind) {
      case JointKind::revolute: turning(0, 2); break;
      case JointKind::prismatic: sliding(0, 2); break;
      case JointKind::planar:
        sliding(0, 0);
        sliding(1, 1);
        turning(2, 2);
        break;
      case JointKind::floating:
        for (int i = 0; i < 3; ++i) {
          turning(i, i);
          sliding(3 + i, i);
        }
        break;
      case JointKind::fixed: break;
    }
  }
}

void Chain::jacobian(std::span<const double> q, std::span<double> J) const {
  std::fill(J.begin(), J.end(), 0.0);
  visit_rates(q, [&](const ChainRate& rate, Vec3 w, Vec3 v) { put(J, num_velocities, rate, w, v); });
}

// One pass: the velocity of the point of T at the world's origin, and the angular velocity, added up joint by joint.
Vec3 Chain::velocity(std::span<const double> q, std::span<const double> v) const {
  Transform X_WM;
  Vec3 turn, at_origin;
  const auto speed = [&](const ChainRate& rate) { return rate.column < 0 ? 0 : rate.factor * v[rate.column]; };
  for (const ChainJoint& joint : joints) {
    const Transform X_WF = X_WM * joint.X_BF;
    X_WM = X_WF * moved(joint, q);
    const auto turning = [&](int rate, int i) {
      const Vec3 w = speed(joint.rates[rate]) * axis_of(X_WF.R, i);
      turn = turn + w, at_origin = at_origin + cross(X_WM.p, w);
    };
    const auto sliding = [&](int rate, int i) {
      at_origin = at_origin + speed(joint.rates[rate]) * axis_of(X_WF.R, i);
    };
    switch (joint.kind) {
      case JointKind::revolute: turning(0, 2); break;
      case JointKind::prismatic: sliding(0, 2); break;
      case JointKind::planar:
        sliding(0, 0);
        sliding(1, 1);
        turning(2, 2);
        break;
      case JointKind::floating:
        for (int i = 0; i < 3; ++i) {
          turning(i, i);
          sliding(3 + i, i);
        }
        break;
      case JointKind::fixed: break;
    }
  }
  return at_origin + cross(turn, (X_WM * X_MT).p);
}

// A joint k nearer to the base than m, or m itself, turns the column v_m: its derivative by k is w_k x v_m; so that by
// m of v_k is w_k x v_m as well.
void Chain::velocity_gradient(std::span<const double> q, std::span<const double> v, std::span<double> gradient) const {
  std::fill(gradient.begin(), gradient.end(), 0.0);
  Vec3 beyond;  // velocity by the rates from the present one to the tip
  const auto speed = [&](const ChainRate& rate) { return rate.column < 0 ? 0 : rate.factor * v[rate.column]; };
  visit_rates(q, [&](const ChainRate& rate, Vec3, Vec3 by_rate) { beyond = beyond + speed(rate) * by_rate; });
  Vec3 before;  // angular velocity by the rates from the base to the one before
  visit_rates(q, [&](const ChainRate& rate, Vec3 w, Vec3 by_rate) {
    const Vec3 change = cross(w, beyond) + cross(before, by_rate);
    if (rate.column >= 0)
      for (int i = 0; i < 3; ++i) gradient[i * num_velocities + rate.column] += rate.factor * change[i];
    beyond = beyond - speed(rate) * by_rate;
    before = before + speed(rate) * w;
  });
}

}  // namespace wayproof
