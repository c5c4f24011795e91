// MotionBounds, to second order: see motion_bounds.hpp.
#include <algorithm>
#include <cmath>
#include <limits>

#include "prover/motion_bounds.hpp"

namespace wayproof {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

}  // namespace

double MotionBounds::remainder(int geometry, int from) {
  reach(geometry, from);
  const auto& axes = chain(geometry);
  const double* arms = &arms_[static_cast<std::size_t>(geometry) * width_];
  double turned = 0, total = 0;
  for (std::size_t i = from; i < axes.size(); ++i) {
    const double sigma = sigmas_[axes[i]];
    if (sigma == 0) continue;
    if (axes_[axes[i]].ball) return inf;
    const bool turns = axes_[axes[i]].turns;
    total += arms[i] * sigma * ((turns ? sigma : 0) + 2 * turned);
    if (turns) turned += sigma;
  }
  return total / 2;
}

// min n . x over the points x of a core; n need not be of unit length. Of half spaces n is the normal.
double MotionBounds::lowest(int geometry, Vec3 n) {
  const Shape& shape = scene_.geometries[geometry].shape;
  const Transform& X_WG = pose(geometry);
  if (shape.kind == ShapeKind::half_space) return dot(n, X_WG.p);
  return dot(n, X_WG * shape.core_support(transposed_times(X_WG.R, -n)));
}

void MotionBounds::linearise(const std::vector<int>& chain, int from, Vec3 n, std::vector<Linear>& out) const {
  out.clear();
  for (std::size_t i = from; i < chain.size(); ++i) {
    const int k = chain[i];
    if (axes_[k].ball || !axes_[k].turns) {
      out.push_back({{}, axes_[k].ball ? 0 : axes_[k].scale * dot(n, directions_[k])});
      continue;
    }
    const Vec3 turn = axes_[k].scale * cross(n, directions_[k]);
    out.push_back({turn, -dot(origins_[k], turn)});
  }
}

double MotionBounds::along(const Pair& pair, const Relative& relative, Vec3 n, double width, double enough) {
  const auto &chain_a = chain(pair.a), &chain_b = chain(pair.b);
  const double rest = remainder(pair.a, relative.a) + remainder(pair.b, relative.b);
  if (!(width - rest >= enough)) return -inf;
  linearise(chain_a, relative.a, n, linear_a_);
  linearise(chain_b, relative.b, n, linear_b_);
  const double blur = residual(pair.a, relative.a, linear_a_) + residual(pair.b, relative.b, linear_b_);
  if (!(width - blur - rest >= enough)) return -inf;
  const double balls = scene_.geometries[pair.a].shape.ball + scene_.geometries[pair.b].shape.ball;
  double least = width;
  for (int row = 0; row < deviation_->num_rows; ++row) {
    const double* d = &deviation_->rows[static_cast<std::size_t>(row) * motion_.num_velocities()];
    const double above = lowest_at(pair.a, relative.a, linear_a_, n, d, 1);
    const double below = lowest_at(pair.b, relative.b, linear_b_, n, d, -1);
    least = std::min(least, above + below - balls);
    if (!(least - blur - rest >= enough)) return -inf;
  }
  return least - blur - rest;
}

// Bound on the displacement of any point of a shape along the direction by the residuals of the deviations.
double MotionBounds::residual(int geometry, int from, const std::vector<Linear>& linear) const {
  const auto& axes = chain(geometry);
  const double radius = scene_.geometries[geometry].shape.core_radius();
  double total = 0;
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const double deviation = deviation_->residual[axes_[axes[from + i]].column], turn = norm(linear[i].turn);
    if (deviation == 0) continue;
    total += deviation * std::abs(linear[i].rate + dot(linear[i].turn, placed_[geometry].center));
    if (turn > 0) total += deviation * turn * radius;
  }
  return total;
}

// min over the points x of a core of sign (n . x + sum_k d_k n . J_k(x)).
double MotionBounds::lowest_at(int geometry, int from, const std::vector<Linear>& linear, Vec3 n, const double* d,
                               double sign) {
  const auto& axes = chain(geometry);
  double rate = 0;
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const double deviation = d[axes_[axes[from + i]].column];
    n = n + deviation * linear[i].turn, rate += deviation * linear[i].rate;
  }
  return lowest(geometry, sign * n) + sign * rate;
}

}  // namespace wayproof
