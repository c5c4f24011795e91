#include "model/gjk.hpp"

#include <algorithm>
#include <limits>

namespace wayproof {
namespace {

constexpr int max_steps = 64;
constexpr double tolerance = 1e-10;
constexpr double inf = std::numeric_limits<double>::infinity();

struct Simplex {
  Vec3 w[4];
  int size = 0;
};

// Reduces a simplex to the face whose point nearest to the origin is returned.
Vec3 nearest_of_segment(Simplex& s) {
  const Vec3 a = s.w[0], ab = s.w[1] - a;
  const double square = dot(ab, ab), t = square > 0 ? -dot(a, ab) / square : 0;
  if (t <= 0) return s.size = 1, a;
  if (t >= 1) return s.w[0] = s.w[1], s.size = 1, s.w[0];
  return a + t * ab;
}

// Ericson, "Real-Time Collision Detection", 2005, section 5.1.5, for the origin.
Vec3 nearest_of_triangle(Simplex& s) {
  const Vec3 a = s.w[0], b = s.w[1], c = s.w[2], ab = b - a, ac = c - a;
  const double d1 = -dot(ab, a), d2 = -dot(ac, a);
  if (d1 <= 0 && d2 <= 0) return s.size = 1, a;
  const double d3 = -dot(ab, b), d4 = -dot(ac, b);
  if (d3 >= 0 && d4 <= d3) return s.w[0] = b, s.size = 1, b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return s.size = 2, a + (d1 / (d1 - d3)) * ab;
  const double d5 = -dot(ab, c), d6 = -dot(ac, c);
  if (d6 >= 0 && d5 <= d6) return s.w[0] = c, s.size = 1, c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return s.w[1] = c, s.size = 2, a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return s.w[0] = b, s.w[1] = c, s.size = 2, b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
  const double sum = va + vb + vc;
  if (!(sum > 0)) return s.size = 2, nearest_of_segment(s);
  return a + (vb / sum) * ab + (vc / sum) * ac;
}

// Sets `depth` to the origin's depth inside, or to a negative number if it lies outside.
Vec3 nearest_of_tetrahedron(Simplex& s, double& depth) {
  constexpr int faces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
  Simplex best;
  Vec3 nearest;
  double least = inf;
  depth = inf;
  for (const auto& f : faces) {
    const Vec3 a = s.w[f[0]], n = cross(s.w[f[1]] - a, s.w[f[2]] - a);
    const double length = norm(n), height = dot(n, s.w[f[3]] - a), origin = -dot(n, a);
    const bool flat = std::abs(height) <= 1e-12 * length;
    if (!flat && origin * height > 0) {
      depth = std::min(depth, std::abs(origin) / length);
      continue;
    }
    depth = -inf;
    Simplex face{{s.w[f[0]], s.w[f[1]], s.w[f[2]]}, 3};
    const Vec3 v = nearest_of_triangle(face);
    if (const double square = dot(v, v); square < least) least = square, nearest = v, best = face;
  }
  if (depth >= 0 && least == inf) return {};
  s = best;
  return nearest;
}

Vec3 nearest(Simplex& s, double& depth) {
  depth = -inf;
  switch (s.size) {
    case 1: return s.w[0];
    case 2: return nearest_of_segment(s);
    case 3: return nearest_of_triangle(s);
    default: return nearest_of_tetrahedron(s, depth);
  }
}

// The point of all a - b, cores only, that lies farthest along n, in W.
Vec3 support(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB, Vec3 n) {
  return X_WA * a.core_support(transposed_times(X_WA.R, n)) - X_WB * b.core_support(transposed_times(X_WB.R, -n));
}

// Support points of a search, from which the points of A and B behind the last simplex are computed.
struct SupportHistory {
  // Not set before they are used: most searches end after a step or two.
  struct Numbers {
    double x, y, z;

    Vec3 vec() const { return {x, y, z}; }
  };
  Numbers w[max_steps], a[max_steps];
  int size = 0;

