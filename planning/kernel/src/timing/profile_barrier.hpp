// ProfileBarrier: the duration of a timing spline with a logarithmic barrier of its limits, as _ProfileProblem of
// planning/retime/jerk/profile_optimizer.py has it, and Newton steps of it.
//
// The accelerations between phases are variables beside the durations, and continuous speed is an equation between
// them: the system of a step has few diagonals, where that of the durations alone is full.
#pragma once

#include <array>
#include <vector>

#include "timing/path_rates.hpp"
#include "timing/timing_spline.hpp"

namespace wayproof {

class ProfileBarrier {
 public:
  // Along a path whose piece under each phase is known by the middle of the phase.
  ProfileBarrier(const PathRates& path, const std::vector<double>& parameters);

  // Takes the path's derivatives where a spline passes its points.
  void move_to(const TimingSpline& spline);
  // Largest rate over limit at all points, by order.
  std::array<double, 3> peaks(const TimingSpline& spline);
  // The barrier, which its weight multiplies; infinite beyond limits.
  double barrier(const TimingSpline& spline);
  // A step of the logarithms of the durations, shape (phases,), and the slope of the cost along it; false if there is
  // none.
  bool newton_step(const TimingSpline& spline, double weight, std::vector<double>& step, double& slope);

  // Limits are imposed at this number of points of every phase: its ends and those that divide it evenly.
  static constexpr int num_points = 4;

  struct State {
    double v, a, j;
  };
  // Gradient and Hessian of the barrier by the state at a point.
  struct StateModel {
    double gradient[3], hessian[3][3];
  };

 private:
  void read_states(const TimingSpline& spline);
  void add_phase(const TimingSpline& spline, int phase, double weight);

  const PathRates& path_;
  int n_;
  std::size_t groups_;
  std::vector<RateFactors> factors_;  // [phases][points][groups]
  std::vector<StateModel> models_;    // [phases][points]
  std::vector<State> states_;         // [phases][points]
  std::vector<std::size_t> pieces_;   // of the path, under phases
  BandMatrix<TimingSpline::half_band> matrix_;
  std::vector<double> right_, gradient_;
};

}  // namespace wayproof
