#include "timing/profile_barrier.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "math/elementary.hpp"
#include "math/multiversion.hpp"

namespace wayproof {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
// Products of 1 - u^2 below this are replaced by their logarithm. Numbers of doubles are less than 1 by 1e-16 or more,
// so that no product of as many as follow underflows.
constexpr double small_product = 1e-150;
constexpr int rates_per_logarithm = 3;

using State = ProfileBarrier::State;

constexpr int num_points = ProfileBarrier::num_points;
constexpr double fractions[num_points] = {0, 1.0 / 3, 2.0 / 3, 1};

[[gnu::always_inline]] inline void rates_of(const RateFactors& f, const State& x, Lanes (&u)[3]) {
  u[0] = f.v * x.v;
  u[1] = f.a * x.a + f.v2 * (x.v * x.v);
  u[2] = f.j * x.j + f.va * (x.v * x.a) + f.v3 * (x.v * x.v * x.v);
}

// The largest rate over limit of each order.
WAYPROOF_MULTIVERSION
void write_peaks(const RateFactors* factors, std::size_t groups, std::span<const State> states, double* peaks) {
  Lanes most[3] = {};
  for (const State& x : states)
    for (std::size_t g = 0; g < groups; ++g) {
      Lanes u[3];
      rates_of(*factors++, x, u);
      for (int order = 0; order < 3; ++order) most[order] = larger_size(most[order], u[order]);
    }
  for (int order = 0; order < 3; ++order) peaks[order] = largest_of(most[order]);
}

[[gnu::always_inline]] inline double logarithms_of(Lanes product) {
  double sum = 0;
  for (std::size_t i = 0; i < num_lanes; ++i) sum += log_of(product[i]);
  return sum;
}

// -log(1 - u^2) of all rates u over limits at every state, infinite beyond limits: factors [states][groups].
WAYPROOF_MULTIVERSION
double barrier_at(const RateFactors* factors, std::size_t groups, std::span<const State> states) {
  Lanes product = Lanes{} + 1, least = product;
  double logarithms = 0;
  int pending = 0;
  for (const State& x : states)
    for (std::size_t g = 0; g < groups; ++g) {
      Lanes u[3];
      rates_of(*factors++, x, u);
      const Lanes p0 = 1 - u[0] * u[0], p1 = 1 - u[1] * u[1], p2 = 1 - u[2] * u[2];
      least = smaller(least, smaller(p0, smaller(p1, p2)));
      product *= p0 * p1 * p2;
      if (++pending < rates_per_logarithm) continue;
      pending = 0;
      if (!(smallest_of(smaller(product, least)) < small_product)) continue;
      if (!(smallest_of(least) > 0)) return inf;
      logarithms += logarithms_of(product);
      product = Lanes{} + 1;
    }
  return smallest_of(least) > 0 ? -(logarithms + logarithms_of(product)) : inf;
}

// The slopes and curvatures of -log(1 - u^2), which have one divisor.
struct Logarithm {
  Lanes slope, curvature;
};

[[gnu::always_inline]] inline Logarithm logarithm_of(Lanes u) {
  const Lanes inverse = 1 / ((1 - u) * (1 + u));
  return {2 * u * inverse, 2 * (1 + u * u) * inverse * inverse};
}

WAYPROOF_MULTIVERSION
void write_models(const RateFactors* factors, std::size_t groups, std::span<const State> states,
                  ProfileBarrier::StateModel* models) {
  for (const State& x : states) {
    Lanes gradient[3] = {}, hessian[6] = {};
    for (std::size_t g = 0; g < groups; ++g) {
      const RateFactors& f = *factors++;
      Lanes u[3];
      rates_of(f, x, u);
      const Logarithm of_v = logarithm_of(u[0]), of_a = logarithm_of(u[1]), of_j = logarithm_of(u[2]);
      // Derivatives of the rates by v, a and j.
      const Lanes av = f.v2 * (2 * x.v), jv = f.va * x.a + f.v3 * (3 * (x.v * x.v)), ja = f.va * x.v;
      gradient[0] += of_v.slope * f.v + of_a.slope * av + of_j.slope * jv;
      gradient[1] += of_a.slope * f.a + of_j.slope * ja;
      gradient[2] += of_j.slope * f.j;
      const Lanes bent_av = of_a.curvature * av, bent_jv = of_j.curvature * jv, bent_jj = of_j.curvature * f.j;
      hessian[0] += of_v.curvature * f.v * f.v + bent_av * av + bent_jv * jv;
      hessian[1] += bent_av * f.a + bent_jv * ja;
      hessian[2] += of_a.curvature * f.a * f.a + of_j.curvature * ja * ja;
      hessian[3] += bent_jj * jv;
      hessian[4] += bent_jj * ja;
      hessian[5] += bent_jj * f.j;
    }
    const double vv = sum_of(hessian[0]), va = sum_of(hessian[1]), aa = sum_of(hessian[2]), vj = sum_of(hessian[3]),
                 aj = sum_of(hessian[4]), jj = sum_of(hessian[5]);
    *models++ = {{sum_of(gradient[0]), sum_of(gradient[1]), sum_of(gradient[2])},
                 {{vv, va, vj}, {va, aa, aj}, {vj, aj, jj}}};
  }
}

}  // namespace