  void add(Vec3 difference, Vec3 of_a) {
    w[size] = {difference.x, difference.y, difference.z};
    a[size++] = {of_a.x, of_a.y, of_a.z};
  }
  Vec3 first() const { return size ? a[0].vec() : Vec3{}; }
  Vec3 point_of(Vec3 difference) const {
    for (int i = size; i-- > 0;)
      if (w[i].x == difference.x && w[i].y == difference.y && w[i].z == difference.z) return a[i].vec();
    return first();
  }
};

// The point of A for the simplex point nearest to the origin: the same convex combination of A's points.
Vec3 behind(const Simplex& s, Vec3 v, const SupportHistory& history) {
  const Vec3 a = history.point_of(s.w[0]);
  if (s.size == 1) return a;
  const Vec3 e = s.w[1] - s.w[0], r = v - s.w[0], da = history.point_of(s.w[1]) - a;
  if (s.size == 2) return a + (dot(r, e) / dot(e, e)) * da;
  const Vec3 f = s.w[2] - s.w[0];
  const double ee = dot(e, e), ef = dot(e, f), ff = dot(f, f), re = dot(r, e), rf = dot(r, f);
  const double det = ee * ff - ef * ef;
  if (!(det > 0)) return a;
  return a + ((re * ff - rf * ef) / det) * da + ((rf * ee - re * ef) / det) * (history.point_of(s.w[2]) - a);
}

// `history`, if there is one, receives the support points, and `simplex` the last simplex.
template <bool keeps_history>
Separation search(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB, double enough,
                  double few, Vec3 guess, double close, Simplex& simplex, Vec3& v, SupportHistory* history) {
  const double balls = a.ball + b.ball;
  v = guess;
  if (norm(v) <= tolerance) v = X_WA * a.center - X_WB * b.center;
  if (norm(v) <= tolerance) v = {1, 0, 0};
  Separation best{-inf, inf, (1 / norm(v)) * v};
  for (int step = 0; step < max_steps; ++step) {
    const double length = norm(v);
    const Vec3 n = (1 / length) * v;
    Vec3 w;
    if constexpr (keeps_history) {
      const Vec3 on_a = X_WA * a.core_support(transposed_times(X_WA.R, -n));
      w = on_a - X_WB * b.core_support(transposed_times(X_WB.R, n));
      history->add(w, on_a);
    } else {
      w = support(a, X_WA, b, X_WB, -n);
    }
    if (const double width = dot(n, w) - balls; width > best.lower) best.lower = width, best.direction = n;
    if (best.lower >= enough || best.upper <= few || best.upper - best.lower <= close) break;
    simplex.w[simplex.size++] = w;
    double depth;
    v = nearest(simplex, depth);
    if (depth >= 0) return best.upper = std::min(best.upper, -depth - balls), best;
    const double distance = norm(v) - balls;
    if (distance >= best.upper) break;
    best.upper = distance;
    if (norm(v) <= tolerance) break;
  }
  return best;
}

Vec3 up(const Transform& X_WB) { return {X_WB.R.m[2], X_WB.R.m[5], X_WB.R.m[8]}; }

// The point of A's core that lies lowest above the half space B.
Vec3 lowest(const Shape& a, const Transform& X_WA, const Transform& X_WB) {
  return X_WA * a.core_support(transposed_times(X_WA.R, -up(X_WB)));
}

// Height of A above the half space B: another half space reaches infinitely far below it, unless they face each other,
// which rounding decides.
Separation above(const Shape& a, const Transform& X_WA, const Transform& X_WB, bool flip) {
  const Vec3 n = up(X_WB);
  if (a.kind == ShapeKind::half_space) return {-inf, -inf, flip ? -n : n};
  const double height = dot(n, lowest(a, X_WA, X_WB) - X_WB.p) - a.ball;
  return {height, height, flip ? -n : n};
}

}  // namespace

double slab(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB, Vec3 n) {
  if (b.kind == ShapeKind::half_space) return above(a, X_WA, X_WB, false).lower;
  if (a.kind == ShapeKind::half_space) return above(b, X_WB, X_WA, true).lower;
  return dot(n, support(a, X_WA, b, X_WB, -n)) - a.ball - b.ball;
}

Separation separation(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB, double enough,
                      double few, Vec3 guess, double close) {
  if (b.kind == ShapeKind::half_space) return above(a, X_WA, X_WB, false);
  if (a.kind == ShapeKind::half_space) return above(b, X_WB, X_WA, true);
  Simplex simplex;
  Vec3 v;
  return search<false>(a, X_WA, b, X_WB, enough, few, guess, close, simplex, v, nullptr);
}

ClosestPoints closest_points(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB,
                             double enough, Vec3 guess) {
  if (b.kind == ShapeKind::half_space) return {above(a, X_WA, X_WB, false), lowest(a, X_WA, X_WB)};
  if (a.kind == ShapeKind::half_space) return {above(b, X_WB, X_WA, true), lowest(b, X_WB, X_WA)};
  Simplex simplex;
  Vec3 v;
  SupportHistory history;
  const Separation found = search<true>(a, X_WA, b, X_WB, enough, -inf, guess, 1e-10, simplex, v, &history);
  if (found.lower >= enough || simplex.size == 0 || simplex.size > 3) return {found, history.first()};
  return {found, behind(simplex, v, history)};
}

}  // namespace wayproof
