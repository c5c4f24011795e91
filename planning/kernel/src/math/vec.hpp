// Vectors, rotations and rigid transforms in double precision.
#pragma once

#include <array>
#include <cmath>

namespace wayproof {

struct Vec3 {
  double x = 0, y = 0, z = 0;

  double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double norm(Vec3 a) { return std::sqrt(dot(a, a)); }

// Row-major.
struct Mat3 {
  std::array<double, 9> m{1, 0, 0, 0, 1, 0, 0, 0, 1};

  Vec3 row(int i) const { return {m[3 * i], m[3 * i + 1], m[3 * i + 2]}; }
};

inline Vec3 operator*(const Mat3& r, Vec3 v) { return {dot(r.row(0), v), dot(r.row(1), v), dot(r.row(2), v)}; }

inline Mat3 operator*(const Mat3& a, const Mat3& b) {
  Mat3 c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      c.m[3 * i + j] = a.m[3 * i] * b.m[j] + a.m[3 * i + 1] * b.m[3 + j] + a.m[3 * i + 2] * b.m[6 + j];
  return c;
}

inline Vec3 transposed_times(const Mat3& r, Vec3 v) {
  return {r.m[0] * v.x + r.m[3] * v.y + r.m[6] * v.z, r.m[1] * v.x + r.m[4] * v.y + r.m[7] * v.z,
          r.m[2] * v.x + r.m[5] * v.y + r.m[8] * v.z};
}

inline Mat3 transposed(const Mat3& r) {
  return {{r.m[0], r.m[3], r.m[6], r.m[1], r.m[4], r.m[7], r.m[2], r.m[5], r.m[8]}};
}

// X_AB: R_AB and p_AB.
struct Transform {
  Mat3 R;
  Vec3 p;

  Vec3 operator*(Vec3 v) const { return R * v + p; }
  Transform operator*(const Transform& other) const { return {R * other.R, R * other.p + p}; }
  Transform inverse() const { return {transposed(R), -transposed_times(R, p)}; }
};

// Rodrigues' formula for a unit axis.
inline Mat3 rotation_about(Vec3 a, double angle) {
  const double s = std::sin(angle), c = std::cos(angle), t = 1 - c;
  return {{t * a.x * a.x + c, t * a.x * a.y - s * a.z, t * a.x * a.z + s * a.y, t * a.x * a.y + s * a.z,
           t * a.y * a.y + c, t * a.y * a.z - s * a.x, t * a.x * a.z - s * a.y, t * a.y * a.z + s * a.x,
           t * a.z * a.z + c}};
}

// Of a quaternion [w, x, y, z] of any length but zero.
inline Mat3 rotation_of_quaternion(double w, double x, double y, double z) {
  const double n = 2 / (w * w + x * x + y * y + z * z);
  return {{1 - n * (y * y + z * z), n * (x * y - w * z), n * (x * z + w * y), n * (x * y + w * z),
           1 - n * (x * x + z * z), n * (y * z - w * x), n * (x * z - w * y), n * (y * z + w * x),
           1 - n * (x * x + y * y)}};
}

}  // namespace wayproof
