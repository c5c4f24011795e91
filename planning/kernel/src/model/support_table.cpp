#include "model/support_table.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "math/lanes.hpp"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace wayproof {
namespace {

constexpr std::size_t lanes = num_lanes, numbers_per_batch = 3 * lanes;
// Cells along every side of a face, a power of two.
constexpr std::size_t side = 8;
// Cells with no more vertices are not divided further: one batch.
constexpr std::size_t few = lanes;
// What is left out is nearer by this share of the largest coordinate, for directions whose largest component is 1:
// far above the rounding of products and of the choice of a cell.
constexpr double spare = 1e-12;

// The axes of a face: that of its normal, and those along which its rows and columns run.
struct Face {
  int normal, row, column;
  double sign;
};
constexpr std::array<Face, 6> faces{
    {{0, 1, 2, 1}, {0, 1, 2, -1}, {1, 2, 0, 1}, {1, 2, 0, -1}, {2, 0, 1, 1}, {2, 0, 1, -1}}};

// A direction whose largest component is 1.
Vec3 direction(const Face& face, std::size_t row, std::size_t column) {
  const auto along = [](std::size_t k) { return 2.0 * static_cast<double>(k) / static_cast<double>(side) - 1; };
  std::array<double, 3> n{};
  n[face.normal] = face.sign, n[face.row] = along(row), n[face.column] = along(column);
  return {n[0], n[1], n[2]};
}

// The cell of t = -1 to 1, also of what is beyond by rounding or is not a number.
std::size_t cell_of(double t) {
  const double k = (t + 1) * (static_cast<double>(side) / 2);
  return k > 0 ? static_cast<std::size_t>(std::min(k, static_cast<double>(side) - 1)) : 0;
}

// Which of the lanes are equal to a number, lane k in bit k.
unsigned lanes_equal_to(const Lanes& value, double number) {
#if defined(__SSE2__)
  unsigned bits = 0;
  const __m128d all = _mm_set1_pd(number);
  for (unsigned k = 0; k < num_lanes; k += 2) {
    const __m128d two = {value[k], value[k + 1]};
    bits |= static_cast<unsigned>(_mm_movemask_pd(_mm_cmpeq_pd(two, all))) << k;
  }
  return bits;
#else
  unsigned bits = 0;
  for (unsigned k = 0; k < num_lanes; ++k) bits |= static_cast<unsigned>(value[k] == number) << k;
  return bits;
#endif
}

// Where in batches the vertex is that lies farthest along n: the first of equals. No function of its own per
// instruction set: calling it would take longer than the eight products, and most cells have one batch.
std::size_t farthest_of(const double* numbers, std::size_t batches, Vec3 n) {
  std::size_t found = 0;
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < batches; ++b) {
    const double* from = numbers + b * numbers_per_batch;
    const Lanes value = load(from) * n.x + load(from + num_lanes) * n.y + load(from + 2 * num_lanes) * n.z;
    const auto larger = [&](std::size_t i, std::size_t k) { return std::max(value[i], value[k]); };
    const double largest = std::max(std::max(larger(0, 4), larger(2, 6)), std::max(larger(1, 5), larger(3, 7)));
    if (!(largest > best)) continue;
    best = largest;
    // A bit beyond the lanes for numbers that are NaN.
    const unsigned bits = lanes_equal_to(value, largest) | (1U << (num_lanes - 1));
    found = b * numbers_per_batch + static_cast<std::size_t>(std::countr_zero(bits));
  }
  return found;
}

// Those vertices that may be the farthest along a direction between four.
std::vector<Vec3> candidates(const std::vector<Vec3>& vertices, const std::array<Vec3, 4>& corners, double margin) {
  std::vector<std::array<double, 4>> along(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i)
    for (std::size_t c = 0; c < 4; ++c) along[i][c] = dot(vertices[i], corners[c]);
  // The farthest along the corners and along the middle leave out most of the others.
  std::array<std::size_t, 5> winners{};
  const auto sum = [](const std::array<double, 4>& a) { return (a[0] + a[1]) + (a[2] + a[3]); };
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c)
      if (along[i][c] > along[winners[c]][c]) winners[c] = i;
    if (sum(along[i]) > sum(along[winners[4]])) winners[4] = i;
  }
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto beats = [&](std::size_t w) {
      for (std::size_t c = 0; c < 4; ++c)
        if (!(along[w][c] - along[i][c] > margin)) return false;
      return true;
    };
    if (std::none_of(winners.begin(), winners.end(), beats)) kept.push_back(vertices[i]);
  }
  return kept;
}

}  // namespace

SupportTable::SupportTable(const std::vector<Vec3>& vertices) : cells_(faces.size() * side * side) {
  double largest = 0;
  for (Vec3 v : vertices) largest = std::max({largest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  for (std::size_t face = 0; face < faces.size(); ++face) divide(vertices, face, 0, 0, side, spare * largest);
}

// Of the cells [row, row + width) x [column, column + width) of a face, among the vertices that are left for them.
void SupportTable::divide(const std::vector<Vec3>& vertices, std::size_t face, std::size_t row, std::size_t column,
                          std::size_t width, double margin) {
  const Face& f = faces[face];
  const auto kept = candidates(vertices,
                               {direction(f, row, column), direction(f, row + width, column),
                                direction(f, row, column + width), direction(f, row + width, column + width)},
                               margin);
  if (width > 1 && kept.size() > few) {
    for (std::size_t quarter = 0; quarter < 4; ++quarter)
      divide(kept, face, row + (quarter / 2) * (width / 2), column + (quarter % 2) * (width / 2), width / 2, margin);
    return;
  }
  const std::size_t batches = (kept.size() + lanes - 1) / lanes, begin = numbers_.size() / numbers_per_batch;
  numbers_.resize(numbers_.size() + batches * numbers_per_batch);
  for (std::size_t i = 0; i < batches * lanes; ++i) {
    const Vec3 v = kept[std::min(i, kept.size() - 1)];
    double* to = &numbers_[(begin + i / lanes) * numbers_per_batch + i % lanes];
    to[0] = v.x, to[lanes] = v.y, to[2 * lanes] = v.z;
  }
  for (std::size_t r = row; r < row + width; ++r)
    for (std::size_t c = column; c < column + width; ++c)
      cells_[(face * side + r) * side + c] = {static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(batches)};
}

Vec3 SupportTable::farthest(Vec3 n) const {
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const int axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
  const double along[3] = {n.x, n.y, n.z};
  const std::size_t face = 2 * static_cast<std::size_t>(axis) + (along[axis] < 0 ? 1 : 0);
  const Face& f = faces[face];
  const double scale = 1 / std::abs(along[axis]);
  const Batches cell = cells_[(face * side + cell_of(along[f.row] * scale)) * side + cell_of(along[f.column] * scale)];
  const double* numbers = &numbers_[cell.begin * numbers_per_batch];
  const double* found = numbers + farthest_of(numbers, cell.count, n);
  return {found[0], found[lanes], found[2 * lanes]};
}

}  // namespace wayproof
