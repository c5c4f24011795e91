// Chain: kinematics of a frame T on a link by a group's q: its pose and its Jacobian.
#pragma once

#include <span>
#include <vector>

#include "model/tree.hpp"

namespace wayproof {

// Coordinate of a joint: multiplier * q[source] + offset with the group's q. Source -1: it is constant.
struct ChainCoordinate {
  int source = -1;
  double multiplier = 0, offset = 0;
};

// Its rate: factor * v[column] with the group's v. Column -1: none.
struct ChainRate {
  int column = -1;
  double factor = 0;
};

// Joint that the group moves, written so that z is the axis of revolute and prismatic ones.
struct ChainJoint {
  JointKind kind;
  Transform X_BF;  // B: the moving frame of the previous joint, or the world
  ChainCoordinate coordinates[max_joint_positions];
  ChainRate rates[max_joint_velocities];
};

// Element of the group's q that simply adds its element of v.
struct FlatCoordinate {
  int position, velocity;
  bool turns;  // whether whole turns of it change no pose, apart from limits
};

// First index of a quaternion in the group's q, and of its w_FM in v.
struct QuaternionCoordinate {
  int position, velocity;
};

struct Chain {
  std::vector<ChainJoint> joints;
  Transform X_MT;  // from the last joint's moving frame
  std::vector<FlatCoordinate> flat;
  std::vector<QuaternionCoordinate> quaternions;
  int num_positions = 0, num_velocities = 0;

  Chain(const Tree& tree, const Group& group, int link, const Transform& X_LT);

  Transform pose(std::span<const double> q) const;

  // Geometric Jacobian J, [6][num_velocities]: [w_WT; v_WT] = J v, all in W.
  void jacobian(std::span<const double> q, std::span<double> J) const;

  // v_WT = J v of T's origin.
  Vec3 velocity(std::span<const double> q, std::span<const double> v) const;

  // Derivatives of v_WT = J v of T's origin by the group's coordinates at a constant v, [3][num_velocities]; not for
  // joints that float.
  void velocity_gradient(std::span<const double> q, std::span<const double> v, std::span<double> gradient) const;

 private:
  // Calls `visit(rate, w, v)` with the spatial velocity of T per unit of each rate, from the base to the tip.
  template <typename Visit>
  void visit_rates(std::span<const double> q, Visit visit) const;
};

}  // namespace wayproof
