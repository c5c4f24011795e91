// Tree: the links of a scene and the joints between them, in double precision.
#pragma once

#include <cstddef>
#include <vector>

#include "math/vec.hpp"
#include "model/kinds.hpp"

namespace wayproof {

// Link L with its parent joint. The frame of L is the joint's moving frame M, so that X_WL = X_WP X_PF X_FM(q). Planar:
// q = (x, y, angle about z). Floating: q = (quaternion [w, x, y, z], p_FM).
struct Link {
  int parent = -1;  // an earlier link; -1: the world
  Transform X_PF;
  JointKind kind = JointKind::fixed;
  Vec3 axis;         // unit, in F; of revolute and prismatic joints
  int position = 0;  // first index of its coordinates in the full q
  int velocity = 0;  // first index in the full v; planar (x, y, angle), floating (w_FM in F, v_FM in F)
};

// Mimic coordinate: q[follower] = multiplier q[leader] + offset.
struct Follower {
  int follower, leader;
  double multiplier, offset;
  int follower_velocity, leader_velocity;
};

// Number of coordinates of a joint in q, and in v.
int num_positions(JointKind kind);
int num_velocities(JointKind kind);
Transform joint_transform(const Link& link, const double* q);

// Kinematic tree of all links, the world excluded. A link comes after its parent.
struct Tree {
  std::vector<Link> links;
  std::vector<Follower> followers;
  int num_positions = 0;
  int num_velocities = 0;

  // Sets all followers from their leaders, in place.
  void follow(double* q) const {
    for (const auto& f : followers) q[f.follower] = f.multiplier * q[f.leader] + f.offset;
  }

  // X_WL of every link at a full q.
  void place(const double* q, Transform* X_WL) const {
    for (std::size_t i = 0; i < links.size(); ++i) place_one(i, q, X_WL);
  }

  void place_one(std::size_t i, const double* q, Transform* X_WL) const {
    const Link& link = links[i];
    const Transform X_PL = link.X_PF * joint_transform(link, q);
    X_WL[i] = link.parent < 0 ? X_PL : X_WL[link.parent] * X_PL;
  }
};

// Joint group: some coordinates of the tree move, all others stay.
struct Group {
  std::vector<int> positions;   // of the group's q in the full q
  std::vector<int> velocities;  // of the group's v in the full v
  std::vector<double> state;    // the full q, followers following
  std::vector<char> moves;      // whether each link's pose depends on the group's q
  std::vector<char> follows;    // whether each follower does

  Group(const Tree& tree, std::vector<int> positions, std::vector<int> velocities, std::vector<double> state);

  // Writes the group's q into a full q that already holds the state.
  void embed(const Tree& tree, const double* q, double* full) const {
    for (std::size_t i = 0; i < positions.size(); ++i) full[positions[i]] = q[i];
    tree.follow(full);
  }

  // Poses of the links that move; the others are left as they are.
  void place(const Tree& tree, const double* full, Transform* X_WL) const {
    for (std::size_t i = 0; i < tree.links.size(); ++i)
      if (moves[i]) tree.place_one(i, full, X_WL);
  }
};

}  // namespace wayproof
