#include "timing/profile_barrier.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/elementary.hpp"

namespace wayproof {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
// Products of 1 - u^2 below this are replaced by their logarithm.
constexpr double small_product = 1e-100;

// The order-th derivative of one joint's polynomial with some terms, `stride` apart.
double derivative_at(const double* coefficients, std::size_t terms, std::size_t stride, int order, double x) {
  double sum = 0;
  for (auto k = static_cast<int>(terms) - 1; k >= order; --k) {
    double factor = 1;
    for (int i = 0; i < order; ++i) factor *= k - i;
    sum = sum * x + factor * coefficients[k * stride];
  }
  return sum;
}

}  // namespace

ProfileBarrier::ProfileBarrier(const PolynomialPath& path, const std::vector<double>& parameters,
                               const RateLimits& limits)
    : n_(static_cast<int>(parameters.size()) - 1),
      joints_(path.joints),
      geometry_(3 * 2 * n_ * joints_),
      inverse_limits_(limits.size()),
      matrix_(3 * n_ - 2, TimingSpline::half_band),
      right_(3 * n_ - 2),
      gradient_(3 * n_ - 2) {
  tightening.assign(3 * static_cast<std::size_t>(n_), 1.0);
  for (std::size_t i = 0; i < limits.size(); ++i) inverse_limits_[i] = 1 / limits[i];
  double* out = geometry_.data();
  for (int order = 1; order <= 3; ++order)
    for (int end = 0; end < 2; ++end)
      for (int k = 0; k < n_; ++k) {
        const std::size_t piece = path.locate((parameters[k] + parameters[k + 1]) / 2);
        const double x = parameters[k + end] - path.breaks[piece];
        for (std::size_t i = 0; i < joints_; ++i)
          *out++ = derivative_at(path.piece(piece) + i, path.terms, joints_, order, x);
      }
}

const double* ProfileBarrier::rates(int order, int end, int phase) const {
  return &geometry_[((static_cast<std::size_t>(order - 1) * 2 + end) * n_ + phase) * joints_];
}

std::vector<double> ProfileBarrier::utilizations(const TimingSpline& spline) const {
  std::vector<double> found(3 * static_cast<std::size_t>(n_));
  const double *velocity = inverse_limits_.data(), *acceleration = velocity + joints_, *jerk = acceleration + joints_;
  for (int k = 0; k < n_; ++k) {
    double worst[3] = {0, 0, 0};
    for (int end = 0; end < 2; ++end) {
      const double *r1 = rates(1, end, k), *r2 = rates(2, end, k), *r3 = rates(3, end, k);
      const double v = spline.v()[k + end], a = spline.a()[k + end], j = spline.j()[k];
      for (std::size_t i = 0; i < joints_; ++i) {
        worst[0] = std::max(worst[0], std::abs(r1[i] * v * velocity[i]));
        worst[1] = std::max(worst[1], std::abs((r1[i] * a + r2[i] * v * v) * acceleration[i]));
        worst[2] = std::max(worst[2], std::abs((r1[i] * j + 3 * r2[i] * v * a + r3[i] * v * v * v) * jerk[i]));
      }
    }
    for (int order = 0; order < 3; ++order) found[static_cast<std::size_t>(order) * n_ + k] = worst[order];
  }
  return found;
}

double ProfileBarrier::cost(const TimingSpline& spline, double weight) const {
  if (!spline.is_increasing()) return inf;
  const double *velocity = inverse_limits_.data(), *acceleration = velocity + joints_, *jerk = acceleration + joints_;
  double logarithms = 0, product = 1, duration = 0;
  for (int k = 0; k < n_; ++k) {
    duration += spline.h()[k];
    for (int end = 0; end < 2; ++end) {
      const double *r1 = rates(1, end, k), *r2 = rates(2, end, k), *r3 = rates(3, end, k);
      const double v = spline.v()[k + end], a = spline.a()[k + end], j = spline.j()[k];
      const double va = 3 * v * a, v2 = v * v, v3 = v * v * v;
      const double t1 = tightening[k], t2 = tightening[n_ + k], t3 = tightening[2 * n_ + k];
      for (std::size_t i = 0; i < joints_; ++i) {
        const double u1 = t1 * velocity[i] * (r1[i] * v), u2 = t2 * acceleration[i] * (r1[i] * a + r2[i] * v2),
                     u3 = t3 * jerk[i] * (r1[i] * j + r2[i] * va + r3[i] * v3);
        const double spare = std::min({1 - u1 * u1, 1 - u2 * u2, 1 - u3 * u3});
        if (!(spare > 0)) return inf;
        product *= (1 - u1 * u1) * (1 - u2 * u2) * (1 - u3 * u3);
        if (product < small_product) logarithms += log_of(product), product = 1;
      }
    }
  }
  return duration - weight * (logarithms + log_of(product));
}

