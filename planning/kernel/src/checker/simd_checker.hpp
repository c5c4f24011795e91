// SIMD checker: collision verdicts of many configurations at once, one per lane, in single precision.
//
// `simd_checker.inc` is compiled once per instruction set, each in a namespace of its own and without
// anything of the standard library that the linker could share between them.
#pragma once

#include "model/kinds.hpp"

namespace wayproof {

struct BatchSphere {
  float x, y, z, r;
};

// Moving link; see Link. The parent is a lane link, or -1 if it is static.
struct BatchLink {
  int parent;
  JointKind kind;
  int coordinate;
  float R[9], p[3];
  float axis[3];
};

// Moving collision geometry; all its spheres are in its link's frame.
struct BatchBody {
  int link;
  int outer_begin, outer_end, inner_begin, inner_end;
  BatchSphere bound;
};

// Kinds of obstacles that have distances in lanes. Ellipsoids and hulls are polyhedra that contain them.
enum class ObstacleKind : int { box, sphere, cylinder, capsule, polyhedron, half_space };

// Static collision geometry: R_OW, p_WO and its size, or planes in W.
struct BatchObstacle {
  ObstacleKind kind;
  float R[9], p[3], size[3];
  BatchSphere bound;
  int planes_begin, planes_end;
  bool planes_are_all;  // else the planes only contain the obstacle
};

struct BatchPlane {
  float x, y, z, d;
};

// A body against an obstacle or another body: beyond `free_above` it is certainly free, nearer than `hit_below` it
// certainly collides. Both allow for rounding. `free_above` is positive: lanes know distances, but few depths, so that
// a margin below zero, which permits penetration, is left to exact distances.
struct BatchPair {
  int body, other;
  float free_above, hit_below;
};

// Pairs of one link with one obstacle or another link: where those two are farther apart than `far`, none of the pairs
// is checked.
struct BatchGroup {
  int link, other;
  int begin, end;
  float far;
};

struct BatchModel {
  const BatchLink* links;
  int num_links;
  const BatchBody* bodies;
  int num_bodies;
  const BatchSphere* outer;
  int num_outer;
  const BatchSphere* inner;
  int num_inner;
  const BatchObstacle* obstacles;
  const BatchPlane* planes;
  const BatchPair* obstacle_pairs;
  int num_obstacle_pairs;
  const BatchPair* body_pairs;
  int num_body_pairs;
  const BatchSphere* link_bounds;  // around all bodies of each link
  const BatchGroup* obstacle_groups;
  int num_obstacle_groups;
  const BatchGroup* link_groups;
  int num_link_groups;
  int num_coordinates;
};

// Undecided pairs, with their lanes. Pairs are numbered obstacle pairs first. Where any hit decides, the check ends
// with the first one, and begins with the pair of `likely`, if it is not negative; a hit leaves its pair there.
struct BatchVerdict {
  unsigned hit;
  int num_unsure;
  int* pairs;
  unsigned* lanes;
  bool any_hit_decides;
  int likely;
};

// Checks `active` lanes. Coordinates: [num_coordinates][lanes]; angles within [-pi, pi], quaternions of unit length.
// `slack` is added to every threshold [m]. `scratch` is 64-aligned.
using BatchChecker = void (*)(const BatchModel&, const float* coordinates, unsigned active, float slack, float* scratch,
                              BatchVerdict&);

struct BatchKernel {
  const char* name;
  int width;
  BatchChecker check;
};

// Every kernel that this machine can run, for tests; the best one first.
int batch_kernels(BatchKernel* found, int most);

// Numbers per lane of a point and of a pose.
inline constexpr int floats_per_point = 3, floats_per_pose = 12;

// Words of a set of bodies, a bit for each.
inline int words_of_bodies(const BatchModel& m) { return m.num_bodies / 64 + 1; }

// Floats that `scratch` must hold: poses and bounds of links, bounds and spheres of bodies, two sets of bodies.
inline long scratch_floats(const BatchModel& m, int width) {
  const long points = m.num_links + m.num_bodies + m.num_outer + m.num_inner;
  const long words = 2L * words_of_bodies(m) * static_cast<long>(sizeof(unsigned long long) / sizeof(float));
  return width * (floats_per_pose * static_cast<long>(m.num_links) + floats_per_point * points) + words;
}

}  // namespace wayproof
