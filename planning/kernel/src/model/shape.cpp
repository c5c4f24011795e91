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
// Polytopes of more vertices have a table.
constexpr std::size_t few_vertices = 16;

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

}  // namespace

Shape::Shape(ShapeKind kind_, Vec3 size_, const std::vector<Vec3>& vertices, std::vector<std::array<double, 4>> planes_)
    : kind(kind_), size(size_), planes(std::move(planes_)) {
  Parts parts = parts_of(kind, size, vertices);
  auto& corners = parts.corners;
  axes = parts.axes, ball = parts.ball;
  has_few_corners_ = corners.size() <= 2;
  const bool is_large = corners.size() > few_vertices;
  if (is_large) table = std::make_shared<const SupportTable>(corners);
  Vec3 low = corners[0], high = corners[0];
  for (Vec3 v : corners) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
    if (!is_large) vx.push_back(v.x), vy.push_back(v.y), vz.push_back(v.z);
  }
  while (vx.size() % pad) vx.push_back(vx.back()), vy.push_back(vy.back()), vz.push_back(vz.back());
  center = 0.5 * (low + high);
  for (Vec3 v : corners) radius = std::max(radius, norm(v - center));
  radius = radius_of(kind, radius, axes, ball);
}

Vec3 Shape::core_support(Vec3 n) const {
  if (kind == ShapeKind::box)
    return {n.x > 0 ? size.x : -size.x, n.y > 0 ? size.y : -size.y, n.z > 0 ? size.z : -size.z};
  if (table) return table->farthest(n);
  const std::size_t i =
      has_few_corners_ ? (n.z * vz[1] > n.z * vz[0] ? 1 : 0) : farthest(vx.data(), vy.data(), vz.data(), vx.size(), n);
  const Vec3 vertex{vx[i], vy[i], vz[i]};
  const Vec3 stretched{axes.x * n.x, axes.y * n.y, axes.z * n.z};
  const double length = norm(stretched);
  if (length == 0) return vertex;
  const double s = 1 / length;
  return vertex + Vec3{s * axes.x * stretched.x, s * axes.y * stretched.y, s * axes.z * stretched.z};
}

}  // namespace wayproof
