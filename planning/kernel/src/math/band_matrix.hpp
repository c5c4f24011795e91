// BandMatrix: a square matrix with few diagonals, solved by elimination with exchanges of rows (Golub and Van Loan,
// "Matrix Computations", 4.3).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace wayproof {

template <int half_band>
class BandMatrix {
 public:
  explicit BandMatrix(int size) : size_(size), entries_(static_cast<std::size_t>(size) * width) {}

  void clear() { std::fill(entries_.begin(), entries_.end(), 0.0); }
  // |row - column| <= half_band.
  double& at(int row, int column) { return entries_[offset(row, column)]; }
  // x becomes the solution of A y = x, and the matrix its factor; false if it is singular.
  bool solve(std::vector<double>& x);

 private:
  // Rows have room for the entries that exchanges bring; beyond the last column these are zero.
  static constexpr int reach = 2 * half_band;
  static constexpr std::size_t width = 3 * static_cast<std::size_t>(half_band) + 1;
  static std::size_t offset(int row, int column) {
    return static_cast<std::size_t>(row) * width + static_cast<std::size_t>(column - row + half_band);
  }

  int size_;
  std::vector<double> entries_;
};

template <int half_band>
bool BandMatrix<half_band>::solve(std::vector<double>& x) {
  for (int i = 0; i < size_; ++i) {
    const int last_row = std::min(i + half_band, size_ - 1);
    int pivot = i;
    for (int r = i + 1; r <= last_row; ++r)
      if (std::abs(at(r, i)) > std::abs(at(pivot, i))) pivot = r;
    if (!(std::abs(at(pivot, i)) > 0)) return false;
    double* top = &at(i, i);
    if (pivot != i) {
      double* other = &at(pivot, i);
      for (int c = 0; c <= reach; ++c) std::swap(top[c], other[c]);
      std::swap(x[i], x[pivot]);
    }
    const double inverse = 1 / top[0];
    for (int r = i + 1; r <= last_row; ++r) {
      double* row = &at(r, i);
      if (row[0] == 0) continue;
      const double factor = row[0] * inverse;
      for (int c = 1; c <= reach; ++c) row[c] -= factor * top[c];
      x[r] -= factor * x[i];
    }
  }
  for (int i = size_ - 1; i >= 0; --i) {
    for (int c = i + 1; c <= std::min(i + reach, size_ - 1); ++c) x[i] -= at(i, c) * x[c];
    x[i] /= at(i, i);
  }
  return true;
}

}  // namespace wayproof
