// JointBounds: what a proof needs to know of every joint by itself, all along a motion: positions and rates in
// Bernstein form, their peaks over the limits, and the jumps between pieces. As planning/certify/joints and
// end_checks.py have it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "math/bernstein.hpp"

namespace wayproof {

// q(t) = bases[i] + the polynomial of piece i: as many positions as velocities, none of which wraps.
struct JointMotion {
  std::span<const double> breaks, bases, coefficients;  // [n + 1], [n][joints], [n][terms][joints]
  std::size_t terms, joints;

  std::size_t pieces() const { return breaks.size() - 1; }
};

struct JointLimitRows {
  std::span<const double> lower, upper;  // of positions, infinite where there is none
  std::span<const double> rates;         // [orders][joints] from velocity on, infinite where there is none
  double position_tolerance, rate_gap;   // largest excess of a bound over the true peak; of rates over their limits
};

// A peak, and where it is; joint -1: there is no limit.
struct JointPeak {
  double bound = 0;
  std::int64_t joint = -1, piece = 0;
  double fraction = 0;
};

// Largest sum of consecutive jumps between any two instants by joint, and the jump that completes it.
struct JumpSums {
  std::vector<double> largest;
  std::vector<std::int64_t> last;
};

struct JointBounds {
  std::vector<std::vector<double>> forms;  // by order from 0 on, [joints][pieces][terms of the order]
  std::vector<double> magnitudes;          // largest absolute values in them, [orders + 1][joints]
  JointPeak position;                      // largest excess over a bound, rounding errors included
  std::vector<JointPeak> rates;            // peak over limit of every order from 1 on, without rounding errors
  std::vector<JumpSums> jumps;             // of positions and rates up to the second; of that, from and to rest as well
};

// Rounding errors of Bernstein coefficients are at most this share of the largest one (`intervals/rounding.py`).
double rounding_share(std::size_t terms);

JointBounds joint_bounds(const JointMotion& motion, const JointLimitRows& limits);

}  // namespace wayproof
