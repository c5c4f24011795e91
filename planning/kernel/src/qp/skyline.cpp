#include "qp/skyline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/dot.hpp"
#include "math/multiversion.hpp"

namespace wayproof {
namespace {

// Column by column: the entries of a column do not depend on each other.
WAYPROOF_MULTIVERSION
void factor_skyline(const int* first, const int* last, const std::size_t* start, double* entries, int n) {
  for (int j = 0; j < n; ++j) {
    double* column = entries + start[j];
    double& diagonal = column[j - first[j]];
    const int count = j - first[j];
    diagonal = std::sqrt(std::max(diagonal - dot(column, column, count), 1e-14));
    for (int i = j + 1; i <= last[j]; ++i) {
      if (first[i] > j) continue;
      double* row = entries + start[i];
      const int from = std::max(first[i], first[j]);
      const double rest = row[j - first[i]] - dot(row + (from - first[i]), column + (from - first[j]), j - from);
      row[j - first[i]] = rest / diagonal;
    }
  }
}

}  // namespace

Skyline::Skyline(std::vector<int> first) : first_(std::move(first)), start_(first_.size() + 1) {
  for (std::size_t i = 0; i < first_.size(); ++i) start_[i + 1] = start_[i] + i - first_[i] + 1;
  entries_.resize(start_.back()), last_.resize(first_.size());
  for (std::size_t i = 0; i < first_.size(); ++i)
    for (int j = first_[i]; j <= static_cast<int>(i); ++j) last_[j] = static_cast<int>(i);
}

void Skyline::clear() { std::fill(entries_.begin(), entries_.end(), 0.0); }

void Skyline::factor() {
  factor_skyline(first_.data(), last_.data(), start_.data(), entries_.data(), static_cast<int>(first_.size()));
}

void Skyline::solve(std::vector<double>& x) const {
  const int n = static_cast<int>(first_.size());
  for (int i = 0; i < n; ++i) {
    const double* row = &entries_[start_[i]];
    const int count = i - first_[i];
    double sum = x[i];
    for (int k = 0; k < count; ++k) sum -= row[k] * x[first_[i] + k];
    x[i] = sum / row[count];
  }
  for (int i = n - 1; i >= 0; --i) {
    const double* row = &entries_[start_[i]];
    const int count = i - first_[i];
    x[i] /= row[count];
    for (int k = 0; k < count; ++k) x[first_[i] + k] -= row[k] * x[i];
  }
}

}  // namespace wayproof
