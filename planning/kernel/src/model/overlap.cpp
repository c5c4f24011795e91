#include "model/overlap.hpp"

#include <limits>

#include "model/gjk.hpp"

namespace wayproof {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double apart = 1e-3;

}  // namespace

Overlap overlap(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB) {
  if (a.kind == ShapeKind::half_space || b.kind == ShapeKind::half_space) {
    const Separation height = separation(a, X_WA, b, X_WB, inf, -inf, {});
    return {height.lower, height.direction};
  }
  double best = -inf;
  Vec3 n;
  const auto consider = [&](Vec3 direction) {
    const double length = norm(direction);
    if (!(length > 1e-12)) return false;
    const Vec3 unit = (1 / length) * direction;
    const double width = slab(a, X_WA, b, X_WB, unit);
    if (!(width > best + 1e-7)) return false;
    best = width, n = unit;
    return true;
  };
  consider(X_WA * a.center - X_WB * b.center);
  for (const Mat3* R : {&X_WA.R, &X_WB.R})
    for (int i = 0; i < 3; ++i) {
      const Vec3 axis{R->m[i], R->m[i + 3], R->m[i + 6]};
      consider(axis), consider(-axis);
    }
  for (double step = 0.4; step > 0.05;) {
    const Vec3 across = cross(n, std::abs(n.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0});
    const Vec3 s = (step / norm(across)) * across, t = cross(n, s), from = n;
    bool better = false;
    for (Vec3 d : {s, -s, t, -t}) better |= consider(from + d);
    if (!better) step /= 2;
  }
  // Shapes moved apart along the best direction, and a little farther, have nearest points of their own.
  for (bool better = true; better && best <= 0;) {
    Transform X_WC = X_WA;
    X_WC.p = X_WA.p + (apart - best) * n;
    better = consider(separation(a, X_WC, b, X_WB, inf, -inf, n).direction);
  }
  return {best, n};
}

}  // namespace wayproof
