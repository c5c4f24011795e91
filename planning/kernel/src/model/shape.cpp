#include "model/shape.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <utility>

#include "math/multiversion.hpp"

namespace wayproof {
namespace {

constexpr std::size_t pad = 8;
// Polytopes of more vertices than few_vertices, but of at most most_boxes boxes, have boxes.
constexpr std::size_t few_vertices = 40, most_boxes = 1024;

// A shape as the sum of a polytope, an ellipsoid and a ball.
struct Parts {
  std::vector<Vec3> corners;
  Vec3 axes;
  double ball = 0;
};

std::vector<Vec3> box_corners(Vec3 size) {
  std::vector<Vec3> corners;
  for (double x : {-size.x, size.x})
    for (double y : {-size.y, size.y})
      for (double z : {-size.z, size.z}) corners.push_back({x, y, z});
  return corners;
}

Parts parts_of(ShapeKind kind, Vec3 size, const std::vector<Vec3>& vertices) {
  const std::vector<Vec3> point{{0, 0, 0}}, segment{{0, 0, -size.y}, {0, 0, size.y}};
  switch (kind) {
    case ShapeKind::box: return {box_corners(size), {}, 0};
    case ShapeKind::sphere: return {point, {}, size.x};
    case ShapeKind::cylinder: return {segment, {size.x, size.x, 0}, 0};
    case ShapeKind::capsule: return {segment, {}, size.x};
    case ShapeKind::ellipsoid: return {point, size, 0};
    case ShapeKind::hull: return {vertices, {}, 0};
    case ShapeKind::half_space: return {point, {}, 0};
  }
  throw std::logic_error("a shape of no known kind");
}

// Radius of a sphere about the middle of the corners that contains the shape; the corners' own is given.
double radius_of(ShapeKind kind, double corners, Vec3 axes, double ball) {
  switch (kind) {
    case ShapeKind::cylinder: return std::hypot(corners, axes.x);
    case ShapeKind::half_space: return std::numeric_limits<double>::infinity();
    case ShapeKind::box:
    case ShapeKind::sphere:
    case ShapeKind::capsule:
    case ShapeKind::ellipsoid:
    case ShapeKind::hull: return corners + std::max({axes.x, axes.y, axes.z}) + ball;
  }
  throw std::logic_error("a shape of no known kind");
}

// The index of the vertex farthest along n; of equals, the first one, for any vector width.
WAYPROOF_MULTIVERSION
std::size_t farthest(const double* x, const double* y, const double* z, std::size_t count, Vec3 n) {
  double best[pad];
  std::size_t where[pad];
  for (std::size_t k = 0; k < pad; ++k) {
    best[k] = x[k] * n.x + y[k] * n.y + z[k] * n.z;
    where[k] = k;
  }
  for (std::size_t i = pad; i < count; i += pad)
    for (std::size_t k = 0; k < pad; ++k) {
      const double value = x[i + k] * n.x + y[i + k] * n.y + z[i + k] * n.z;
      const bool better = value > best[k];
      best[k] = better ? value : best[k];
      where[k] = better ? i + k : where[k];
    }
  std::size_t winner = 0;
  for (std::size_t k = 1; k < pad; ++k)
    if (best[k] > best[winner] || (best[k] == best[winner] && where[k] < where[winner])) winner = k;
  return where[winner];
}

// Upper bounds of eight boxes along n, rounding included.
WAYPROOF_MULTIVERSION
void reaches(const std::array<std::vector<double>, 6>& boxes, Vec3 n, std::size_t from, double* reach) {
  const double *cx = &boxes[0][from], *cy = &boxes[1][from], *cz = &boxes[2][from];
  const double *hx = &boxes[3][from], *hy = &boxes[4][from], *hz = &boxes[5][from];
  const double ax = std::abs(n.x), ay = std::abs(n.y), az = std::abs(n.z);
  for (std::size_t k = 0; k < pad; ++k)
    reach[k] = (cx[k] * n.x + cy[k] * n.y + cz[k] * n.z) + (hx[k] * ax + hy[k] * ay + hz[k] * az) * (1 + 1e-9);
}

// The same vertex, or one as far, skipping boxes whose bound is below a vertex of another one.
std::size_t farthest_in_boxes(const Shape& s, Vec3 n) {
  double best = -std::numeric_limits<double>::infinity();
  std::size_t winner = 0;
  const auto search = [&](std::size_t box) {
    for (std::size_t i = box * pad; i < (box + 1) * pad; ++i)
      if (const double value = s.vx[i] * n.x + s.vy[i] * n.y + s.vz[i] * n.z; value > best) best = value, winner = i;
  };
  double reach[most_boxes];
  const std::size_t count = s.vx.size() / pad;
  std::size_t first = 0;
  for (std::size_t i = 0; i < count; i += pad) reaches(s.boxes, n, i, reach + i);
  for (std::size_t i = 1; i < count; ++i)
    if (reach[i] > reach[first]) first = i;
  search(first);
  for (std::size_t i = 0; i < count; ++i)
    if (reach[i] >= best && i != first) search(i);
  return winner;
}

// Sorts points so that any eight in sequence are near each other: halves, along the longer side, of a multiple of
// eight.
void cluster(Vec3* points, std::size_t count) {
  if (count <= pad) return;
  Vec3 low = points[0], high = points[0];
  for (std::size_t i = 1; i < count; ++i) {
    const Vec3 v = points[i];
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
  }
  const Vec3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::stable_sort(points, points + count, [axis](Vec3 a, Vec3 b) { return a[axis] < b[axis]; });
  const std::size_t half = (count / 2 + pad - 1) / pad * pad;
  cluster(points, half);
  cluster(points + half, count - half);
}

}  // namespace

Shape::Shape(ShapeKind kind_, Vec3 size_, const std::vector<Vec3>& vertices, std::vector<std::array<double, 4>> planes_)
    : kind(kind_), size(size_), planes(std::move(planes_)) {
  Parts parts = parts_of(kind, size, vertices);
  auto& corners = parts.corners;
  axes = parts.axes, ball = parts.ball;
  has_few_corners_ = corners.size() <= 2;
  const bool large = corners.size() > few_vertices && corners.size() <= most_boxes * pad;
  if (large) cluster(corners.data(), corners.size());
  Vec3 low = corners[0], high = corners[0];
  for (Vec3 v : corners) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
    vx.push_back(v.x), vy.push_back(v.y), vz.push_back(v.z);
  }
  while (vx.size() % pad) vx.push_back(vx.back()), vy.push_back(vy.back()), vz.push_back(vz.back());
  if (large) make_boxes();
  center = 0.5 * (low + high);
  for (Vec3 v : corners) radius = std::max(radius, norm(v - center));
  radius = radius_of(kind, radius, axes, ball);
}

