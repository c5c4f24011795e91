#include "soft_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "multiversion.hpp"

namespace wayproof {
namespace {

constexpr double to_the_wall = 0.99;
constexpr int pad = 4;

// In four sums, so that every instruction set adds in the same order.
inline double dot(const double* a, const double* b, int count) {
  double sums[pad] = {0, 0, 0, 0};
  int k = 0;
  for (; k + pad <= count; k += pad)
    for (int l = 0; l < pad; ++l) sums[l] += a[k + l] * b[k + l];
  for (; k < count; ++k) sums[0] += a[k] * b[k];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

// Rows [rows][width] times x.
WAYPROOF_MULTIVERSION
void times(const double* values, int rows, int width, const double* x, double* y) {
  for (int r = 0; r < rows; ++r) y[r] = dot(values + static_cast<std::ptrdiff_t>(r) * width, x, width);
}

// Adds sum_r weight_r v_r v_r' to a square; what is above its diagonal may be left out.
WAYPROOF_MULTIVERSION
void add_squares(const double* values, int rows, int width, const double* weight, double* square) {
  for (int r = 0; r < rows; ++r) {
    const double* v = values + static_cast<std::ptrdiff_t>(r) * width;
    for (int i = 0; i < width; ++i) {
      const double left = weight[r] * v[i];
      double* out = square + static_cast<std::ptrdiff_t>(i) * width;
      const int end = std::min(width, (i / pad + 1) * pad);
      for (int j = 0; j < end; ++j) out[j] += left * v[j];
    }
  }
}

// Adds sum_r weight_r v_r to a row.
WAYPROOF_MULTIVERSION
void add_rows(const double* values, int rows, int width, const double* weight, double* sum) {
  for (int r = 0; r < rows; ++r)
    for (int i = 0; i < width; ++i) sum[i] += weight[r] * values[static_cast<std::ptrdiff_t>(r) * width + i];
}

// Cholesky of rows that begin at `first`.
WAYPROOF_MULTIVERSION
void factor_skyline(const int* first, const std::size_t* start, double* entries, int n) {
  for (int i = 0; i < n; ++i) {
    double* row = entries + start[i];
    for (int j = first[i]; j <= i; ++j) {
      const double* other = entries + start[j];
      const int from = std::max(first[i], first[j]);
      const double rest = row[j - first[i]] - dot(row + (from - first[i]), other + (from - first[j]), j - from);
      row[j - first[i]] = j < i ? rest / other[j - first[j]] : std::sqrt(std::max(rest, 1e-14));
    }
  }
}

// A symmetric positive definite matrix: of every row what lies between its first entry and the diagonal.
class Skyline {
 public:
  explicit Skyline(const SoftRows& p) : first_(p.num_variables), start_(p.num_variables + 1) {
    for (int i = 0; i < p.num_variables; ++i) first_[i] = i;
    for (std::size_t k = 0; k + 1 < p.starts.size(); ++k) {
      if (p.starts[k] == p.starts[k + 1]) continue;
      const auto low = *std::min_element(p.columns.begin() + p.starts[k], p.columns.begin() + p.starts[k + 1]);
      for (auto e = p.starts[k]; e < p.starts[k + 1]; ++e)
        first_[p.columns[e]] = std::min(first_[p.columns[e]], static_cast<int>(low));
    }
    for (int i = 0; i < p.num_variables; ++i) start_[i + 1] = start_[i] + i - first_[i] + 1;
    entries_.resize(start_.back());
  }

  void clear() { std::fill(entries_.begin(), entries_.end(), 0.0); }
  double& at(int i, int j) { return entries_[start_[i] + j - first_[i]]; }

  void factor() { factor_skyline(first_.data(), start_.data(), entries_.data(), static_cast<int>(first_.size())); }

  void solve(std::vector<double>& x) const {
    const int n = static_cast<int>(first_.size());
    for (int i = 0; i < n; ++i) {
      const double* row = &entries_[start_[i]] - first_[i];
      double sum = x[i];
      for (int k = first_[i]; k < i; ++k) sum -= row[k] * x[k];
      x[i] = sum / row[i];
    }
    for (int i = n - 1; i >= 0; --i) {
      const double* row = &entries_[start_[i]] - first_[i];
      x[i] /= row[i];
      for (int k = first_[i]; k < i; ++k) x[k] -= row[k] * x[i];
    }
  }

 private:
  std::vector<int> first_;
  std::vector<std::size_t> start_;
  std::vector<double> entries_;
};

// The rows in blocks of those that follow one another and have the same columns.
class Blocks {
 public:
  explicit Blocks(const SoftRows& p) : p_(p) {
    for (std::size_t k = 0; k < p.least.size(); ++k) {
      if (blocks_.empty() || !same(blocks_.back().begin, k)) blocks_.push_back({k, 0, static_cast<int>(p.starts[k + 1] - p.starts[k])});
      ++blocks_.back().rows;
      widest_ = std::max(widest_, blocks_.back().width);
    }
    local_.resize(widest_), square_.resize(static_cast<std::size_t>(widest_) * widest_);
  }

  void times(const std::vector<double>& x, std::vector<double>& y) {
    y.resize(p_.least.size());
    for (const Block& b : blocks_) {
      const std::int64_t* columns = columns_of(b);
      for (int i = 0; i < b.width; ++i) local_[i] = x[columns[i]];
      wayproof::times(values_of(b), b.rows, b.width, local_.data(), &y[b.begin]);
    }
  }

  // x += scale A' y.
  void add_transposed(const std::vector<double>& y, double scale, std::vector<double>& x) {
    for (const Block& b : blocks_) {
      std::fill_n(local_.begin(), b.width, 0.0);
      add_rows(values_of(b), b.rows, b.width, &y[b.begin], local_.data());
      const std::int64_t* columns = columns_of(b);
      for (int i = 0; i < b.width; ++i) x[columns[i]] += scale * local_[i];
    }
  }

  void add_squares(const std::vector<double>& weight, Skyline& matrix) {
    for (const Block& b : blocks_) {
      std::fill_n(square_.begin(), static_cast<std::size_t>(b.width) * b.width, 0.0);
      wayproof::add_squares(values_of(b), b.rows, b.width, &weight[b.begin], square_.data());
      const std::int64_t* columns = columns_of(b);
      for (int i = 0; i < b.width; ++i)
        for (int j = 0; j <= i; ++j) {
          const auto high = std::max(columns[i], columns[j]), low = std::min(columns[i], columns[j]);
          matrix.at(static_cast<int>(high), static_cast<int>(low)) += square_[static_cast<std::size_t>(i) * b.width + j];
        }
    }
  }

 private:
  struct Block {
    std::size_t begin;
    int rows, width;
  };

  const std::int64_t* columns_of(const Block& b) const { return p_.columns.data() + p_.starts[b.begin]; }
  const double* values_of(const Block& b) const { return p_.values.data() + p_.starts[b.begin]; }
  bool same(std::size_t a, std::size_t b) const {
    return std::equal(p_.columns.begin() + p_.starts[a], p_.columns.begin() + p_.starts[a + 1],
                      p_.columns.begin() + p_.starts[b], p_.columns.begin() + p_.starts[b + 1]);
  }

  const SoftRows& p_;
  std::vector<Block> blocks_;
  int widest_ = 0;
  std::vector<double> local_, square_;
};

// Slacks s > 0 with their multipliers z > 0, and a step of both.
struct Cone {
  std::vector<double> s, z, ds, dz;

  Cone(std::size_t count, double slack, double multiplier)
      : s(count, slack), z(count, multiplier), ds(count), dz(count) {}

  double product() const {
    double sum = 0;
    for (std::size_t i = 0; i < s.size(); ++i) sum += s[i] * z[i];
    return sum;
  }
  double product_after(double primal, double dual) const {
    double sum = 0;
    for (std::size_t i = 0; i < s.size(); ++i) sum += (s[i] + primal * ds[i]) * (z[i] + dual * dz[i]);
    return sum;
  }
  static double longest(const std::vector<double>& x, const std::vector<double>& dx) {
    double step = 1e300;
    for (std::size_t i = 0; i < x.size(); ++i)
      if (dx[i] < 0) step = std::min(step, -x[i] / dx[i]);
    return step;
  }
  void move(double primal, double dual) {
    for (std::size_t i = 0; i < s.size(); ++i) s[i] += primal * ds[i], z[i] += dual * dz[i];
  }
};

// Rows a . x + e - w = least; w has the multiplier y, e = what the row lacks has price - y.
class Search {
 public:
  explicit Search(const SoftRows& program)
      : p(program), n(p.num_variables), m(p.least.size()), blocks(p), matrix(p), x(n), rx(n), ry(m), dx(n),
        low(n, 0, 1), high(n, 0, 1), over(m, 0, 0), under(m, 0, 0) {
    for (int i = 0; i < n; ++i) {
      x[i] = std::clamp(0.0, p.lower[i] + 0.05 * (p.upper[i] - p.lower[i]), p.upper[i] - 0.05 * (p.upper[i] - p.lower[i]));
      low.s[i] = x[i] - p.lower[i], high.s[i] = p.upper[i] - x[i];
      low.z[i] = start / low.s[i], high.z[i] = start / high.s[i];
    }
    blocks.times(x, along);
    for (std::size_t k = 0; k < m; ++k) {
      const double spare = along[k] - p.least[k], floor = 0.1;
      over.s[k] = std::max(spare, 0.0) + floor, under.s[k] = std::max(-spare, 0.0) + floor;
      over.z[k] = std::min(start / over.s[k], 0.5 * p.price[k]);
      under.z[k] = p.price[k] - over.z[k];
    }
  }

  SoftSolution run(double tolerance, int max_steps) {
    const double count = 2.0 * (n + m);
    int step = 0;
    double gap = 0;
    for (;; ++step) {
      gap = (low.product() + high.product() + over.product() + under.product()) / count;
      const double wrong = residuals();
      if ((gap < tolerance && wrong < 10 * tolerance) || step == max_steps) break;
      factor();
      aim(0, false);
      const double primal = std::min(1.0, reach(true)), dual = std::min(1.0, reach(false));
      const double after = (low.product_after(primal, dual) + high.product_after(primal, dual) +
                            over.product_after(primal, dual) + under.product_after(primal, dual)) / count;
      const double ratio = after / gap;
      aim(gap * std::max(ratio * ratio * ratio, 1e-6), true);
      const double p_step = std::min(1.0, to_the_wall * reach(true)), d_step = std::min(1.0, to_the_wall * reach(false));
      for (int i = 0; i < n; ++i) x[i] += p_step * dx[i];
      for (Cone* cone : {&low, &high, &over, &under}) cone->move(p_step, d_step);
    }
    return {x, step, gap};
  }

 private:
  static constexpr double start = 0.05;

  // rx: of the stationarity in x; ry: of the rows. The slacks of the box and the multipliers of what rows
  // lack are kept exact.
  double residuals() {
    double worst = 0;
    for (int i = 0; i < n; ++i) rx[i] = p.c[i] + p.q[i] * x[i] - low.z[i] + high.z[i];
    blocks.add_transposed(over.z, -1, rx);
    blocks.times(x, along);
    for (std::size_t k = 0; k < m; ++k) {
      ry[k] = along[k] + under.s[k] - over.s[k] - p.least[k];
      worst = std::max(worst, std::abs(ry[k]));
    }
    for (double r : rx) worst = std::max(worst, std::abs(r));
    return worst;
  }

  void factor() {
    matrix.clear();
    for (int i = 0; i < n; ++i) matrix.at(i, i) = p.q[i] + low.z[i] / low.s[i] + high.z[i] / high.s[i] + 1e-12;
    weight.resize(m);
    for (std::size_t k = 0; k < m; ++k) weight[k] = 1 / (over.s[k] / over.z[k] + under.s[k] / under.z[k]);
    blocks.add_squares(weight, matrix);
    matrix.factor();
  }

  // What s dz + z ds is to be.
  static double wanted(const Cone& cone, std::size_t i, double mu, bool corrects) {
    return mu - cone.s[i] * cone.z[i] - (corrects ? cone.ds[i] * cone.dz[i] : 0);
  }

  // The step towards complementarity products of mu.
  void aim(double mu, bool corrects) {
    std::vector<double>& right = dx;
    need.resize(m), pull.resize(m), t_low.resize(n), t_high.resize(n), t_over.resize(m), t_under.resize(m);
    for (int i = 0; i < n; ++i) {
      t_low[i] = wanted(low, i, mu, corrects), t_high[i] = wanted(high, i, mu, corrects);
      right[i] = -rx[i] + t_low[i] / low.s[i] - t_high[i] / high.s[i];
    }
    for (std::size_t k = 0; k < m; ++k) {
      t_over[k] = wanted(over, k, mu, corrects), t_under[k] = wanted(under, k, mu, corrects);
      // a dx + de - dw = -ry, dw = (t_over - w dy) / y, de = (t_under + e dy) / (price - y).
      need[k] = -ry[k] + t_over[k] / over.z[k] - t_under[k] / under.z[k];
      pull[k] = weight[k] * need[k];
    }
    blocks.add_transposed(pull, 1, right);
    matrix.solve(dx);
    blocks.times(dx, along);
    for (int i = 0; i < n; ++i) {
      low.ds[i] = dx[i], high.ds[i] = -dx[i];
      low.dz[i] = (t_low[i] - low.z[i] * dx[i]) / low.s[i];
      high.dz[i] = (t_high[i] + high.z[i] * dx[i]) / high.s[i];
    }
    for (std::size_t k = 0; k < m; ++k) {
      const double dy = weight[k] * (need[k] - along[k]);
      over.dz[k] = dy, under.dz[k] = -dy;
      over.ds[k] = (t_over[k] - over.s[k] * dy) / over.z[k];
      under.ds[k] = (t_under[k] + under.s[k] * dy) / under.z[k];
    }
  }

  double reach(bool primal) const {
    double step = 1e300;
    for (const Cone* cone : {&low, &high, &over, &under})
      step = std::min(step, primal ? Cone::longest(cone->s, cone->ds) : Cone::longest(cone->z, cone->dz));
    return step;
  }

  const SoftRows& p;
  int n;
  std::size_t m;
  Blocks blocks;
  Skyline matrix;
  std::vector<double> x, rx, ry, dx, along, weight, need, pull, t_low, t_high, t_over, t_under;
  Cone low, high, over, under;
};

}  // namespace

SoftSolution solve(const SoftRows& program, double tolerance, int max_steps) {
  return Search(program).run(tolerance, max_steps);
}

}  // namespace wayproof
