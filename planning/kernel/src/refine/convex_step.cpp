#include "refine/convex_step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "refine/active_balls.hpp"
#include "refine/active_distances.hpp"
#include "refine/active_rows.hpp"

namespace wayproof {
namespace {

constexpr std::size_t four = weights_per_instant;

// Everything that rows of rates are made of.
struct Around {
  const CurveGrid& grid;
  const RateBounds& bounds;
  const CurveColumns& columns;
  const ModelWeights& weights;
  const StepBox& box;
  const std::vector<double>& b;
  const CurveRates rates;
  PenaltyQp& program;

  // Values of four points and of b at both ends of the interval, and the least that they are to add up to.
  struct Row {
    std::array<double, LaneRows::num_values> values{};
    double least = 0;
  };

  // The rows of an interval, for up to eight coordinates from one on.
  void add_rows(std::size_t interval, std::size_t first) {
    const std::size_t nq = bounds.coordinates(), begin = program.lanes.lines.size();
    const std::size_t lanes = std::min(num_lanes, nq - first);
    for (std::size_t end = 0; end < 2; ++end)
      add_line(first, lanes, [&](std::size_t j, Row& row) { return acceleration_row(interval, end, j, row); });
    if (interval > 0) add_line(first, lanes, [&](std::size_t j, Row& row) { return velocity_row(interval, j, row); });
    for (std::size_t end = 0; end < 2 && !bounds.jerk.empty(); ++end)
      add_line(first, lanes, [&](std::size_t j, Row& row) { return jerk_row(interval, end, j, row); });
    if (program.lanes.lines.size() == begin) return;
    LaneRows::Group group{{},    columns.path_velocity[interval], columns.path_velocity[interval + 1], lanes,
                          begin, program.lanes.lines.size()};
    for (std::size_t k = 0; k < four; ++k) {
      const auto point = static_cast<std::size_t>(grid.first_point[interval]) + k;
      group.points[k] = columns.points[point * nq + first];
    }
    program.lanes.groups.push_back(group);
    erase_absent(group);
  }

  template <class RowOf>
  void add_line(std::size_t first, std::size_t lanes, const RowOf& row_of) {
    LaneRows::Line line;
    for (std::size_t l = 0; l < lanes; ++l) {
      Row row;
      if (!row_of(first + l, row)) continue;
      for (std::size_t k = 0; k < row.values.size(); ++k) line.values[k * num_lanes + l] = row.values[k];
      line.taken |= 1U << l;
      ++program.lanes.rows;
      program.least.push_back(row.least), program.price.push_back(weights.rate_price);
    }
    if (line.taken) program.lanes.lines.push_back(line);
  }

  // What has no column has no value.
  void erase_absent(const LaneRows::Group& group) {
    for (std::size_t i = group.begin; i < group.end; ++i) {
      const auto erase = [&](std::size_t k) {
        std::fill_n(&program.lanes.lines[i].values[k * num_lanes], num_lanes, 0.0);
      };
      for (std::size_t k = 0; k < four; ++k)
        if (group.points[k] < 0) erase(k);
      if (group.low < 0) erase(LaneRows::low);
      if (group.high < 0) erase(LaneRows::high);
    }
  }

  // r'' b + r' u between both bounds, of which it can only be near one.
  bool acceleration_row(std::size_t i, std::size_t end, std::size_t j, Row& row) const {
    const double u = (b[i + 1] - b[i]) / (2 * grid.step);
    const std::size_t k = (2 * i + end) * bounds.coordinates() + j, w = (2 * i + end) * four;
    const double current = rates.acceleration(i, end, j, b[i + end], u);
    const double bound = current > 0 ? bounds.highest[j] : bounds.lowest[j];
    row.least = current / bound - 1;
    if (!(row.least > weights.least_acceleration - 1)) return false;
    const double unit = box.radii[j] / bounds.acceleration[j], slope = rates.first[k] / (2 * grid.step);
    for (std::size_t p = 0; p < four; ++p)
      row.values[p] = -(grid.second[w + p] * b[i + end] + grid.first[w + p] * u) * unit / bound;
    row.values[LaneRows::low] = -(end ? -slope : rates.second[k] - slope) * b[i] / bound;
    row.values[LaneRows::high] = -(end ? rates.second[k] + slope : slope) * b[i + 1] / bound;
    return true;
  }

