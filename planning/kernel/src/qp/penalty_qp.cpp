#include "qp/penalty_qp.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "qp/pairs.hpp"
#include "qp/row_blocks.hpp"
#include "qp/skyline.hpp"

namespace wayproof {
namespace {

constexpr double to_the_wall = 0.99, unbounded = 1e300;
// Rows whose largest entries are between these stay in the units that the model chose, in which residuals are measured.
constexpr double small_row = 1e-3, large_row = 1e3;
// A step as long as this leaves no residual but rounding.
constexpr double long_step = 0.9;

bool is_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

// Divides rows of another order of magnitude than 1 by a power of two, after which their largest entry is at least 1
// and below 2, and multiplies their price: beside rows of jerks, say, the normal equations lose the digits of small
// ones.
void scale_rows(PenaltyQp& program) {
  const std::size_t num_sparse = program.starts.size() - 1;
  ProductRows& products = program.products;
  // The unit of a row, to which `least` and `price` are brought.
  const auto unit_of = [&program](std::size_t k, double largest) {
    if (!(largest > 0) || (small_row < largest && largest < large_row)) return 1.0;
    const double size = std::exp2(std::ilogb(largest));
    program.least[k] /= size;
    program.price[k] *= size;
    return size;
  };
  const auto scale = [&unit_of](std::size_t k, double largest, double* values, const double* end) {
    const double size = unit_of(k, largest);
    for (double* value = values; size != 1 && value != end; ++value) *value /= size;
  };
  const auto largest_of = [](const double* begin, const double* end) {
    double largest = 0;
    for (const double* value = begin; value != end; ++value) largest = std::max(largest, std::abs(*value));
    return largest;
  };
  for (std::size_t k = 0; k < num_sparse; ++k) {
    double *values = program.values.data() + program.starts[k], *end = program.values.data() + program.starts[k + 1];
    scale(k, largest_of(values, end), values, end);
  }
  std::size_t next = num_sparse;
  for (LaneRows::Line& line : program.lanes.lines)
    for (std::size_t l = 0; l < num_lanes; ++l) {
      if (!(line.taken >> l & 1U)) continue;
      double largest = 0;
      for (std::size_t k = l; k < line.values.size(); k += num_lanes)
        largest = std::max(largest, std::abs(line.values[k]));
      const double size = unit_of(next++, largest);
      for (std::size_t k = l; k < line.values.size(); k += num_lanes) line.values[k] /= size;
    }
  for (std::size_t r = 0; r < products.rows(); ++r) {
    double* slopes = products.slopes.data() + r * products.num_slopes;
    double weight = 0;
    for (std::size_t i = r * products.num_weights; i < (r + 1) * products.num_weights; ++i)
      if (products.columns[i] != -1) weight = std::max(weight, std::abs(products.weights[i]));
    scale(next + r, weight * largest_of(slopes, slopes + products.num_slopes), slopes, slopes + products.num_slopes);
  }
}

// Of the normal equations, all zero.
Skyline normal_matrix(int num_variables, const RowBlocks& rows, const BallBlocks& balls) {
  std::vector<int> first(static_cast<std::size_t>(num_variables));
  std::iota(first.begin(), first.end(), 0);
  rows.widen(first), balls.widen(first);
  return Skyline(std::move(first));
}

// Rows a . x + e - w = least; w has the multiplier y, the shortfall e has price - y.
class Search {
 public:
  // Carefully: rows of balls are kept exactly, and steps are short where these are curved.
  Search(const PenaltyQp& program, bool carefully)
      : p(program),
        is_careful(carefully),
        n(p.num_variables),
        m(p.least.size()),
        num_linear(m - p.balls.size()),
        blocks(p),
        balls(p.balls),
        matrix(normal_matrix(n, blocks, balls)),
        x(n),
        rx(n),
        ry(m),
        dx(n),
        low(n, 0, 1),
        high(n, 0, 1),
        rows(m),
        over(rows.over),
        under(rows.under) {
    for (int i = 0; i < n; ++i) {
      x[i] =
          std::clamp(0.0, p.lower[i] + 0.05 * (p.upper[i] - p.lower[i]), p.upper[i] - 0.05 * (p.upper[i] - p.lower[i]));
      low.s[i] = x[i] - p.lower[i], high.s[i] = p.upper[i] - x[i];
      low.z[i] = start / low.s[i], high.z[i] = start / high.s[i];
    }
    blocks.times(x, at);
    balls.move_to(x, at.data() + num_linear);
    for (std::size_t k = 0; k < m; ++k) {
      const double spare = at[k] - p.least[k], floor = 0.1;
      over.s[k] = std::max(spare, 0.0) + floor, under.s[k] = std::max(-spare, 0.0) + floor;
      over.z[k] = std::min(start / over.s[k], 0.5 * p.price[k]);
      under.z[k] = p.price[k] - over.z[k];
    }
  }