void Shape::make_boxes() {
  const std::vector<double>* v[3] = {&vx, &vy, &vz};
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < vx.size(); i += pad) {
      const auto [low, high] = std::minmax_element(v[axis]->begin() + i, v[axis]->begin() + i + pad);
      boxes[axis].push_back((*low + *high) / 2);
      boxes[3 + axis].push_back((*high - *low) / 2 + 1e-15 * (std::abs(*low) + std::abs(*high)));
    }
  for (auto& row : boxes) row.resize((row.size() + pad - 1) / pad * pad, 0);
}

Vec3 Shape::core_support(Vec3 n) const {
  if (kind == ShapeKind::box)
    return {n.x > 0 ? size.x : -size.x, n.y > 0 ? size.y : -size.y, n.z > 0 ? size.z : -size.z};
  const std::size_t i = has_few_corners_   ? (n.z * vz[1] > n.z * vz[0] ? 1 : 0)
                        : boxes[0].empty() ? farthest(vx.data(), vy.data(), vz.data(), vx.size(), n)
                                           : farthest_in_boxes(*this, n);
  const Vec3 vertex{vx[i], vy[i], vz[i]};
  const Vec3 stretched{axes.x * n.x, axes.y * n.y, axes.z * n.z};
  const double length = norm(stretched);
  if (length == 0) return vertex;
  const double s = 1 / length;
  return vertex + Vec3{s * axes.x * stretched.x, s * axes.y * stretched.y, s * axes.z * stretched.z};
}

}  // namespace wayproof