ProfileBarrier::ProfileBarrier(const PathRates& path, const std::vector<double>& parameters)
    : path_(path),
      n_(static_cast<int>(parameters.size()) - 1),
      groups_(path.groups()),
      factors_(num_points * n_ * groups_),
      models_(num_points * static_cast<std::size_t>(n_)),
      states_(num_points * static_cast<std::size_t>(n_)),
      matrix_(3 * n_ - 2),
      right_(3 * n_ - 2),
      gradient_(3 * n_ - 2) {
  for (int k = 0; k < n_; ++k) pieces_.push_back(path.path().locate((parameters[k] + parameters[k + 1]) / 2));
}

void ProfileBarrier::read_states(const TimingSpline& spline) {
  for (int k = 0; k < n_; ++k) {
    const double h = spline.h()[k], v = spline.v()[k], a = spline.a()[k], j = spline.j()[k];
    for (int p = 0; p < num_points; ++p) {
      const double t = fractions[p] * h;
      states_[num_points * k + p] = {v + t * (a + t * j / 2), a + t * j, j};
    }
  }
}

void ProfileBarrier::move_to(const TimingSpline& spline) {
  RateFactors* out = factors_.data();
  for (int k = 0; k < n_; ++k) {
    const double h = spline.h()[k], v = spline.v()[k], a = spline.a()[k], j = spline.j()[k];
    for (int p = 0; p < num_points; ++p, out += groups_) {
      const double t = fractions[p] * h;
      path_.factors(pieces_[k], spline.s()[k] + t * (v + t * (a / 2 + t * j / 6)), out);
    }
  }
}

std::array<double, 3> ProfileBarrier::peaks(const TimingSpline& spline) {
  read_states(spline);
  std::array<double, 3> found;
  write_peaks(factors_.data(), groups_, states_, found.data());
  return found;
}

double ProfileBarrier::barrier(const TimingSpline& spline) {
  if (!spline.is_increasing()) return inf;
  read_states(spline);
  return barrier_at(factors_.data(), groups_, states_);
}

void ProfileBarrier::add_phase(const TimingSpline& spline, int phase, double weight) {
  const PhaseSlopes slopes = spline.slopes(phase);
  const double h = spline.h()[phase], a0 = spline.a()[phase], a1 = spline.a()[phase + 1];
  for (int point = 0; point < num_points; ++point) {
    const StateModel& m = models_[num_points * phase + point];
    // v(t) = v_0 + h (f - f^2 / 2) a_0 + h f^2 / 2 a_1 where t = f h.
    const double f = fractions[point], of_a1 = h * f * f / 2, of_a0 = h * f - of_a1;
    double by[4][3];
    for (int p = 0; p < slopes.count; ++p) {
      const StateSlope& x = slopes.of[p];
      by[p][0] = x.v[0] + of_a0 * x.a[0] + of_a1 * x.a[1];
      if (x.variable == TimingSpline::duration_variable(phase)) by[p][0] += of_a0 * a0 + of_a1 * a1;
      by[p][1] = x.a[0] + f * (x.a[1] - x.a[0]);
      by[p][2] = x.j;
    }
    for (int p = 0; p < slopes.count; ++p) {
      double bent[3] = {0, 0, 0};
      for (int x = 0; x < 3; ++x) {
        gradient_[slopes.of[p].variable] += weight * by[p][x] * m.gradient[x];
        for (int y = 0; y < 3; ++y) bent[y] += by[p][x] * m.hessian[x][y];
      }
      for (int q = 0; q < slopes.count; ++q)
        matrix_.at(slopes.of[p].variable, slopes.of[q].variable) +=
            weight * (bent[0] * by[q][0] + bent[1] * by[q][1] + bent[2] * by[q][2]);
    }
  }
}

bool ProfileBarrier::newton_step(const TimingSpline& spline, double weight, std::vector<double>& step, double& slope) {
  read_states(spline);
  write_models(factors_.data(), groups_, states_, models_.data());
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
