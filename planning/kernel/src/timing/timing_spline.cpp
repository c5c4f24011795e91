#include "timing/timing_spline.hpp"

#include <utility>

namespace wayproof {

TimingSpline::TimingSpline(std::vector<double> parameters)
    : n_(static_cast<int>(parameters.size()) - 1),
      parameters_(std::move(parameters)),
      h_(n_),
      s_(n_ + 1),
      v_(n_ + 1),
      a_(n_ + 1),
      j_(n_),
      matrix_(n_ - 1) {}

double TimingSpline::factor(int node) const {
  if (node == 1) return h_[0] * h_[0] / 6;
  if (node == n_ - 1) return h_[n_ - 1] * h_[n_ - 1] / 6;
  return 0;
}

bool TimingSpline::set_durations(const std::vector<double>& h) {
  h_ = h, s_ = parameters_;
  s_[1] = s_[0], s_[n_ - 1] = s_[n_];
  matrix_.clear();
  std::vector<double> x(n_ - 1);
  for (int i = 1; i < n_; ++i) {
    const double before = h_[i - 1], after = h_[i];
    matrix_.at(i - 1, i - 1) = (before + after) / 3 + factor(i) * (1 / before + 1 / after);
    if (i > 1) matrix_.at(i - 1, i - 2) = before / 6 - factor(i - 1) / before;
    if (i < n_ - 1) matrix_.at(i - 1, i) = after / 6 - factor(i + 1) / after;
    x[i - 1] = (s_[i + 1] - s_[i]) / after - (s_[i] - s_[i - 1]) / before;
  }
  if (!matrix_.solve(x)) return false;
  a_[0] = a_[n_] = 0;
  for (int i = 1; i < n_; ++i) a_[i] = x[i - 1];
  s_[1] += factor(1) * a_[1], s_[n_ - 1] += factor(n_ - 1) * a_[n_ - 1];
  for (int k = 0; k < n_; ++k) {
    v_[k] = (s_[k + 1] - s_[k]) / h_[k] - h_[k] * (2 * a_[k] + a_[k + 1]) / 6;
    j_[k] = (a_[k + 1] - a_[k]) / h_[k];
  }
  v_[0] = v_[n_] = 0;
  return true;
}

bool TimingSpline::is_increasing() const {
  for (int k = 0; k < n_; ++k)
    if (!(s_[k + 1] > s_[k]) || (k > 0 && !(v_[k] > 0))) return false;
  return true;
}

SpeedProfile TimingSpline::profile() const {
  return {s_, {v_.begin(), v_.end() - 1}, {a_.begin(), a_.end() - 1}, j_, h_};
}

// Adds what a parameter at an end of the phase contributes, if a rest fixes it: s_i by a_i and by log h.
void TimingSpline::add_parameter_slope(int node, double sign, PhaseSlopes& found, int phase) const {
  if (node != 1 && node != n_ - 1) return;
  const double rate = sign / h_[phase];
  const auto add = [&](int variable, double slope) {
    int i = 0;
    while (i < found.count && found.of[i].variable != variable) ++i;
    if (i == found.count) found.of[found.count++] = {variable, {0, 0}, {0, 0}, 0};
    for (double& v : found.of[i].v) v += rate * slope;
  };
  add(acceleration_variable(node), factor(node));
  add(duration_variable(node == 1 ? 0 : n_ - 1), 2 * factor(node) * a_[node]);
}

PhaseSlopes TimingSpline::slopes(int phase) const {
  const double h = h_[phase], a0 = a_[phase], a1 = a_[phase + 1], mean = (s_[phase + 1] - s_[phase]) / h;
  PhaseSlopes found;
  found.of[found.count++] = {duration_variable(phase),
                             {-mean - h * (2 * a0 + a1) / 6, -mean + h * (a0 + 2 * a1) / 6},
                             {0, 0},
                             -j_[phase]};
  if (phase > 0) found.of[found.count++] = {acceleration_variable(phase), {-h / 3, h / 6}, {1, 0}, -1 / h};
  if (phase < n_ - 1) found.of[found.count++] = {acceleration_variable(phase + 1), {-h / 6, h / 3}, {0, 1}, 1 / h};
  add_parameter_slope(phase, -1, found, phase);
  add_parameter_slope(phase + 1, 1, found, phase);
  return found;
}

void TimingSpline::add_continuity(int node, BandMatrix<half_band>& matrix) const {
  const int row = multiplier(node);
  const auto add = [&](int variable, double slope) {
    matrix.at(row, variable) += slope;
    matrix.at(variable, row) += slope;
  };
  const PhaseSlopes before = slopes(node - 1), after = slopes(node);
  for (int i = 0; i < before.count; ++i) add(before.of[i].variable, before.of[i].v[1]);
  for (int i = 0; i < after.count; ++i) add(after.of[i].variable, -after.of[i].v[0]);
}

}  // namespace wayproof
