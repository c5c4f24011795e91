// BandMatrix: a square matrix with few diagonals, solved by elimination with exchanges of rows (Golub and Van Loan,
// "Matrix Computations", 4.3).
#pragma once

#include <cstddef>
#include <vector>

namespace wayproof {

class BandMatrix {
 public:
  BandMatrix(int size, int half_band);

  void clear();
  // |row - column| <= half_band.
  double& at(int row, int column) { return entries_[offset(row, column)]; }
  // x becomes the solution of A y = x, and the matrix its factor; false if it is singular.
  bool solve(std::vector<double>& x);

 private:
  // Rows have room for the entries that exchanges bring.
  std::size_t offset(int row, int column) const {
    return static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column - row + half_band_);
  }

  int size_, half_band_;
  std::size_t width_;
  std::vector<double> entries_;
};

}  // namespace wayproof