  PenaltySolution run(double tolerance, int max_steps) {
    const double count = 2.0 * (n + m);
    int step = 0;
    double gap = 0, last_wrong = unbounded, shortest = 0;
    for (;; ++step) {
      gap = (low.product() + high.product() + over.product() + under.product()) / count;
      const double wrong = residuals();
      // A step leaves the share of the residuals that it falls short of; what remains of a long one is rounding, and
      // further steps would only add to it.
      const bool is_exhausted = shortest > long_step && wrong > 0.5 * last_wrong;
      if ((gap < tolerance && (wrong < 10 * tolerance || is_exhausted)) || step == max_steps) break;
      last_wrong = wrong;
      factor();
      aim(0, false);
      const double primal = std::min(1.0, reach(true)), dual = std::min(1.0, reach(false));
      const double after = (low.product_after(primal, dual) + high.product_after(primal, dual) +
                            over.product_after(primal, dual) + under.product_after(primal, dual)) /
                           count;
      const double ratio = after / gap;
      aim(gap * std::max(ratio * ratio * ratio, 1e-6), true);
      const double d_step = std::min(1.0, to_the_wall * reach(false));
      double p_step = std::min(1.0, to_the_wall * reach(true));
      if (is_careful) p_step = within_balls(p_step, d_step, gap * count);
      if (!is_finite(dx)) break;
      shortest = std::min(p_step, d_step);
      for (int i = 0; i < n; ++i) x[i] += p_step * dx[i];
      for (std::size_t k = 0; k < num_linear; ++k) at[k] += p_step * along[k];
      for (ComplementaryPairs* pair : {&low, &high, &over, &under}) pair->move(p_step, d_step);
      // Slacks take up what is not linear; else it is a residual, which the next step takes up.
      for (std::size_t k = num_linear; is_careful && k < m; ++k) under.s[k] += shortfall(k - num_linear, p_step);
    }
    return {x, step, gap};
  }

 private:
  static constexpr double start = 0.05;

  void add_transposed(const std::vector<double>& y, double scale, std::vector<double>& to) {
    blocks.add_transposed(y, scale, to);
    balls.add_transposed(y.data() + num_linear, scale, to);
  }

  // rx: stationarity in x; ry: rows. The slacks of the box and the multipliers of the shortfalls are kept exact.
  double residuals() {
    double worst = 0;
    balls.move_to(x, at.data() + num_linear);
    for (int i = 0; i < n; ++i) rx[i] = p.c[i] + p.q[i] * x[i] - low.z[i] + high.z[i];
    add_transposed(over.z, -1, rx);
    for (std::size_t k = 0; k < m; ++k) {
      ry[k] = at[k] + under.s[k] - over.s[k] - p.least[k];
      worst = std::max(worst, std::abs(ry[k]));
    }
    for (double r : rx) worst = std::max(worst, std::abs(r));
    return worst;
  }

  void factor() {
    matrix.clear();
    for (int i = 0; i < n; ++i) matrix.at(i, i) = p.q[i] + low.z[i] / low.s[i] + high.z[i] / high.s[i] + 1e-12;
    weight.resize(m);
    rows.weights(weight.data());
    blocks.add_squares(weight, matrix);
    balls.add_squares(weight.data() + num_linear, over.z.data() + num_linear, matrix);
    matrix.factor();
  }

