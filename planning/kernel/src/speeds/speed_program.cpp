#include "speeds/speed_program.hpp"

#include <array>
#include <cmath>
#include <numeric>

namespace wayproof {
namespace {

// toppra's: of coefficients that count as zero, and of rows that are broken; bounds of u; and of a line's parameter,
// which must never be reached.
constexpr double tiny = 1e-10, small = 1e-8, most = 1e8, infinity = 1e10;
// The direction in which the program goes.
constexpr double by_u = -1e-9, by_x = 1;

}  // namespace

std::optional<SpeedProgram::LineEnd> SpeedProgram::end_of(std::span<const HalfLine> rows, double direction, double low,
                                                          double high) {
  LineEnd first{low, -1}, last{high, -2};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto [a, b] = rows[i];
    if (!(std::abs(a) > tiny)) continue;
    const double t = -b / a;
    if (a > 0) {
      if (t < last.t) last = {t, static_cast<int>(i)};
    } else if (t > first.t) {
      first = {t, static_cast<int>(i)};
    }
  }
  if (first.t > last.t) return std::nullopt;
  return direction < tiny ? first : last;
}

void SpeedProgram::order(std::size_t count, const Active& active) {
  order_.resize(count);
  const auto is_row = [&](int i) { return i >= 0 && i < static_cast<int>(count); };
  if (!is_row(active.first) || !is_row(active.second) || active.first == active.second) {
    std::iota(order_.begin(), order_.end(), 0);
    return;
  }
  order_[0] = active.second, order_[1] = active.first;
  for (int i = 0, k = 2; i < static_cast<int>(count); ++i)
    if (i != active.first && i != active.second) order_[static_cast<std::size_t>(k++)] = i;
}

std::optional<SpeedProgram::LineEnd> SpeedProgram::best_on_line(std::span<const SpeedRow> rows, std::size_t k,
                                                                double cap, Point& point) {
  const SpeedRow& line = rows[static_cast<std::size_t>(order_[k])];
  const double square = line.a * line.a + line.b * line.b;
  // The point of the line nearest to the origin, and its direction.
  const Point nearest{-line.a * line.c / square, -line.b * line.c / square}, along{-line.b, line.a};
  const std::array<SpeedRow, 4> box{SpeedRow{-1, 0, -most}, {1, 0, -most}, {0, -1, 0}, {0, 1, -cap}};
  half_lines_.resize(k + box.size());
  for (std::size_t j = 0; j < half_lines_.size(); ++j) {
    const SpeedRow& row = j < k ? rows[static_cast<std::size_t>(order_[j])] : box[j - k];
    const double slope = along.u * row.a + along.x * row.b;
    const double value = row.c + nearest.x * row.b + nearest.u * row.a;
    if (slope > tiny) {
      half_lines_[j] = {1, value / slope};
    } else if (slope < -tiny) {
      half_lines_[j] = {-1, -(value / slope)};
    } else {
      // Parallel: either all of the line keeps it, or nothing does.
      if (value > small) return std::nullopt;
      half_lines_[j] = {0, -1};
    }
  }
  const auto end = end_of(half_lines_, along.u * by_u + along.x * by_x, -infinity, infinity);
  if (end) point = {nearest.u + end->t * along.u, nearest.x + end->t * along.x};
  return end;
}

std::optional<SpeedProgram::Point> SpeedProgram::largest_speed(std::span<const SpeedRow> rows, double cap,
                                                               Active& active) {
  if (!(cap >= 0)) return std::nullopt;
  Point point{-most, cap};
  Active found{-1, -4};
  order(rows.size(), active);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const int i = order_[k];
    const SpeedRow& row = rows[static_cast<std::size_t>(i)];
    if (row.a * point.u + row.b * point.x + row.c < tiny) continue;
    const auto end = best_on_line(rows, k, cap, point);
    if (!end || end->active < 0) return std::nullopt;
    const auto other = static_cast<std::size_t>(end->active);
    found = {i, other < k ? order_[other] : -1 - static_cast<int>(other - k)};
  }
  active = found;
  return point;
}

std::optional<double> SpeedProgram::largest_acceleration(std::span<const SpeedRow> rows, double x) {
  std::vector<HalfLine> half_lines;
  half_lines.reserve(rows.size());
  for (const SpeedRow& row : rows) half_lines.push_back({row.a, row.b * x + row.c});
  const auto end = end_of(half_lines, 1, -most, most);
  return end ? std::optional(end->t) : std::nullopt;
}

}  // namespace wayproof
