// SeriesKernel: Taylor series of the torques along segments of a motion, with bounds on their errors, for several
// segments at once, one in each lane. Proofs alone use it: it shares nothing with InverseDynamics, which motions are
// made with.
//
// Nothing of the standard library: the files that are compiled once per instruction set include this.
#pragma once

namespace wayproof {

// Number of coefficients of the torques' polynomials.
inline constexpr int torque_terms = 5;
// Coefficients of the coordinates that these need, and those that their remainders need.
inline constexpr int motion_terms = torque_terms + 2, bound_terms = torque_terms + 3;
// Position, velocity and acceleration of a point.
inline constexpr int point_terms = 3;

// A link that one coordinate turns about an axis, or shifts along it. Its frame is the one that moves.
struct MovingLink {
  int parent;  // an earlier link; -1: the world
  bool turns;
  int position, velocity;            // indices of the coordinate in q and v
  double R_PF[9], p_PF[3], axis[3];  // at coordinate 0; the axis in F
  double scale, offset;              // of the coordinate
  double damping, rotor_inertia;     // of the joint
  double mass, center[3];            // centre of mass
  double moments[3], principal[9];   // principal second moments about it, and their directions as columns
};

struct SeriesChain {
  const MovingLink* links;
  int num_links, num_positions, num_velocities;
  double gravity[3];
  // Order of the derivative in the inertial terms: 2, or 1 or 0 for shares of the torque.
  int order;
};

// One segment of a motion: its piece's base [nq] and coefficients [terms][nv], lowest power first, and its middle and
// half width since the piece's beginning.
struct SeriesSegment {
  const double *base, *coefficients;
  double middle, half;
};

struct SeriesKernel {
  const char* name;
  int width;
  // Doubles of work space, aligned to 64 bytes.
  int (*work_size)(const SeriesChain& chain, int terms);
  // Writes torque coefficients about the middle [width][torque_terms][nv], and bounds of their errors [width][nv].
  // NaN where numbers overflow.
  void (*torques)(const SeriesChain& chain, const SeriesSegment* segments, int terms, double* work, double* taylor,
                  double* errors);
  // Writes the motion [width][point_terms][3] of a point fixed in the last link, in W, at the segments' middles.
  void (*points)(const SeriesChain& chain, const SeriesSegment* segments, int terms, const double* point, double* work,
                 double* found);
};

// Writes those that run here, best first; returns their number.
int series_kernels(SeriesKernel* found, int most);

}  // namespace wayproof