  // Target of s dz + z ds.
  static double wanted(const ComplementaryPairs& pair, std::size_t i, double mu, bool corrects) {
    return mu - pair.s[i] * pair.z[i] - (corrects ? pair.ds[i] * pair.dz[i] : 0);
  }

  // The step towards complementarity products of mu.
  void aim(double mu, bool corrects) {
    std::vector<double>& right = dx;
    need.resize(m), pull.resize(m), t_low.resize(n), t_high.resize(n), t_over.resize(m), t_under.resize(m);
    for (int i = 0; i < n; ++i) {
      t_low[i] = wanted(low, i, mu, corrects), t_high[i] = wanted(high, i, mu, corrects);
      right[i] = -rx[i] + t_low[i] / low.s[i] - t_high[i] / high.s[i];
    }
    rows.targets(mu, corrects, t_over.data(), t_under.data());
    rows.needs(ry.data(), t_over.data(), t_under.data(), weight.data(), need.data(), pull.data());
    add_transposed(pull, 1, right);
    matrix.solve(dx);
    blocks.times(dx, along);
    balls.times(dx, along.data() + num_linear);
    for (int i = 0; i < n; ++i) {
      low.ds[i] = dx[i], high.ds[i] = -dx[i];
      low.dz[i] = (t_low[i] - low.z[i] * dx[i]) / low.s[i];
      high.dz[i] = (t_high[i] + high.z[i] * dx[i]) / high.s[i];
    }
    rows.steps(t_over.data(), t_under.data(), weight.data(), need.data(), along.data());
  }

  // How far a ball's value falls short of the linear one after a share of the step.
  double shortfall(std::size_t ball, double share) const {
    const double linear = balls.value_after(ball, 0) + share * along[num_linear + ball];
    return std::max(0.0, linear - balls.value_after(ball, share));
  }

  // A step of at most this length after which what the lengths of vectors fall short of their linear values costs no
  // more than the products of slacks and multipliers now: else steps go far along balls, and back.
  double within_balls(double step, double dual_step, double products) const {
    for (int halving = 0; halving < 10; ++halving, step /= 2) {
      double cost = 0;
      for (std::size_t k = num_linear; k < m; ++k)
        cost += shortfall(k - num_linear, step) * (under.z[k] + dual_step * under.dz[k]);
      if (cost <= products) break;
    }
    return step;
  }

  double reach(bool primal) const {
    const auto of = [primal](const ComplementaryPairs& pair) { return primal ? pair.reach_of_s() : pair.reach_of_z(); };
    return std::min({of(low), of(high), of(over), of(under)});
  }

  const PenaltyQp& p;
  bool is_careful;
  int n;
  std::size_t m, num_linear;
  RowBlocks blocks;
  BallBlocks balls;
  Skyline matrix;
  std::vector<double> x, rx, ry, dx, weight, need, pull, t_low, t_high, t_over, t_under;
  std::vector<double> at, along;  // A x and A dx, with the lengths of balls and their change to first order
  ComplementaryPairs low, high;
  RowPairs rows;
  ComplementaryPairs &over, &under;
};

}  // namespace

PenaltySolution solve(PenaltyQp program, double tolerance, int max_steps) {
  scale_rows(program);
  PenaltySolution found = Search(program, false).run(tolerance, max_steps);
  if (found.steps < max_steps || program.balls.size() == 0) return found;
  // Steps went far along balls and back, as they may where little else holds them.
  PenaltySolution other = Search(program, true).run(tolerance, max_steps);
  return cost_of(program, other.x) < cost_of(program, found.x) ? other : found;
}

double cost_of(const PenaltyQp& program, const std::vector<double>& x) {
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += x[i] * (program.c[i] + program.q[i] * x[i] / 2);
  std::vector<double> along;
  RowBlocks(program).times(x, along);
  BallBlocks(program.balls).move_to(x, along.data() + (along.size() - program.balls.size()));
  for (std::size_t k = 0; k < along.size(); ++k) sum += program.price[k] * std::max(0.0, program.least[k] - along[k]);
  return sum;
}

}  // namespace wayproof
