#include "timing/profile_optimizer.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "math/elementary.hpp"
#include "timing/phase_peaks.hpp"
#include "timing/profile_barrier.hpp"
#include "timing/timing_spline.hpp"

namespace wayproof {
namespace {

// As in profile_optimizer.py.
constexpr int num_rounds = 6, num_steps = 8;
constexpr double initial_utilization = 0.97;
constexpr double barrier_weight = 0.1, barrier_factor = 0.5;
constexpr double max_step = 0.3;
constexpr double armijo_factor = 0.01, min_step_length = 1e-3;
constexpr double max_tightening = 2.0, min_utilization = 0.3;

double root(double x, int order) { return order == 0 ? x : order == 1 ? std::sqrt(x) : std::cbrt(x); }

double sum(const std::vector<double>& numbers) {
  double total = 0;
  for (double x : numbers) total += x;
  return total;
}

// Largest root of what is used of the limits, [3][phases]: the factor by which time must be scaled.
double time_scaling(const std::vector<double>& utilizations) {
  const auto n = static_cast<std::ptrdiff_t>(utilizations.size() / 3);
  double largest = 0;
  for (int order = 0; order < 3; ++order) {
    const auto begin = utilizations.begin() + order * n;
    largest = std::max(largest, root(*std::max_element(begin, begin + n), order));
  }
  return largest;
}

// Slows or speeds the profile up until it meets a limit; returns the factor, and scales the peaks with it.
double scale_to_limits(const PolynomialPath& path, const RateLimits& limits, SpeedProfile& profile,
                       std::vector<double>& peaks) {
  peaks = phase_peaks(path, profile, limits);
  const double factor = time_scaling(peaks);
  const std::size_t n = profile.h.size();
  double power = 1;
  for (std::size_t order = 0; order < 3; ++order) {
    power *= factor;
    std::vector<double>& rate = order == 0 ? profile.v : order == 1 ? profile.a : profile.j;
    for (std::size_t k = 0; k < n; ++k) rate[k] /= power, peaks[order * n + k] /= power;
  }
  for (double& h : profile.h) h *= factor;
  return factor;
}

// Durations after a backtracking line search along a step of their logarithms.
void line_search(const ProfileBarrier& barrier, TimingSpline& spline, std::vector<double>& h, double weight,
                 const std::vector<double>& step, double slope) {
  const double initial = barrier.cost(spline, weight);
  std::vector<double> trial(h.size());
  double length = 1;
  while (length > min_step_length) {
    for (std::size_t k = 0; k < h.size(); ++k) trial[k] = h[k] * exp_of_small(length * step[k]);
    if (spline.set_durations(trial) && barrier.cost(spline, weight) <= initial + armijo_factor * length * slope) {
      h = std::move(trial);
      return;
    }
    length /= 2;
  }
  spline.set_durations(h);
}

// Newton steps under a falling barrier; false if the spline stops, or has no step.
bool optimize_durations(ProfileBarrier& barrier, TimingSpline& spline, std::vector<double>& h) {
  if (!spline.set_durations(h) || !spline.is_increasing()) return false;
  std::vector<double> used = barrier.utilizations(spline);
  for (std::size_t i = 0; i < used.size(); ++i) used[i] *= barrier.tightening[i];
  const double scale = time_scaling(used) / initial_utilization;
  for (double& x : h) x *= scale;
  double weight = barrier_weight * sum(h) / static_cast<double>(h.size());
  std::vector<double> step(h.size());
  for (int i = 0; i < num_steps; ++i, weight *= barrier_factor) {
    double slope = 0;
    if (!spline.set_durations(h) || !barrier.newton_step(spline, weight, step, slope)) return false;
    double longest = max_step;
    for (double x : step) longest = std::max(longest, std::abs(x));
    for (double& x : step) x *= max_step / longest;
    line_search(barrier, spline, h, weight, step, slope * max_step / longest);
  }
  return spline.set_durations(h);
}

// Divisors of the limits for another round, where they are exceeded within phases.
void tighten(ProfileBarrier& barrier, const TimingSpline& spline, double scaling, const std::vector<double>& peaks) {
  const std::vector<double> at_ends = barrier.utilizations(spline);
  const std::size_t n = peaks.size() / 3;
  double power = 1;
  for (std::size_t order = 0; order < 3; ++order) {
    power *= scaling;
    for (std::size_t k = order * n; k < (order + 1) * n; ++k)
      barrier.tightening[k] = std::clamp(peaks[k] / std::max(at_ends[k] / power, min_utilization), 1.0, max_tightening);
  }
}

}  // namespace

SpeedProfile optimize_profile(const PolynomialPath& path, const SpeedProfile& profile, const std::vector<double>& h,
                              const std::vector<double>& parameters, const RateLimits& limits) {
  std::vector<double> peaks;
  SpeedProfile best = profile;
  scale_to_limits(path, limits, best, peaks);
  ProfileBarrier barrier(path, parameters, limits);
  TimingSpline spline(parameters);
  std::vector<double> durations = h;
  for (int round = 0; round < num_rounds; ++round) {
    if (!optimize_durations(barrier, spline, durations)) break;
    SpeedProfile scaled = spline.profile();
    const double scaling = scale_to_limits(path, limits, scaled, peaks);
    tighten(barrier, spline, scaling, peaks);
    durations = scaled.h;
    if (scaled.duration() < best.duration()) best = std::move(scaled);
  }
  return best;
}

}  // namespace wayproof
