#include "math/band_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace wayproof {

BandMatrix::BandMatrix(int size, int half_band)
    : size_(size),
      half_band_(half_band),
      width_(3 * static_cast<std::size_t>(half_band) + 1),
      entries_(size * width_) {}

void BandMatrix::clear() { std::fill(entries_.begin(), entries_.end(), 0.0); }

bool BandMatrix::solve(std::vector<double>& x) {
  for (int i = 0; i < size_; ++i) {
    const int last_row = std::min(i + half_band_, size_ - 1), last = std::min(i + 2 * half_band_, size_ - 1);
    int pivot = i;
    for (int r = i + 1; r <= last_row; ++r)
      if (std::abs(at(r, i)) > std::abs(at(pivot, i))) pivot = r;
    if (!(std::abs(at(pivot, i)) > 0)) return false;
    if (pivot != i) {
      for (int c = i; c <= last; ++c) std::swap(at(i, c), at(pivot, c));
      std::swap(x[i], x[pivot]);
    }
    const double* top = &at(i, i);
    for (int r = i + 1; r <= last_row; ++r) {
      double* row = &at(r, i);
      if (row[0] == 0) continue;
      const double factor = row[0] / top[0];
      for (int c = 1; c <= last - i; ++c) row[c] -= factor * top[c];
      x[r] -= factor * x[i];
    }
  }
  for (int i = size_ - 1; i >= 0; --i) {
    for (int c = i + 1; c <= std::min(i + 2 * half_band_, size_ - 1); ++c) x[i] -= at(i, c) * x[c];
    x[i] /= at(i, i);
  }
  return true;
}

}  // namespace wayproof
