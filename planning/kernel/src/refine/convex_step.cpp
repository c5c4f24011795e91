#include "refine/convex_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "refine/active_distances.hpp"

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

  // Appends the columns and values of four control points and of b at both ends of an interval, scaled.
  void add(std::size_t interval, std::size_t coordinate, const double* by_point, double by_low, double by_high,
           double scale, double least) {
    const std::size_t nq = bounds.coordinates();
    const auto first = static_cast<std::size_t>(grid.first_point[interval]);
    for (std::size_t k = 0; k < four; ++k) entry(columns.points[(first + k) * nq + coordinate], scale * by_point[k]);
    entry(columns.path_velocity[interval], scale * by_low);
    entry(columns.path_velocity[interval + 1], scale * by_high);
    end_row(least, weights.rate_price);
  }

  void entry(std::int64_t column, double value) {
    if (column >= 0) program.columns.push_back(column), program.values.push_back(value);
  }

  void end_row(double least, double price) {
    program.starts.push_back(static_cast<std::int64_t>(program.columns.size()));
    program.least.push_back(least), program.price.push_back(price);
  }

  // r'' b + r' u between both bounds.
  void acceleration_rows(std::size_t i) {
    const double u = (b[i + 1] - b[i]) / (2 * grid.step);
    for (std::size_t j = 0; j < bounds.coordinates(); ++j)
      for (std::size_t end = 0; end < 2; ++end) {
        const std::size_t k = (2 * i + end) * bounds.coordinates() + j, w = (2 * i + end) * four;
        const double current = rates.acceleration(i, end, j, b[i + end], u);
        const double at_high = current / bounds.highest[j] - 1, at_low = current / bounds.lowest[j] - 1;
        const bool has_high = at_high > weights.least_acceleration - 1,
                   has_low = at_low > weights.least_acceleration - 1;
        if (!has_high && !has_low) continue;
        const double unit = box.radii[j] / bounds.acceleration[j], slope = rates.first[k] / (2 * grid.step);
        double by_point[four];
        for (std::size_t p = 0; p < four; ++p)
          by_point[p] = (grid.second[w + p] * b[i + end] + grid.first[w + p] * u) * unit;
        const double by_low = (end ? -slope : rates.second[k] - slope) * b[i];
        const double by_high = (end ? rates.second[k] + slope : slope) * b[i + 1];
        if (has_high) add(i, j, by_point, by_low, by_high, -1 / bounds.highest[j], at_high);
        if (has_low) add(i, j, by_point, by_low, by_high, -1 / bounds.lowest[j], at_low);
      }
  }

  // |r'| sqrt(b) at the low end of every interval but the first.
  void velocity_rows(std::size_t i) {
    const double root = std::sqrt(b[i]);
    for (std::size_t j = 0; j < bounds.coordinates(); ++j) {
      const double current = rates.by_velocity[i * bounds.coordinates() + j] * root, size = std::abs(current);
      if (!(size > weights.least_speed)) continue;
      const double unit = std::copysign(box.radii[j] / bounds.velocity[j], current) * root;
      const double* first = &grid.first[2 * i * four];
      const auto begin = static_cast<std::size_t>(grid.first_point[i]);
      for (std::size_t k = 0; k < four; ++k)
        entry(columns.points[(begin + k) * bounds.coordinates() + j], -first[k] * unit);
      entry(columns.path_velocity[i], -size / 2);
      end_row(size - 1, weights.rate_price);
    }
  }

  // |r'''| b^(3/2) at both ends.
  void jerk_rows(std::size_t i) {
    for (std::size_t j = 0; j < bounds.coordinates(); ++j)
      for (std::size_t end = 0; end < 2; ++end) {
        const double cubed = b[i + end] * std::sqrt(b[i + end]);
        const double current = rates.third[i * bounds.coordinates() + j] * cubed, size = std::abs(current);
        if (!(size > weights.least_speed)) continue;
        const double unit = std::copysign(box.radii[j] / bounds.jerk[j], current) * cubed;
        double by_point[four];
        for (std::size_t p = 0; p < four; ++p) by_point[p] = grid.third[i * four + p] * unit;
        add(i, j, by_point, end ? 0 : 1.5 * size, end ? 1.5 * size : 0, -1, size - 1);
      }
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

void add_more(const MoreRows& more, PenaltyQp& program) {
  const auto begin = static_cast<std::int64_t>(program.columns.size());
  program.columns.insert(program.columns.end(), more.columns.begin(), more.columns.end());
  program.values.insert(program.values.end(), more.values.begin(), more.values.end());
  for (std::size_t k = 1; k < more.starts.size(); ++k) program.starts.push_back(begin + more.starts[k]);
  program.least.insert(program.least.end(), more.least.begin(), more.least.end());
  program.price.insert(program.price.end(), more.price.begin(), more.price.end());
}

}  // namespace

PenaltyQp program_of(const CurveGrid& grid, const RateBounds& bounds, const CurveColumns& columns,
                     const ModelWeights& weights, const StepBox& box, const std::vector<double>& points,
                     const std::vector<double>& b, const MoreRows& more, const DistanceMargins& margins,
                     const std::vector<char>& takes_part) {
  PenaltyQp program;
  program.num_variables = columns.num_variables;
  program.starts.push_back(0);
  set_cost_and_box(grid, columns, weights, box, points, b, program);
  Around around{grid, bounds, columns, weights, box, b, rates_of(grid, bounds, points), program};
  for (std::size_t i = 0; i < grid.intervals(); ++i) around.acceleration_rows(i);
  for (std::size_t i = 1; i < grid.intervals(); ++i) around.velocity_rows(i);
  for (std::size_t i = 0; i < grid.intervals() && !bounds.jerk.empty(); ++i) around.jerk_rows(i);
  add_more(more, program);
  add_distances(columns, box, margins, takes_part, program);
  return program;
}

ConvexStep convex_step(const CurveGrid& grid, const RateBounds& bounds, const CurveColumns& columns,
                       const ModelWeights& weights, const StepBox& box, const std::vector<double>& points,
                       const std::vector<double>& b, const MoreRows& more, const DistanceMargins& margins,
                       double tolerance, int max_steps) {
  const std::size_t nq = bounds.coordinates();
  std::vector<char> takes_part = likely_rows(box, margins);
  PenaltyQp program;
  PenaltySolution found;
  do {
    program = program_of(grid, bounds, columns, weights, box, points, b, more, margins, takes_part);
    found = solve(program, tolerance, max_steps);
  } while (add_broken(columns, box, margins, found.x, takes_part));
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
