#include "speeds/speed_passes.hpp"

#include <algorithm>
#include <cmath>

#include "speeds/speed_program.hpp"

namespace wayproof {
namespace {

// As planning/retime/toppra/toppra_passes.py has them.
constexpr double speed_reduction = 1e-8;
constexpr int most_tries = 10;

// The rows of one cell after another.
class CellRows {
 public:
  CellRows(std::span<const double> a, std::span<const double> b, std::size_t cells)
      : a_(a), b_(b), count_(a.size() / cells), rows_(count_ + 2) {}

  // With bounds on x at the end of the cell, from zero on.
  std::span<const SpeedRow> of(std::size_t cell, double step, double most_after) {
    rows_[0] = {-step, -1, 0};
    rows_[1] = {step, 1, -most_after};
    for (std::size_t k = 0; k < count_; ++k) rows_[k + 2] = {a_[cell * count_ + k], b_[cell * count_ + k], -1};
    return rows_;
  }

 private:
  std::span<const double> a_, b_;
  std::size_t count_;
  std::vector<SpeedRow> rows_;
};

}  // namespace

std::vector<double> squared_speeds(std::span<const double> edges, std::span<const double> a, std::span<const double> b,
                                   std::span<const double> caps) {
  const std::size_t count = edges.size() - 1;
  CellRows rows(a, b, count);
  SpeedProgram program;
  SpeedProgram::Active active;
  std::vector<double> controllable(count + 1, 0.0), x(count + 1, 0.0);
  for (std::size_t i = count; i-- > 0;) {
    const double step = 2 * (edges[i + 1] - edges[i]);
    const auto found = program.largest_speed(rows.of(i, step, controllable[i + 1]), caps[i], active);
    if (!found) return {};
    controllable[i] = found->x;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double step = 2 * (edges[i + 1] - edges[i]), most_after = controllable[i + 1];
    const auto all = rows.of(i, step, most_after);
    auto u = SpeedProgram::largest_acceleration(all, x[i]);
    for (int left = most_tries; !u && --left > 0;) {
      x[i] = std::max(x[i] - speed_reduction, 0.999 * x[i]);
      u = SpeedProgram::largest_acceleration(all, x[i]);
    }
    if (!u) return {};
    const double after = x[i] + step * *u;
    x[i + 1] = std::min(std::max({after - speed_reduction, 0.9999 * after, 0.0}), most_after);
  }
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); }) ? x : std::vector<double>();
}

}  // namespace wayproof
