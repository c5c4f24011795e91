#include "qp/skyline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/lanes.hpp"
#include "math/multiversion.hpp"

namespace wayproof {
namespace {

// Rows that are subtracted from the others at once.
constexpr int panel = 4;

// to[0..count) -= factor from[0..count), and what is behind by zeros.
[[gnu::always_inline]] inline void subtract(double* to, double factor, const double* from, int count) {
  for (int k = 0; k < count; k += static_cast<int>(num_lanes)) store(to + k, load(to + k) - factor * load(from + k));
}

// Finishes the rows of a panel: each less those above it, over the root of its diagonal.
[[gnu::always_inline]] inline void factor_panel(double* rows, std::size_t stride, const int* last, double* inverse,
                                                int begin) {
  for (int p = 0; p < panel; ++p) {
    double* row = rows + static_cast<std::size_t>(p) * stride;
    for (int q = 0; q < p; ++q) {
      const double* above = rows + static_cast<std::size_t>(q) * stride + (p - q);
      subtract(row, above[0], above, last[begin + q] - (begin + p) + 1);
    }
    const double diagonal = std::sqrt(std::max(row[0], 1e-14));
    const double scale = inverse[begin + p] = 1 / diagonal;
    for (int k = 0; k <= last[begin + p] - (begin + p); k += static_cast<int>(num_lanes))
      store(row + k, scale * load(row + k));
  }
}

WAYPROOF_MULTIVERSION
void factor_rows(double* rows, std::size_t stride, const int* last, double* inverse, int count) {
  for (int begin = 0; begin < count; begin += panel) {
    double* r = rows + static_cast<std::size_t>(begin) * stride;
    factor_panel(r, stride, last, inverse, begin);
    const int end = last[begin + panel - 1];
    for (int i = begin + panel; i <= end; ++i) {
      const double *r0 = r + (i - begin), *r1 = r0 + stride - 1, *r2 = r1 + stride - 1, *r3 = r2 + stride - 1;
      const double f0 = *r0, f1 = *r1, f2 = *r2, f3 = *r3;
      double* row = rows + static_cast<std::size_t>(i) * stride;
      for (int k = 0; k <= end - i; k += static_cast<int>(num_lanes))
        store(row + k,
              load(row + k) - ((f0 * load(r0 + k) + f1 * load(r1 + k)) + (f2 * load(r2 + k) + f3 * load(r3 + k))));
    }
  }
}

WAYPROOF_MULTIVERSION
void solve_rows(const double* rows, std::size_t stride, const int* last, const double* inverse, int count, double* x) {
  for (int i = 0; i < count; ++i) {
    x[i] *= inverse[i];
    subtract(x + i + 1, x[i], rows + static_cast<std::size_t>(i) * stride + 1, last[i] - i);
  }
  for (int i = count - 1; i >= 0; --i) {
    const double* row = rows + static_cast<std::size_t>(i) * stride + 1;
    Lanes sum = {};
    for (int k = 0; k < last[i] - i; k += static_cast<int>(num_lanes)) sum += load(row + k) * load(x + i + 1 + k);
    x[i] = (x[i] - sum_of(sum)) * inverse[i];
  }
}

}  // namespace

Skyline::Skyline(std::vector<int> first) : first_(std::move(first)), start_(first_.size() + 1) {
  const std::size_t n = first_.size(), padded = (n + panel - 1) / panel * panel;
  for (std::size_t i = 0; i < n; ++i) start_[i + 1] = start_[i] + i - static_cast<std::size_t>(first_[i]) + 1;
  entries_.resize(start_.back() + num_lanes), last_.resize(padded);
  for (std::size_t i = 0; i < padded; ++i) last_[i] = static_cast<int>(i);
  for (std::size_t i = 0; i < n; ++i)
    for (int j = first_[i]; j <= static_cast<int>(i); ++j) last_[j] = static_cast<int>(i);
  int widest = 0;
  for (std::size_t i = 0; i < padded; ++i) widest = std::max(widest, last_[i] - static_cast<int>(i) + 1);
  stride_ = static_cast<std::size_t>(widest + panel) + num_lanes;
  upper_.resize(padded * stride_ + num_lanes), inverse_.resize(padded), right_.resize(padded + stride_ + num_lanes);
}

void Skyline::clear() { std::fill(entries_.begin(), entries_.end(), 0.0); }

void Skyline::factor() {
  std::fill(upper_.begin(), upper_.end(), 0.0);
  const std::size_t n = first_.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double* from = &entries_[start_[i]];
    for (auto j = static_cast<std::size_t>(first_[i]); j <= i; ++j) upper_[j * stride_ + (i - j)] = *from++;
  }
  for (std::size_t i = n; i < last_.size(); ++i) upper_[i * stride_] = 1;
  factor_rows(upper_.data(), stride_, last_.data(), inverse_.data(), static_cast<int>(last_.size()));
}

void Skyline::solve(std::vector<double>& x) {
  std::fill(std::copy(x.begin(), x.end(), right_.begin()), right_.end(), 0.0);
  solve_rows(upper_.data(), stride_, last_.data(), inverse_.data(), static_cast<int>(last_.size()), right_.data());
  std::copy_n(right_.begin(), x.size(), x.begin());
}

}  // namespace wayproof
