// Inverse kinematics of many seeds at once, one per SIMD lane, in double precision.
//
// `ik_simd.inc` is compiled once per instruction set, as simd_checker.inc is; a lane's numbers depend on
// no other lane and on no instruction set.
#pragma once

#include <stdint.h>

#include "model/kinds.hpp"

namespace wayproof {

struct IkTolerance {
  double box[3] = {0, 0, 0};  // half-widths about G, in G's axes [m]
  Freedom freedom = Freedom::ball;
  int axis = 2;      // of the cone, in G and in T
  double bound = 0;  // [rad]
};

// A ChainJoint without anything that the linker could share.
struct IkJoint {
  JointKind kind;
  double R[9], p[3];
  int source[max_joint_positions];
  double multiplier[max_joint_positions], offset[max_joint_positions];
  int column[max_joint_velocities];
  double factor[max_joint_velocities];
};

// Element of q that simply adds its element of v; infinite where it has no limit.
struct IkFlat {
  int position, velocity;
  bool turns;
  double lower, upper;
};

struct IkQuaternion {
  int position, velocity;
};

struct IkModel {
  const IkJoint* joints;
  int num_joints;
  double R_MT[9], p_MT[3];
  const IkFlat* flat;
  int num_flat;
  const IkQuaternion* quaternions;
  int num_quaternions;
  int num_positions, num_velocities;
};

// Solves from each seed in turn until `enough` have converged. An abandoned seed has its last q.
struct IkTask {
  IkModel model;
  IkTolerance tolerance;
  int64_t count;
  int64_t enough;
  int max_iterations;
  const double* seeds;       // [count][num_positions]
  const double* targets;     // X_WG, [num_targets][12]: R by rows, then p
  const int64_t* target_of;  // [count]
  double* q;                 // [count][num_positions]
  uint8_t* converged;        // [count]
  int64_t* iterations;       // [count]
};

// Returns the number of seeds tried: a prefix, regardless of what the lanes have done beyond. `scratch` is 64-aligned.
using IkSolver = int64_t (*)(const IkTask&, double* scratch);

struct IkKernel {
  const char* name;
  int width;
  IkSolver solve;
};

int ik_kernels(IkKernel* found, int most);

// Numbers per lane of a pose.
inline constexpr int doubles_per_pose = 12;

inline int64_t ik_scratch_doubles(const IkModel& m, int width) {
  return static_cast<int64_t>(width) * (8 * m.num_velocities + m.num_positions + doubles_per_pose * (m.num_joints + 1));
}

}  // namespace wayproof
