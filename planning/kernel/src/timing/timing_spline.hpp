// TimingSpline: the cubic spline s(t) through given parameters after given durations, at rest and without acceleration
// at both ends; planning/retime/jerk/timing_spline.py describes it.
//
// The rests fix the second and the last but one parameter: s_1 = s_0 + h_0^2 a_1 / 6, and likewise at the end. What is
// left is a tridiagonal system in the accelerations between phases.
#pragma once

#include <vector>

#include "math/band_matrix.hpp"
#include "timing/speed_profile.hpp"

namespace wayproof {

// Derivatives of the states at both ends of a phase by one variable: the logarithm of a duration, or an acceleration.
struct StateSlope {
  int variable;
  double v[2], a[2], j;
};

// Those of one phase; no phase has more variables.
struct PhaseSlopes {
  int count = 0;
  StateSlope of[4];
};

class TimingSpline {
 public:
  // Of at least four phases.
  explicit TimingSpline(std::vector<double> parameters);

  int num_phases() const { return n_; }
  // Variables, interleaved so that those of neighbours are near: log h_0, (multiplier, a_1, log h_1), ...
  int num_variables() const { return 3 * n_ - 2; }
  static int duration_variable(int phase) { return 3 * phase; }
  static int multiplier(int node) { return 3 * node - 2; }
  static int acceleration_variable(int node) { return 3 * node - 1; }
  // Neither slopes nor constraints join variables farther apart.
  static constexpr int half_band = 5;

  // Durations of phases; false if there is no spline.
  bool set_durations(const std::vector<double>& h);
  // Whether s increases over every phase and the speed is positive between them.
  bool is_increasing() const;
  // With v at both ends of every phase: one entry more than SpeedProfile has; likewise a.
  const std::vector<double>& h() const { return h_; }
  const std::vector<double>& s() const { return s_; }
  const std::vector<double>& v() const { return v_; }
  const std::vector<double>& a() const { return a_; }
  const std::vector<double>& j() const { return j_; }
  SpeedProfile profile() const;

  PhaseSlopes slopes(int phase) const;
  // Adds the derivatives of the equation of continuous speed at an inner node, and their transpose.
  void add_continuity(int node, BandMatrix<half_band>& matrix) const;

 private:
  // s_i = base + factor a_i, where a rest fixes it.
  double factor(int node) const;
  void add_parameter_slope(int node, double sign, PhaseSlopes& found, int phase) const;

  int n_;
  std::vector<double> parameters_, h_, s_, v_, a_, j_;
  BandMatrix<1> matrix_;
};

}  // namespace wayproof
