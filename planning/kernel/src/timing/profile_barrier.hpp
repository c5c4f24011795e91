// ProfileBarrier: the duration of a timing spline with a logarithmic barrier of its limits, as _ProfileProblem of
// planning/retime/jerk/profile_optimizer.py has it, and Newton steps of it.
//
// The accelerations between phases are variables beside the durations, and continuous speed is an equation between
// them: the system of a step has few diagonals, where that of the durations alone is full.
#pragma once

#include <vector>

#include "timing/speed_profile.hpp"
#include "timing/timing_spline.hpp"

namespace wayproof {

class ProfileBarrier {
 public:
  // Along a path whose piece under each phase is known by the middle of the phase.
  ProfileBarrier(const PolynomialPath& path, const std::vector<double>& parameters, const RateLimits& limits);

  // Divisors of the limits on every phase, [3][phases].
  std::vector<double> tightening;

  // Largest rate over limit at the ends of phases by order and phase, [3][phases].
  std::vector<double> utilizations(const TimingSpline& spline) const;
  // The duration plus the barrier; infinite beyond limits.
  double cost(const TimingSpline& spline, double weight) const;
  // A step of the logarithms of the durations, shape (phases,), and the slope of the cost along it; false if there is
  // none.
  bool newton_step(const TimingSpline& spline, double weight, std::vector<double>& step, double& slope);

 private:
  // Gradient and Hessian of the barrier by (v, a, j) at an end of a phase.
  struct StateModel {
    double gradient[3] = {0, 0, 0}, hessian[3][3] = {};
  };
  const double* rates(int order, int end, int phase) const;
  StateModel model(const TimingSpline& spline, int phase, int end) const;
  void add_phase(const TimingSpline& spline, int phase, double weight);

  int n_;
  std::size_t joints_;
  std::vector<double> geometry_;  // r', r'', r''' at both ends of phases, [3][2][phases][joints]
  std::vector<double> inverse_limits_;
  BandMatrix matrix_;
  std::vector<double> right_, gradient_;
};

}  // namespace wayproof
