// Derivatives of joint efforts by positions, velocities and accelerations, in closed form (Singh, Russell and Wensing,
// "Efficient analytical derivatives of rigid-body dynamics using spatial vector algebra", RA-L 2022), about the world's
// origin and in its axes. A joint of several coordinates is a sequence of joints of one, without masses between them.
#include <algorithm>
#include <cstddef>

#include "model/dynamics.hpp"

namespace wayproof {
namespace {

using Coordinate = InverseDynamics::Coordinate;
using Composite = InverseDynamics::Composite;
using Twist = InverseDynamics::Twist;

Twist operator+(const Twist& a, const Twist& b) { return {a.turn + b.turn, a.shift + b.shift}; }
Twist operator*(double s, const Twist& a) { return {s * a.turn, s * a.shift}; }
Twist cross(const Twist& a, const Twist& b) {
  return {cross(a.turn, b.turn), cross(a.turn, b.shift) + cross(a.shift, b.turn)};
}
// Of a twist with a wrench (moment; force), or with another twist by coordinates.
double dot(const Twist& a, const Twist& b) { return dot(a.turn, b.turn) + dot(a.shift, b.shift); }

Mat3 operator+(const Mat3& a, const Mat3& b) {
  Mat3 sum;
  for (int k = 0; k < 9; ++k) sum.m[k] = a.m[k] + b.m[k];
  return sum;
}

Mat3 operator*(double s, const Mat3& a) {
  Mat3 scaled;
  for (int k = 0; k < 9; ++k) scaled.m[k] = s * a.m[k];
  return scaled;
}

// [a]x b = a x b.
Mat3 skew(const Vec3& a) { return {{0, -a.z, a.y, a.z, 0, -a.x, -a.y, a.x, 0}}; }

double trace(const Mat3& a) { return a.m[0] + a.m[4] + a.m[8]; }

// The momentum of a twist.
Twist momentum(const Composite& c, const Twist& v) {
  return {c.inertia * v.turn + cross(c.moment, v.shift), c.mass * v.shift + cross(v.turn, c.moment)};
}

// A link as it moves: its masses, momenta and the wrench that accelerates it.
Composite moving(double mass, const Vec3& center, const Mat3& about_center, const Twist& v, const Twist& a) {
  Composite c;
  c.mass = mass, c.moment = mass * center;
  const Mat3 to_center = skew(center);
  c.inertia = about_center + -mass * (to_center * to_center);
  const Twist carried = momentum(c, v), rate = momentum(c, a);
  c.linear = carried.shift;
  c.wrench = rate + Twist{cross(v.turn, carried.turn) + cross(v.shift, carried.shift), cross(v.turn, carried.shift)};
  // Twice the B of the paper, for the turning part of what it is applied to; the shifting part has none. The wrench
  // of a turn `a` is (curl a; 2 a x linear).
  Mat3 spread = -2.0 * c.inertia;
  for (int k : {0, 4, 8}) spread.m[k] += trace(c.inertia);
  c.curl = spread * skew(v.turn) + -2.0 * skew(c.inertia * v.turn) + -2.0 * (skew(c.moment) * skew(v.shift));
  return c;
}

void add(Composite& to, const Composite& c) {
  to.mass += c.mass, to.moment = to.moment + c.moment, to.inertia = to.inertia + c.inertia;
  to.linear = to.linear + c.linear, to.curl = to.curl + c.curl, to.wrench = to.wrench + c.wrench;
}

Composite nothing() {
  Composite c;
  c.inertia = c.curl = {{0, 0, 0, 0, 0, 0, 0, 0, 0}};
  return c;
}

}  // namespace

// The coordinates of a link's joint, and the link's masses at the last of them.
void InverseDynamics::add_coordinates(std::size_t i, Work& work) const {
  const Link& link = tree_.links[i];
  int last = link.parent < 0 || !group_.moves[link.parent] ? -1 : work.last_coordinate[link.parent];
  const auto add_one = [&](int k, const Twist& axis) {
    Coordinate one{link.velocity + k, last, axis, {}, {}, {}, {}};
    const Twist v = last < 0 ? Twist{} : work.coordinates[last].v;
    const Twist a = last < 0 ? Twist{{}, world_.a} : work.coordinates[last].a;
    one.carried = cross(v, axis);
    one.accelerated = cross(a, axis) + cross(v, one.carried);
    one.v = v + work.v[one.velocity] * axis;
    one.a = a + work.vdot[one.velocity] * axis + work.v[one.velocity] * one.carried;
    last = static_cast<int>(work.coordinates.size());
    work.coordinates.push_back(one), work.composites.push_back(nothing());
  };
  const Mat3& R = work.R_WF[i];
  const Vec3 &p = work.X_WL[i].p, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  const auto turn = [&p](const Vec3& axis) { return Twist{axis, wayproof::cross(p, axis)}; };
  switch (link.kind) {
    case JointKind::revolute: add_one(0, turn(R * link.axis)); break;
    case JointKind::prismatic: add_one(0, {{}, R * link.axis}); break;
    case JointKind::planar: add_one(0, {{}, R * x}), add_one(1, {{}, R * y}), add_one(2, turn(R * z)); break;
    case JointKind::floating:  // none of the group's: it rests
    case JointKind::fixed: break;
  }
  work.last_coordinate[i] = last;
  if (last < 0) return;
  const Inertia& inertia = inertias_[i];
  const Transform& X = work.X_WL[i];
  const Coordinate& at = work.coordinates[last];
  add(work.composites[last],
      moving(inertia.mass, X.R * inertia.center + X.p, X.R * inertia.about_center * transposed(X.R), at.v, at.a));
}

void InverseDynamics::derivatives(const double* q, const double* v, const double* vdot, double* found,
                                  Work& work) const {
  place(q, work);
  spread(v, work.v), spread(vdot, work.vdot);
  work.coordinates.clear(), work.composites.clear();
  for (std::size_t i = 0; i < tree_.links.size(); ++i)
    if (group_.moves[i]) add_coordinates(i, work);
  const std::size_t full = work.v.size(), square = full * full;
  std::vector<double>& by = work.slopes;
  by.assign(3 * square, 0.0);
  for (std::size_t i = work.coordinates.size(); i-- > 0;) {
    const Coordinate& own = work.coordinates[i];
    const Composite& c = work.composites[i];
    const Twist& axis = own.axis;
    const Vec3 curled = transposed_times(c.curl, axis.turn) + 2 * wayproof::cross(c.linear, axis.shift);
    const Twist heavy = momentum(c, axis), carried = momentum(c, own.carried), faster = momentum(c, own.accelerated);
    const auto curl = [&c](const Vec3& turn) { return Twist{c.curl * turn, 2 * wayproof::cross(turn, c.linear)}; };
    const Twist turned{wayproof::cross(axis.turn, c.wrench.turn) + wayproof::cross(axis.shift, c.wrench.shift),
                       wayproof::cross(axis.turn, c.wrench.shift)};
    const Twist by_q = curl(own.carried.turn) + faster + turned, by_v = curl(axis.turn) + 2.0 * carried;
    const auto row = static_cast<std::size_t>(own.velocity) * full;
    for (int j = static_cast<int>(i); j >= 0; j = work.coordinates[j].parent) {
      const Coordinate& other = work.coordinates[j];
      const auto k = static_cast<std::size_t>(other.velocity);
      // Of the own effort by the other's coordinate, and the other way round.
      by[row + k] = wayproof::dot(curled, other.carried.turn) + dot(heavy, other.accelerated);
      by[square + row + k] = wayproof::dot(curled, other.axis.turn) + 2 * dot(heavy, other.carried);
      by[2 * square + row + k] = dot(heavy, other.axis);
      if (j == static_cast<int>(i)) continue;
      const std::size_t mirrored = k * full + static_cast<std::size_t>(own.velocity);
      by[mirrored] = dot(other.axis, by_q);
      by[square + mirrored] = dot(other.axis, by_v);
      by[2 * square + mirrored] = by[2 * square + row + k];
    }
    by[2 * square + row + static_cast<std::size_t>(own.velocity)] += rotors_[own.velocity];
    if (own.parent >= 0) add(work.composites[own.parent], c);
  }
  gather(by, found);
}

// Followers add to their leaders, as rows and as columns.
void InverseDynamics::gather(std::vector<double>& by, double* found) const {
  const std::size_t nv = num_velocities(), full = static_cast<std::size_t>(tree_.num_velocities);
  for (std::size_t part = 0; part < 3; ++part) {
    double* slopes = &by[part * full * full];
    for (std::size_t k = tree_.followers.size(); k-- > 0;) {
      const Follower& f = tree_.followers[k];
      const auto from = static_cast<std::size_t>(f.follower_velocity), to = static_cast<std::size_t>(f.leader_velocity);
      for (std::size_t j = 0; j < full; ++j) slopes[to * full + j] += f.multiplier * slopes[from * full + j];
      for (std::size_t j = 0; j < full; ++j) slopes[j * full + to] += f.multiplier * slopes[j * full + from];
    }
    for (std::size_t i = 0; i < nv; ++i)
      for (std::size_t j = 0; j < nv; ++j)
        found[(part * nv + i) * nv + j] = slopes[static_cast<std::size_t>(group_.velocities[i]) * full +
                                                 static_cast<std::size_t>(group_.velocities[j])];
  }
}

}  // namespace wayproof
