#include "shape.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "multiversion.hpp"

namespace wayproof {
namespace {

constexpr std::size_t pad = 8;

std::vector<Vec3> polytope(ShapeKind kind, Vec3 size, const std::vector<Vec3>& vertices) {
  switch (kind) {
    case ShapeKind::box: {
      std::vector<Vec3> corners;
      for (double x : {-size.x, size.x})
        for (double y : {-size.y, size.y})
          for (double z : {-size.z, size.z}) corners.push_back({x, y, z});
      return corners;
    }
    case ShapeKind::cylinder:
    case ShapeKind::capsule: return {{0, 0, -size.y}, {0, 0, size.y}};
    case ShapeKind::hull: return vertices;
    default: return {{0, 0, 0}};
  }
}

// The index of the vertex farthest along n; of equals, the first one, whatever the vector width.
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

Shape::Shape(ShapeKind kind_, Vec3 size_, const std::vector<Vec3>& vertices,
             std::vector<std::array<double, 4>> planes_)
    : kind(kind_), size(size_), planes(std::move(planes_)) {
  const auto corners = polytope(kind, size, vertices);
  Vec3 low = corners[0], high = corners[0];
  for (Vec3 v : corners) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
    vx.push_back(v.x), vy.push_back(v.y), vz.push_back(v.z);
  }
  while (vx.size() % pad) vx.push_back(vx[0]), vy.push_back(vy[0]), vz.push_back(vz[0]);
  if (kind == ShapeKind::cylinder) axes = {size.x, size.x, 0};
  if (kind == ShapeKind::ellipsoid) axes = size;
  if (kind == ShapeKind::sphere || kind == ShapeKind::capsule) ball = size.x;
  center = 0.5 * (low + high);
  for (Vec3 v : corners) radius = std::max(radius, norm(v - center));
  radius = kind == ShapeKind::cylinder ? std::hypot(radius, size.x)
                                       : radius + std::max({axes.x, axes.y, axes.z}) + ball;
  if (kind == ShapeKind::half_space) radius = std::numeric_limits<double>::infinity();
}

Vec3 Shape::core_support(Vec3 n) const {
  const std::size_t i = vx.size() == pad && kind != ShapeKind::box && kind != ShapeKind::hull
                            ? (n.z * vz[1] > n.z * vz[0] ? 1 : 0)
                            : farthest(vx.data(), vy.data(), vz.data(), vx.size(), n);
  const Vec3 vertex{vx[i], vy[i], vz[i]};
  const Vec3 stretched{axes.x * n.x, axes.y * n.y, axes.z * n.z};
  const double length = norm(stretched);
  if (length == 0) return vertex;
  const double s = 1 / length;
  return vertex + Vec3{s * axes.x * stretched.x, s * axes.y * stretched.y, s * axes.z * stretched.z};
}

}  // namespace wayproof
