#include "model/dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace wayproof {
namespace {

Vec3 vec_of(const double* x) { return {x[0], x[1], x[2]}; }

// A joint's motion in its fixed frame F: turning rate, velocity of M's origin.
struct Rates {
  Vec3 turn, shift;
};

Rates rates_of(const Link& link, const double* full) {
  const double* v = full + link.velocity;
  switch (link.kind) {
    case JointKind::revolute: return {v[0] * link.axis, {}};
    case JointKind::prismatic: return {{}, v[0] * link.axis};
    case JointKind::planar: return {{0, 0, v[2]}, {v[0], v[1], 0}};
    case JointKind::floating: return {vec_of(v), vec_of(v + 3)};
    case JointKind::fixed: return {};
  }
  throw std::logic_error("a joint of no known kind");
}

}  // namespace

InverseDynamics::InverseDynamics(const Tree& tree, Group group, std::vector<Inertia> inertias,
                                 std::vector<double> rotors, Vec3 gravity)
    : tree_(tree), group_(std::move(group)), inertias_(std::move(inertias)), rotors_(std::move(rotors)) {
  world_.a = -gravity;  // as if the world were accelerated upwards
}

InverseDynamics::Work InverseDynamics::work() const {
  const auto nv = static_cast<std::size_t>(tree_.num_velocities);
  const std::size_t count = tree_.links.size();
  Work work{group_.state,
            std::vector<double>(nv),
            std::vector<double>(nv),
            std::vector<double>(nv),
            std::vector<Transform>(count),
            std::vector<Mat3>(count),
            std::vector<State>(count, world_),
            {},
            {},
            std::vector<int>(count, -1),
            {}};
  tree_.place(work.q.data(), work.X_WL.data());
  return work;
}

void InverseDynamics::efforts(const double* q, const double* v, const double* vdot, double* tau, Work& work) const {
  place(q, work);
  efforts_here(v, vdot, tau, work);
}

void InverseDynamics::place(const double* q, Work& work) const {
  group_.embed(tree_, q, work.q.data());
  group_.place(tree_, work.q.data(), work.X_WL.data());
  for (std::size_t i = 0; i < tree_.links.size(); ++i) {
    const Link& link = tree_.links[i];
    if (group_.moves[i]) work.R_WF[i] = link.parent < 0 ? link.X_PF.R : work.X_WL[link.parent].R * link.X_PF.R;
  }
}

void InverseDynamics::efforts_here(const double* v, const double* vdot, double* tau, Work& work) const {
  spread(v, work.v), spread(vdot, work.vdot);
  std::fill(work.tau.begin(), work.tau.end(), 0.0);
  const std::size_t count = tree_.links.size();
  for (std::size_t i = 0; i < count; ++i)
    if (group_.moves[i]) move(i, work), load(i, work);
  for (std::size_t i = count; i-- > 0;)
    if (group_.moves[i]) collect(i, work);
  for (std::size_t k = tree_.followers.size(); k-- > 0;) {
    const Follower& f = tree_.followers[k];
    work.tau[f.leader_velocity] += f.multiplier * work.tau[f.follower_velocity];
  }
  for (std::size_t i = 0; i < group_.velocities.size(); ++i) tau[i] = work.tau[group_.velocities[i]];
}

void InverseDynamics::spread(const double* rates, std::vector<double>& full) const {
  for (std::size_t i = 0; i < group_.velocities.size(); ++i) full[group_.velocities[i]] = rates[i];
  for (const Follower& f : tree_.followers) full[f.follower_velocity] = f.multiplier * full[f.leader_velocity];
}

void InverseDynamics::move(std::size_t i, Work& work) const {
  const Link& link = tree_.links[i];
  const State& parent = link.parent < 0 ? world_ : work.states[link.parent];
  const Rates rates = rates_of(link, work.v.data()), change = rates_of(link, work.vdot.data());
  const Vec3 turn = work.R_WF[i] * rates.turn, shift = work.R_WF[i] * rates.shift;
  const Vec3 r = link.parent < 0 ? work.X_WL[i].p : work.X_WL[i].p - work.X_WL[link.parent].p;
  State& own = work.states[i];
  own.w = parent.w + turn;
  own.alpha = parent.alpha + cross(parent.w, turn) + work.R_WF[i] * change.turn;
  own.a = parent.a + cross(parent.alpha, r) + cross(parent.w, cross(parent.w, r)) + 2 * cross(parent.w, shift) +
          work.R_WF[i] * change.shift;
}

void InverseDynamics::load(std::size_t i, Work& work) const {
  const Inertia& inertia = inertias_[i];
  const Mat3& R = work.X_WL[i].R;
  State& own = work.states[i];
  const Vec3 c = R * inertia.center;
  own.force = inertia.mass * (own.a + cross(own.alpha, c) + cross(own.w, cross(own.w, c)));
  const Vec3 w = transposed_times(R, own.w), alpha = transposed_times(R, own.alpha);
  own.moment = R * (inertia.about_center * alpha + cross(w, inertia.about_center * w)) + cross(c, own.force);
}

void InverseDynamics::collect(std::size_t i, Work& work) const {
  const Link& link = tree_.links[i];
  const State& own = work.states[i];
  const Vec3 f = transposed_times(work.R_WF[i], own.force), n = transposed_times(work.R_WF[i], own.moment);
  double* tau = work.tau.data() + link.velocity;
  switch (link.kind) {
    case JointKind::revolute: tau[0] += dot(link.axis, n); break;
    case JointKind::prismatic: tau[0] += dot(link.axis, f); break;
    case JointKind::planar: tau[0] += f.x, tau[1] += f.y, tau[2] += n.z; break;
    case JointKind::floating:
      for (int k = 0; k < 3; ++k) tau[k] += n[k], tau[3 + k] += f[k];
      break;
    case JointKind::fixed: break;
  }
  for (int k = 0; k < ::wayproof::num_velocities(link.kind); ++k)
    tau[k] += rotors_[link.velocity + k] * work.vdot[link.velocity + k];
  if (link.parent < 0 || !group_.moves[link.parent]) return;
  State& parent = work.states[link.parent];
  const Vec3 r = work.X_WL[i].p - work.X_WL[link.parent].p;
  parent.force = parent.force + own.force;
  parent.moment = parent.moment + own.moment + cross(r, own.force);
}

}  // namespace wayproof
