#include "qp/lane_rows.hpp"

#include <algorithm>
#include <bit>

#include "math/multiversion.hpp"

namespace wayproof {
namespace {

using Group = LaneRows::Group;
using Line = LaneRows::Line;

constexpr std::size_t num_points = LaneRows::num_points, num_values = LaneRows::num_values;

// The column of a value, or any of one that is 0 because there is none.
[[gnu::always_inline]] inline std::size_t place(std::int64_t column) {
  return column < 0 ? 0 : static_cast<std::size_t>(column);
}

// The numbers of a line's rows in their lanes, 0 in the others; goes on to the next line's. Reads one number more.
[[gnu::always_inline]] inline Lanes spread(unsigned taken, const double*& numbers) {
  const auto next = [&taken, &numbers] __attribute__((always_inline)) {
    const std::uint64_t is_taken = taken & 1U;
    const auto bits = std::bit_cast<std::uint64_t>(*numbers) & (0 - is_taken);
    numbers += is_taken, taken >>= 1U;
    return std::bit_cast<double>(bits);
  };
  const double a = next(), b = next(), c = next(), d = next(), e = next(), f = next(), g = next(), h = next();
  return Lanes{a, b, c, d, e, f, g, h};
}

// Writes one number more.
WAYPROOF_MULTIVERSION
void lines_times(const Line* lines, const Group& group, const double* x, double*& y) {
  const Lanes p0 = load(x + place(group.points[0])), p1 = load(x + place(group.points[1])),
              p2 = load(x + place(group.points[2])), p3 = load(x + place(group.points[3]));
  const double low = x[place(group.low)], high = x[place(group.high)];
  for (std::size_t i = group.begin; i < group.end; ++i) {
    const double* v = lines[i].values.data();
    const Lanes sum = ((load(v) * p0 + load(v + 8) * p1) + (load(v + 16) * p2 + load(v + 24) * p3)) +
                      (load(v + 32) * low + load(v + 40) * high);
    for (std::size_t l = 0; l < num_lanes; ++l) {
      *y = sum[l];
      y += lines[i].taken >> l & 1U;
    }
  }
}

WAYPROOF_MULTIVERSION
void add_transposed_lines(const Line* lines, const Group& group, const double*& y, double scale, double* x) {
  Lanes sums[num_values] = {};
  for (std::size_t i = group.begin; i < group.end; ++i) {
    const Lanes factor = spread(lines[i].taken, y);
    for (std::size_t k = 0; k < num_values; ++k) sums[k] += load(&lines[i].values[k * num_lanes]) * factor;
  }
  for (std::size_t k = 0; k < num_points; ++k) add_to(x + place(group.points[k]), scale * sums[k]);
  x[place(group.low)] += scale * sum_of(sums[LaneRows::low]);
  x[place(group.high)] += scale * sum_of(sums[LaneRows::high]);
}

// Products of the values of a group, summed over its lines.
struct Squares {
  double of_points[num_points][num_points][num_lanes];  // of k and j <= k
  double with_low[num_points][num_lanes], with_high[num_points][num_lanes];
  double low, high, both;
};

WAYPROOF_MULTIVERSION
void square_lines(const Line* lines, const Group& group, const double*& weight, Squares& squares) {
  Lanes of_points[num_points][num_points] = {}, with_low[num_points] = {}, with_high[num_points] = {};
  Lanes low = {}, high = {}, both = {};
  for (std::size_t i = group.begin; i < group.end; ++i) {
    const Lanes w = spread(lines[i].taken, weight);
    Lanes v[num_values];
    for (std::size_t k = 0; k < num_values; ++k) v[k] = load(&lines[i].values[k * num_lanes]);
    for (std::size_t k = 0; k < num_points; ++k) {
      const Lanes a = w * v[k];
      for (std::size_t j = 0; j <= k; ++j) of_points[k][j] += a * v[j];
      with_low[k] += a * v[LaneRows::low], with_high[k] += a * v[LaneRows::high];
    }
    const Lanes a = w * v[LaneRows::low];
    low += a * v[LaneRows::low], both += a * v[LaneRows::high];
    high += w * v[LaneRows::high] * v[LaneRows::high];
  }
  for (std::size_t k = 0; k < num_points; ++k) {
    for (std::size_t j = 0; j <= k; ++j)
      for (std::size_t l = 0; l < num_lanes; ++l) squares.of_points[k][j][l] = of_points[k][j][l];
    for (std::size_t l = 0; l < num_lanes; ++l)
      squares.with_low[k][l] = with_low[k][l], squares.with_high[k][l] = with_high[k][l];
  }
  squares.low = sum_of(low), squares.high = sum_of(high), squares.both = sum_of(both);
}

void add(const Group& g, const Squares& s, Skyline& matrix) {
  const auto at = [&matrix](std::int64_t a, std::int64_t b) -> double& {
    return matrix.at(static_cast<int>(std::max(a, b)), static_cast<int>(std::min(a, b)));
  };
  const auto lanes = static_cast<std::int64_t>(g.lanes);
  for (std::size_t k = 0; k < num_points; ++k) {
    const std::int64_t p = g.points[k];
    if (p < 0) continue;
    for (std::size_t j = 0; j <= k; ++j)
      for (std::int64_t l = 0; g.points[j] >= 0 && l < lanes; ++l) at(p + l, g.points[j] + l) += s.of_points[k][j][l];
    for (std::int64_t l = 0; g.low >= 0 && l < lanes; ++l) at(p + l, g.low) += s.with_low[k][l];
    for (std::int64_t l = 0; g.high >= 0 && l < lanes; ++l) at(p + l, g.high) += s.with_high[k][l];
  }
  if (g.low >= 0) at(g.low, g.low) += s.low;
  if (g.high >= 0) at(g.high, g.high) += s.high;
  if (g.low >= 0 && g.high >= 0) at(g.low, g.high) += s.both;
}

}  // namespace

LaneBlocks::LaneBlocks(const LaneRows& rows) : r_(rows), numbers_(rows.rows + 1) {}

void LaneBlocks::widen(std::vector<int>& first) const {
  for (const Group& g : r_.groups) {
    // Points are of one coordinate each: only the same coordinate of other points, and both variables, meet.
    for (std::size_t l = 0; l < g.lanes; ++l) {
      std::array<std::int64_t, num_values> columns{};
      std::size_t count = 0;
      for (std::int64_t p : g.points)
        if (p >= 0) columns[count++] = p + static_cast<std::int64_t>(l);
      for (std::int64_t c : {g.low, g.high})
        if (c >= 0) columns[count++] = c;
      const auto lowest = static_cast<int>(*std::min_element(columns.begin(), columns.begin() + count));
      for (std::size_t k = 0; k < count; ++k) first[columns[k]] = std::min(first[columns[k]], lowest);
    }
  }
}

void LaneBlocks::times(const std::vector<double>& x, double* y) {
  if (r_.groups.empty()) return;
  variables_.resize(x.size() + num_lanes);
  std::copy(x.begin(), x.end(), variables_.begin());
  double* to = numbers_.data();
  for (const Group& g : r_.groups) lines_times(r_.lines.data(), g, variables_.data(), to);
  std::copy_n(numbers_.begin(), r_.rows, y);
}

void LaneBlocks::add_transposed(const double* y, double scale, std::vector<double>& x) {
  if (r_.groups.empty()) return;
  variables_.resize(x.size() + num_lanes);
  std::copy(x.begin(), x.end(), variables_.begin());
  std::copy_n(y, r_.rows, numbers_.begin());
  const double* from = numbers_.data();
  for (const Group& g : r_.groups) add_transposed_lines(r_.lines.data(), g, from, scale, variables_.data());
  std::copy_n(variables_.begin(), x.size(), x.begin());
}

void LaneBlocks::add_squares(const double* weight, Skyline& matrix) {
  std::copy_n(weight, r_.rows, numbers_.begin());
  const double* from = numbers_.data();
  Squares squares;
  for (const Group& g : r_.groups) {
    square_lines(r_.lines.data(), g, from, squares);
    add(g, squares, matrix);
  }
}

}  // namespace wayproof
