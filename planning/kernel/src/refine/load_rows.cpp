#include "refine/load_rows.hpp"

#include <array>
#include <cmath>
#include <cstddef>

#include "math/vec.hpp"

namespace wayproof {
namespace {

constexpr std::size_t four = weights_per_instant;
// Largest change of a row's sum by a step, in units of its entries: b may grow by half.
constexpr double most_change = 1.5;
// Sums below this share of the bound have no row, as rates have none.
constexpr double least_share = 0.3;
// Cosine and sine of the angle, 0.4, between the normals of tangent planes and the vector itself.
constexpr double cosine = 0.9210609940028851, sine = 0.3894183423086505;
constexpr std::size_t num_normals = 5;

using Normals = std::array<Vec3, num_normals>;

// Outward normals of planes tangent to the unit ball near a vector's direction. The first is along the vector; those
// around it keep a step from moving far along the first plane, where it would leave the ball.
Normals normals_of(const Vec3& vector) {
  const double length = norm(vector);
  const Vec3 direction = length > 0 ? (1 / length) * vector : Vec3{1, 0, 0};
  const double x = std::abs(direction.x), y = std::abs(direction.y), z = std::abs(direction.z);
  const Vec3 axis = x <= y && x <= z ? Vec3{1, 0, 0} : y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  Vec3 side = cross(direction, axis);
  side = (1 / norm(side)) * side;
  const Vec3 second = cross(direction, side);
  Normals normals{direction};
  std::size_t k = 1;
  for (const Vec3& tangent : {side, second, -1 * side, -1 * second}) normals[k++] = cosine * direction + sine * tangent;
  return normals;
}

// Rows of one load as they are made.
struct LoadRowsOf {
  const LoadInstants& at;
  const LoadRatios& load;
  const CurveColumns& columns;
  const std::vector<double>& radii;
  MoreRows rows;
  std::vector<double> parts;  // [dims][4 nq + 2]: derivatives of components by four control points, and by b
  std::vector<double> row;    // the same of one row

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

  // Adds a row if it can bind: the sum of `row` changes `ratio`, which is to stay below the bound.
  void add(std::size_t m, double ratio, double sign) {
    const double least = sign * ratio / load.bound - 1;
    if (!(least > least_share - 1)) return;
    double change = 0;
    for (double x : row) change += std::abs(x);
    if (!(least > -most_change * change / load.bound)) return;
    const std::size_t nq = at.coordinates, points = static_cast<std::size_t>(at.first_point[m]) * nq;
    const auto interval = static_cast<std::size_t>(at.interval[m]);
    for (std::size_t i = 0; i < width(); ++i) {
      const std::int64_t column =
          i < four * nq ? columns.points[points + i] : columns.path_velocity[interval + i - four * nq];
      if (column < 0) continue;
      rows.columns.push_back(column), rows.values.push_back(-sign * row[i] / load.bound);
    }
    rows.starts.push_back(static_cast<std::int64_t>(rows.columns.size()));
    rows.least.push_back(least), rows.price.push_back(load.price);
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

  void ball(std::size_t m, std::size_t ball, bool is_static) {
    const double* value = load.values + (m * load.balls + ball) * load.dims;
    if (!is_static && is_repeated(m, ball)) return;
    if (load.dims == 1 && !(std::abs(value[0]) / load.bound - 1 > least_share - 1)) return;
    for (std::size_t d = 0; d < load.dims; ++d) part(m, ball * load.dims + d, &parts[d * width()]);
    if (load.dims == 1) {
      row = parts;
      add(m, value[0], 1), add(m, value[0], -1);
      return;
    }
    const Vec3 vector{value[0], value[1], value[2]};
    for (const Vec3& n : normals_of(vector)) {
      for (std::size_t i = 0; i < width(); ++i)
        row[i] = n.x * parts[i] + n.y * parts[width() + i] + n.z * parts[2 * width() + i];
      add(m, dot(n, vector), 1);
    }
  }
};

}  // namespace

MoreRows load_rows(const LoadInstants& instants, const LoadRatios& ratios, const CurveColumns& columns,
                   const std::vector<double>& radii, bool is_static) {
  LoadRowsOf of{instants, ratios, columns, radii, {}, {}, {}};
  of.parts.resize(ratios.dims * of.width()), of.row.resize(of.width());
  for (std::size_t m = 0; m < instants.count; ++m)
    for (std::size_t ball = 0; ball < ratios.balls; ++ball) of.ball(m, ball, is_static);
  return of.rows;
}

}  // namespace wayproof