ProfileBarrier::StateModel ProfileBarrier::model(const TimingSpline& spline, int phase, int end) const {
  StateModel found;
  const double *velocity = inverse_limits_.data(), *acceleration = velocity + joints_, *jerk = acceleration + joints_;
  const double *r1 = rates(1, end, phase), *r2 = rates(2, end, phase), *r3 = rates(3, end, phase);
  const double v = spline.v()[phase + end], a = spline.a()[phase + end], j = spline.j()[phase];
  const double t1 = tightening[phase], t2 = tightening[n_ + phase], t3 = tightening[2 * n_ + phase];
  // -log(1 - u^2): its slope and its curvature have one divisor. The other slopes of u are zero.
  const auto add = [&]<std::size_t count>(double u, const double (&by)[count]) {
    const double inverse = 1 / ((1 - u) * (1 + u)), slope = 2 * u * inverse,
                 curvature = 2 * (1 + u * u) * inverse * inverse;
    for (std::size_t p = 0; p < count; ++p) {
      found.gradient[p] += slope * by[p];
      for (std::size_t q = 0; q <= p; ++q) found.hessian[p][q] += curvature * by[p] * by[q];
    }
  };
  for (std::size_t i = 0; i < joints_; ++i) {
    const double w1 = t1 * velocity[i], w2 = t2 * acceleration[i], w3 = t3 * jerk[i];
    add(w1 * (r1[i] * v), {w1 * r1[i]});
    add(w2 * (r1[i] * a + r2[i] * v * v), {w2 * 2 * r2[i] * v, w2 * r1[i]});
    add(w3 * (r1[i] * j + 3 * r2[i] * v * a + r3[i] * v * v * v),
        {w3 * (3 * r2[i] * a + 3 * r3[i] * v * v), w3 * 3 * r2[i] * v, w3 * r1[i]});
  }
  for (int p = 0; p < 3; ++p)
    for (int q = p + 1; q < 3; ++q) found.hessian[p][q] = found.hessian[q][p];
  return found;
}

void ProfileBarrier::add_phase(const TimingSpline& spline, int phase, double weight) {
  const PhaseSlopes slopes = spline.slopes(phase);
  for (int end = 0; end < 2; ++end) {
    const StateModel m = model(spline, phase, end);
    for (int p = 0; p < slopes.count; ++p) {
      const double by[3] = {slopes.of[p].v[end], slopes.of[p].a[end], slopes.of[p].j};
      double bent[3] = {0, 0, 0};
      for (int x = 0; x < 3; ++x) {
        gradient_[slopes.of[p].variable] += weight * by[x] * m.gradient[x];
        for (int y = 0; y < 3; ++y) bent[y] += by[x] * m.hessian[x][y];
      }
      for (int q = 0; q < slopes.count; ++q)
        matrix_.at(slopes.of[p].variable, slopes.of[q].variable) +=
            weight * (bent[0] * slopes.of[q].v[end] + bent[1] * slopes.of[q].a[end] + bent[2] * slopes.of[q].j);
    }
  }
}

bool ProfileBarrier::newton_step(const TimingSpline& spline, double weight, std::vector<double>& step, double& slope) {
  matrix_.clear();
  std::fill(gradient_.begin(), gradient_.end(), 0.0);
  for (int k = 0; k < n_; ++k) {
    const int variable = TimingSpline::duration_variable(k);
    gradient_[variable] += spline.h()[k];
    matrix_.at(variable, variable) += spline.h()[k];
    add_phase(spline, k, weight);
  }
  for (int node = 1; node < n_; ++node) spline.add_continuity(node, matrix_);
  for (std::size_t i = 0; i < right_.size(); ++i) right_[i] = -gradient_[i];
  if (!matrix_.solve(right_)) return false;
  slope = 0;
  for (std::size_t i = 0; i < right_.size(); ++i) slope += gradient_[i] * right_[i];
  for (int k = 0; k < n_; ++k) step[k] = right_[TimingSpline::duration_variable(k)];
  return true;
}

}  // namespace wayproof
