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
  int number[4] = {};  // of each in the order of the search
  int size = 0;

  void add(Vec3 vertex, int its_number) { w[size] = vertex, number[size++] = its_number; }
  void move(int from, int to) { w[to] = w[from], number[to] = number[from]; }
};

// Reduces a simplex to the face whose point nearest to the origin is returned.
Vec3 nearest_of_segment(Simplex& s) {
  const Vec3 a = s.w[0], ab = s.w[1] - a;
  const double square = dot(ab, ab), t = square > 0 ? -dot(a, ab) / square : 0;
  if (t <= 0) return s.size = 1, a;
  if (t >= 1) return s.move(1, 0), s.size = 1, s.w[0];
  return a + t * ab;
}

// Ericson, "Real-Time Collision Detection", 2005, section 5.1.5, for the origin.
Vec3 nearest_of_triangle(Simplex& s) {
  const Vec3 a = s.w[0], b = s.w[1], c = s.w[2], ab = b - a, ac = c - a;
  const double d1 = -dot(ab, a), d2 = -dot(ac, a);
  if (d1 <= 0 && d2 <= 0) return s.size = 1, a;
  const double d3 = -dot(ab, b), d4 = -dot(ac, b);
  if (d3 >= 0 && d4 <= d3) return s.move(1, 0), s.size = 1, b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return s.size = 2, a + (d1 / (d1 - d3)) * ab;
  const double d5 = -dot(ab, c), d6 = -dot(ac, c);
  if (d6 >= 0 && d5 <= d6) return s.move(2, 0), s.size = 1, c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return s.move(2, 1), s.size = 2, a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return s.move(1, 0), s.move(2, 1), s.size = 2, b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
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
    Simplex face{{s.w[f[0]], s.w[f[1]], s.w[f[2]]}, {s.number[f[0]], s.number[f[1]], s.number[f[2]]}, 3};
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

// What a search does not keep.
struct NoTrace {
  Vec3 support(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB, Vec3 n) {
    return wayproof::support(a, X_WA, b, X_WB, n);
  }
  int last() const { return 0; }
};

// The support points of a search, in A and in B.
struct Trace {
  // Not set before they are used: most searches end after a step or two.
  struct Numbers {
    double x, y, z;

    Vec3 vec() const { return {x, y, z}; }
  };
  Numbers on_a[max_steps + 3], on_b[max_steps + 3];
  int size = 0;

  Vec3 add(Vec3 p_A, const Transform& X_WA, Vec3 p_B, const Transform& X_WB) {
    on_a[size] = {p_A.x, p_A.y, p_A.z}, on_b[size++] = {p_B.x, p_B.y, p_B.z};
    return X_WA * p_A - X_WB * p_B;
  }
  Vec3 support(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB, Vec3 n) {
    return add(a.core_support(transposed_times(X_WA.R, n)), X_WA, b.core_support(transposed_times(X_WB.R, -n)), X_WB);
  }
  int last() const { return size - 1; }
};

// The point of A, in A, for the simplex point nearest to the origin: the same convex combination of A's points.
Vec3 behind(const Simplex& s, Vec3 v, const Trace& trace) {
  const auto point = [&](int i) { return trace.on_a[s.number[i]].vec(); };
  const Vec3 a = point(0);
  if (s.size == 1) return a;
  const Vec3 e = s.w[1] - s.w[0], r = v - s.w[0], da = point(1) - a;
  if (s.size == 2) return a + (dot(r, e) / dot(e, e)) * da;
  const Vec3 f = s.w[2] - s.w[0];
  const double ee = dot(e, e), ef = dot(e, f), ff = dot(f, f), re = dot(r, e), rf = dot(r, f);
  const double det = ee * ff - ef * ef;
  if (!(det > 0)) return a;
  return a + ((re * ff - rf * ef) / det) * da + ((rf * ee - re * ef) / det) * (point(2) - a);
}

// Begins with `simplex`, if it has vertices, else with a direction `v` from B to A, or zero; both are left as they are
// at the end.
template <typename Kept>
Separation search(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB, double enough,
                  double few, double close, Simplex& simplex, Vec3& v, Kept& kept) {
  const double balls = a.ball + b.ball;
  double upper = inf, depth;
  if (simplex.size > 0) v = nearest(simplex, depth), upper = norm(v) - balls;
  if (norm(v) <= tolerance) v = X_WA * a.center - X_WB * b.center, simplex.size = 0, upper = inf;
  if (norm(v) <= tolerance) v = {1, 0, 0};
  Separation best{-inf, upper, (1 / norm(v)) * v};
  for (int step = 0; step < max_steps; ++step) {
    const double length = norm(v);
    const Vec3 n = (1 / length) * v, w = kept.support(a, X_WA, b, X_WB, -n);
    if (const double width = dot(n, w) - balls; width > best.lower) best.lower = width, best.direction = n;
    if (best.lower >= enough || best.upper <= few || best.upper - best.lower <= close) break;
    simplex.add(w, kept.last());
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
  Vec3 v = guess;
  NoTrace nothing;
  return search(a, X_WA, b, X_WB, enough, few, close, simplex, v, nothing);
}

ClosestPoints closest_points(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB,
                             double enough, Features& features) {
  if (b.kind == ShapeKind::half_space) return {above(a, X_WA, X_WB, false), lowest(a, X_WA, X_WB)};
  if (a.kind == ShapeKind::half_space) return {above(b, X_WB, X_WA, true), lowest(b, X_WB, X_WA)};
  Simplex simplex;
  Trace trace;
  for (int i = 0; i < features.size; ++i) simplex.add(trace.add(features.on_a[i], X_WA, features.on_b[i], X_WB), i);
  Vec3 v = features.direction;
  const Separation found = search(a, X_WA, b, X_WB, enough, -inf, 1e-10, simplex, v, trace);
  features.direction = found.direction;
  features.size = simplex.size < 4 ? simplex.size : 0;
  for (int i = 0; i < features.size; ++i) {
    features.on_a[i] = trace.on_a[simplex.number[i]].vec();
    features.on_b[i] = trace.on_b[simplex.number[i]].vec();
  }
  if (found.lower >= enough || features.size == 0) return {found, {}};
  return {found, X_WA * behind(simplex, v, trace)};
}

}  // namespace wayproof
