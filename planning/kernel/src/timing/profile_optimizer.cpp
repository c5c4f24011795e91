#include "timing/profile_optimizer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "math/elementary.hpp"
#include "timing/path_rates.hpp"
#include "timing/phase_peaks.hpp"
#include "timing/profile_barrier.hpp"
#include "timing/timing_spline.hpp"

namespace wayproof {
namespace {

// As in profile_optimizer.py.
struct Round {
  int num_steps;
  double utilization, weight;
};
constexpr Round rounds[] = {{8, 0.97, 0.1}, {4, 0.995, 5e-4}};
constexpr double barrier_factor = 0.5;
constexpr double max_step = 0.3;
constexpr double armijo_factor = 0.01;
// The shortest is 2^-9.
constexpr int num_step_lengths = 10;

double sum(const std::vector<double>& numbers) {
  double total = 0;
  for (double x : numbers) total += x;
  return total;
}

// The factor by which time must be scaled for the largest rates over limits.
double time_scaling(const std::array<double, 3>& peaks) {
  return std::max({peaks[0], std::sqrt(peaks[1]), peaks[2] > 0 ? cube_root(peaks[2]) : 0});
}

// The profile slowed or sped up until it meets a limit.
SpeedProfile scaled(const PathRates& path, SpeedProfile profile) {
  const double factor = time_scaling(phase_peaks(path, profile));
  for (double& v : profile.v) v /= factor;
  for (double& a : profile.a) a /= factor * factor;
  for (double& j : profile.j) j /= factor * factor * factor;
  for (double& h : profile.h) h *= factor;
  return profile;
}

// Durations, and what their cost consists of.
struct Iterate {
  std::vector<double> h;
  double duration, barrier;

  double cost(double weight) const { return duration + weight * barrier; }
};

// Steps along logarithms of durations, with backtracking; false where no step lowers the cost.
bool line_search(ProfileBarrier& barrier, TimingSpline& spline, Iterate& now, double weight,
                 const std::vector<double>& step, double slope) {
  Iterate trial = now;
  double length = 1;
  for (int halvings = 0; halvings < num_step_lengths; ++halvings, length /= 2) {
    for (std::size_t k = 0; k < step.size(); ++k) trial.h[k] = now.h[k] * exp_of_small(length * step[k]);
    if (!spline.set_durations(trial.h)) continue;
    trial.duration = sum(trial.h), trial.barrier = barrier.barrier(spline);
    if (trial.cost(weight) <= now.cost(weight) + armijo_factor * length * slope) {
      now = std::move(trial);
      return true;
    }
  }
  spline.set_durations(now.h);
  return false;
}

// Newton steps under a falling barrier; false if the spline stops, or has no step.
bool optimize_durations(ProfileBarrier& barrier, TimingSpline& spline, std::vector<double>& h, const Round& round) {
  if (!spline.set_durations(h) || !spline.is_increasing()) return false;
  barrier.move_to(spline);
  const double scale = time_scaling(barrier.peaks(spline)) / round.utilization;
  for (double& x : h) x *= scale;
  if (!spline.set_durations(h)) return false;
  Iterate now{h, sum(h), barrier.barrier(spline)};
  double weight = round.weight * now.duration / static_cast<double>(h.size());
  std::vector<double> step(h.size());
  for (int i = 0; i < round.num_steps; ++i, weight *= barrier_factor) {
    double slope = 0;
    if (!barrier.newton_step(spline, weight, step, slope)) return false;
    double longest = max_step;
    for (double x : step) longest = std::max(longest, std::abs(x));
    for (double& x : step) x *= max_step / longest;
    line_search(barrier, spline, now, weight, step, slope * max_step / longest);
  }
  h = std::move(now.h);
  return true;
}

}  // namespace

SpeedProfile optimize_profile(const PolynomialPath& path, const SpeedProfile& profile, const std::vector<double>& h,
                              const std::vector<double>& parameters, const RateLimits& limits) {
  const PathRates rates(path, limits);
  SpeedProfile best = scaled(rates, profile);
  ProfileBarrier barrier(rates, parameters);
  TimingSpline spline(parameters);
  std::vector<double> durations = h;
  for (const Round& round : rounds) {
    if (!optimize_durations(barrier, spline, durations, round)) break;
    SpeedProfile found = scaled(rates, spline.profile());
    if (found.duration() < best.duration()) best = std::move(found);
  }
  return best;
}

}  // namespace wayproof
