// Skyline: a symmetric positive definite matrix, and its Cholesky factorisation in place (George and Liu, "Computer
// Solution of Large Sparse Positive Definite Systems", 1981, 4.2). Every row stores its entries from the first nonzero
// to the diagonal.
#pragma once

#include <cstddef>
#include <vector>

namespace wayproof {

class Skyline {
 public:
  // `first`: the column of every row's first entry, at most the row's own.
  explicit Skyline(std::vector<int> first);

  void clear();
  // Of row i and column j, first[i] <= j <= i.
  double& at(int i, int j) { return entries_[start_[i] + j - first_[i]]; }

  void factor();
  // After `factor`: x becomes the solution of A y = x.
  void solve(std::vector<double>& x) const;

 private:
  std::vector<int> first_, last_;  // of every row; last_: the last row with an entry in a column
  std::vector<std::size_t> start_;
  std::vector<double> entries_;
};

}  // namespace wayproof