  // |r'| sqrt(b) at the low end.
  bool velocity_row(std::size_t i, std::size_t j, Row& row) const {
    const double root = std::sqrt(b[i]);
    const double current = rates.by_velocity[i * bounds.coordinates() + j] * root, size = std::abs(current);
    if (!(size > weights.least_speed)) return false;
    const double unit = std::copysign(box.radii[j] / bounds.velocity[j], current) * root;
    for (std::size_t p = 0; p < four; ++p) row.values[p] = -grid.first[2 * i * four + p] * unit;
    row.values[LaneRows::low] = -size / 2;
    row.least = size - 1;
    return true;
  }

  // |r'''| b^(3/2) at an end.
  bool jerk_row(std::size_t i, std::size_t end, std::size_t j, Row& row) const {
    const double cubed = b[i + end] * std::sqrt(b[i + end]);
    const double current = rates.third[i * bounds.coordinates() + j] * cubed, size = std::abs(current);
    if (!(size > weights.least_speed)) return false;
    const double unit = std::copysign(box.radii[j] / bounds.jerk[j], current) * cubed;
    for (std::size_t p = 0; p < four; ++p) row.values[p] = -grid.third[i * four + p] * unit;
    row.values[end ? LaneRows::high : LaneRows::low] = -1.5 * size;
    row.least = size - 1;
    return true;
  }
};

// The duration to second order in b, which is proportional to b^(-1/2), and the box.
void set_cost_and_box(const CurveGrid& grid, const CurveColumns& columns, const ModelWeights& weights,
                      const StepBox& box, const std::vector<double>& points, const std::vector<double>& b,
                      PenaltyQp& program) {
  const auto count = static_cast<std::size_t>(columns.num_variables);
  const std::size_t n = grid.intervals(), nq = box.radii.size();
  program.c.assign(count, 0.0), program.q.assign(count, weights.proximal);
  program.lower.assign(count, -1.0), program.upper.assign(count, 1.0);
  const double duration = duration_of(grid, b);
  const auto time = [&](std::size_t i) {
    const double speeds = std::sqrt(b[i + 1]) + std::sqrt(b[i]);
    return grid.step / (speeds * speeds);
  };
  for (std::size_t i = 1; i < n; ++i) {
    const double gradient = std::sqrt(b[i]) * (time(i - 1) + time(i)) / duration;
    const auto k = static_cast<std::size_t>(columns.path_velocity[i]);
    program.c[k] = -gradient, program.q[k] = 1.5 * gradient;
    program.lower[k] = -weights.most_decrease, program.upper[k] = weights.most_increase;
  }
  for (std::size_t i = 1; i + 1 < grid.num_points; ++i)
    for (std::size_t j = 0; j < nq; ++j) {
      const auto k = static_cast<std::size_t>(columns.points[i * nq + j]);
      const double low = (box.lower[j] - points[i * nq + j]) / box.radii[j];
      const double high = (box.upper[j] - points[i * nq + j]) / box.radii[j];
      program.lower[k] = std::min(std::max(low, -1.0), 0.0);
      program.upper[k] = std::max(std::min(high, 1.0), program.lower[k] + weights.least_width);
    }
}

// Appends the rows of distances that take part.
void add_distances(const CurveColumns& columns, const StepBox& box, const DistanceMargins& margins,
                   const std::vector<char>& takes_part, PenaltyQp& program) {
  const std::size_t nq = box.radii.size();
  ProductRows& rows = program.products;
  rows.num_weights = four, rows.num_slopes = nq;
  for (std::size_t m = 0; m < margins.margin.size(); ++m) {
    if (!takes_part[m]) continue;
    const double* gradient = &margins.gradient[m * nq];
    const auto instant = static_cast<std::size_t>(margins.instant[m]);
    for (std::size_t k = 0; k < four; ++k) {
      rows.columns.push_back(columns.points[(static_cast<std::size_t>(margins.first_point[instant]) + k) * nq]);
      rows.weights.push_back(margins.weights[instant * four + k]);
    }
    for (std::size_t j = 0; j < nq; ++j) rows.slopes.push_back(gradient[j] * box.radii[j]);
    program.least.push_back(-margins.margin[m]), program.price.push_back(margins.price);
  }
}

// Rows of one interval follow each other, whatever they are of: rows with the same columns are one block.
void add_more(const MoreRows& more, const std::vector<std::size_t>& order, PenaltyQp& program) {
  for (std::size_t k : order) {
    const auto begin = more.starts[k], end = more.starts[k + 1];
    program.columns.insert(program.columns.end(), more.columns.begin() + begin, more.columns.begin() + end);
    program.values.insert(program.values.end(), more.values.begin() + begin, more.values.begin() + end);
    program.starts.push_back(static_cast<std::int64_t>(program.columns.size()));
    program.least.push_back(more.least[k]), program.price.push_back(more.price[k]);
  }
}

void add_balls(const MoreRows& more, const std::vector<std::size_t>& order, PenaltyQp& program) {
  for (std::size_t k : order) {
    program.balls.append(more.balls, k);
    program.least.push_back(-1), program.price.push_back(more.ball_price[k]);
  }
}

}  // namespace

PenaltyQp program_of(const CurveGrid& grid, const RateBounds& bounds, const CurveColumns& columns,
                     const ModelWeights& weights, const StepBox& box, const std::vector<double>& points,
                     const std::vector<double>& b, const MoreRows& more, const DistanceMargins& margins,
                     const TakesPart& takes_part) {
  PenaltyQp program;
  program.num_variables = columns.num_variables;
  program.starts.push_back(0);
  set_cost_and_box(grid, columns, weights, box, points, b, program);
  Around around{grid, bounds, columns, weights, box, b, rates_of(grid, bounds, points), program};
  add_more(more, in_blocks(more, takes_part.more), program);
  for (std::size_t i = 0; i < grid.intervals(); ++i)
    for (std::size_t j = 0; j < bounds.coordinates(); j += num_lanes) around.add_rows(i, j);
  add_distances(columns, box, margins, takes_part.distances, program);
  add_balls(more, in_blocks(more.balls, takes_part.balls), program);
  return program;
}

ConvexStep convex_step(const CurveGrid& grid, const RateBounds& bounds, const CurveColumns& columns,
                       const ModelWeights& weights, const StepBox& box, const std::vector<double>& points,
                       const std::vector<double>& b, const MoreRows& more, const DistanceMargins& margins,
                       double tolerance, int max_steps) {
  const std::size_t nq = bounds.coordinates();
  TakesPart takes_part{likely_rows(more), likely_balls(more.balls), likely_rows(box, margins)};
  PenaltyQp program;
  PenaltySolution found;
  bool is_broken = true;
  while (is_broken) {
    program = program_of(grid, bounds, columns, weights, box, points, b, more, margins, takes_part);
    found = solve(program, tolerance, max_steps);
    is_broken = add_broken(columns, box, margins, found.x, takes_part.distances);
    is_broken |= add_broken(more, found.x, takes_part.more);
    is_broken |= add_broken(more.balls, found.x, takes_part.balls);
  }
  ConvexStep step{points, 0};
  for (std::size_t i = 1; i + 1 < grid.num_points; ++i)
    for (std::size_t j = 0; j < nq; ++j) {
      const double moved = found.x[static_cast<std::size_t>(columns.points[i * nq + j])] * box.radii[j];
      double& point = step.points[i * nq + j];
      point = std::min(std::max(point + moved, box.lower[j]), box.upper[j]);
    }
  const std::vector<double> here(program.c.size(), 0.0);
  step.decrease = (cost_of(program, here) - cost_of(program, found.x)) * duration_of(grid, b);
  return step;
}

}  // namespace wayproof
