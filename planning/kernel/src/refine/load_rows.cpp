#include "refine/load_rows.hpp"

#include <cmath>
#include <cstddef>

namespace wayproof {
namespace {

constexpr std::size_t four = weights_per_instant;
// Largest change of a row's sum by a step, in units of its entries: b may grow by half.
constexpr double most_change = 1.5;
// Sums below this share of the bound have no row, as rates have none.
constexpr double least_share = 0.3;
// Rows of one load as they are made.
struct LoadRowsOf {
  const LoadInstants& at;
  const LoadRatios& load;
  const CurveColumns& columns;
  const std::vector<double>& radii;
  MoreRows rows;
  std::vector<double> parts;  // [dims][4 nq + 2]: derivatives of components by four control points, and by b
  std::size_t width() const { return four * at.coordinates + 2; }

  // Derivatives of a component by control points in units of the box, and by b at both ends in units of itself.
  void part(std::size_t m, std::size_t component, double* to) const {
    const std::size_t nq = at.coordinates, offset = (m * load.balls * load.dims + component) * nq;
    const double *by_q = load.derivatives[0] + offset, *by_v = load.derivatives[1] + offset;
    const double *by_vdot = load.derivatives[2] + offset, *rate = at.rate + m * nq, *curvature = at.curvature + m * nq;
    const double low = at.ends[2 * m], high = at.ends[2 * m + 1], fraction = at.fractions[m];
    const double b = (1 - fraction) * low + fraction * high, root = std::sqrt(b), u = (high - low) / (2 * at.step);
    double by_b = 0, by_u = 0;
    for (std::size_t j = 0; j < nq; ++j) {
      const double first = root * by_v[j] + u * by_vdot[j], second = b * by_vdot[j];
      for (std::size_t p = 0; p < four; ++p) {
        const std::size_t w = m * four + p;
        const double by_point = at.weights[0][w] * by_q[j] + at.weights[1][w] * first + at.weights[2][w] * second;
        to[p * nq + j] = by_point * radii[j];
      }
      by_b += by_v[j] * rate[j] * root / 2 + by_vdot[j] * curvature[j] * b;
      by_u += by_vdot[j] * rate[j];
    }
    const double share = b > 0 ? 1 / b : 1;
    to[four * nq] = -by_u * low / (2 * at.step) + by_b * low * (1 - fraction) * share;
    to[four * nq + 1] = by_u * high / (2 * at.step) + by_b * high * fraction * share;
  }

  // The column of a derivative; -1 for none.
  std::int64_t column_of(std::size_t m, std::size_t i) const {
    const std::size_t nq = at.coordinates, points = static_cast<std::size_t>(at.first_point[m]) * nq;
    return i < four * nq ? columns.points[points + i]
                         : columns.path_velocity[static_cast<std::size_t>(at.interval[m]) + i - four * nq];
  }

  // Adds a row if it can bind: the sum of `parts` changes `ratio`, which is to stay below the bound.
  void add(std::size_t m, double ratio, double sign) {
    const double least = sign * ratio / load.bound - 1;
    if (!(least > least_share - 1)) return;
    double change = 0;
    for (double x : parts) change += std::abs(x);
    if (!(least > -most_change * change / load.bound)) return;
    for (std::size_t i = 0; i < width(); ++i)
      if (const std::int64_t column = column_of(m, i); column >= 0)
        rows.columns.push_back(column), rows.values.push_back(-sign * parts[i] / load.bound);
    rows.starts.push_back(static_cast<std::int64_t>(rows.columns.size()));
    rows.least.push_back(least), rows.price.push_back(load.price);
  }

  // Adds a ball for the vector, of length `load.bound` at most.
  void add_ball(std::size_t m, const double* vector) {
    BallRows& balls = rows.balls;
    for (std::size_t d = 0; d < load.dims; ++d) {
      balls.centers.push_back(vector[d] / load.bound);
      for (std::size_t i = 0; i < width(); ++i)
        if (const std::int64_t column = column_of(m, i); column >= 0) {
          if (d == 0) balls.columns.push_back(column);
          balls.values.push_back(parts[d * width() + i] / load.bound);
        }
    }
    balls.starts.push_back(static_cast<std::int64_t>(balls.columns.size()));
    rows.ball_price.push_back(load.price);
  }

  // Rows that do not depend on u are equal on both sides of a grid point: those of its right side are enough.
  bool is_repeated(std::size_t m, std::size_t ball) const {
    if (at.fractions[m] < 1) return false;
    const std::size_t count = load.dims * at.coordinates;
    const double* by_vdot = load.derivatives[2] + (m * load.balls + ball) * count;
    for (std::size_t i = 0; i < count; ++i)
      if (by_vdot[i] != 0) return false;
    return true;
  }

  void ball(std::size_t m, std::size_t ball, bool is_static, bool is_one_sided) {
    const double* value = load.values + (m * load.balls + ball) * load.dims;
    if (!is_static && is_repeated(m, ball)) return;
    if (load.dims == 1 && !(std::abs(value[0]) / load.bound - 1 > least_share - 1)) return;
    for (std::size_t d = 0; d < load.dims; ++d) part(m, ball * load.dims + d, &parts[d * width()]);
    if (load.dims == 1) {
      add(m, value[0], 1);
      if (!is_one_sided) add(m, value[0], -1);
      return;
    }
    add_ball(m, value);
  }
};

}  // namespace

MoreRows load_rows(const LoadInstants& instants, const LoadRatios& ratios, const CurveColumns& columns,
                   const std::vector<double>& radii, bool is_static, bool is_one_sided) {
  LoadRowsOf of{instants, ratios, columns, radii, {}, {}};
  of.parts.resize(ratios.dims * of.width());
  for (std::size_t m = 0; m < instants.count; ++m)
    for (std::size_t ball = 0; ball < ratios.balls; ++ball) of.ball(m, ball, is_static, is_one_sided);
  return of.rows;
}

}  // namespace wayproof
