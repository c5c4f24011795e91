// Skyline: a symmetric positive definite matrix, and its Cholesky factor (George and Liu, "Computer Solution of Large
// Sparse Positive Definite Systems", 1981, ch. 4).
//
// It is gathered by rows, from the first nonzero to the diagonal. The factor's transpose is stored by rows from the
// diagonal to the last nonzero, all of one length with zeros behind: four rows at once are subtracted from those below
// them, in sequence, and no sum runs across lanes.
#pragma once

#include <cstddef>
#include <vector>

namespace wayproof {

class Skyline {
 public:
  // `first`: the column of every row's first entry, at most the row's own.
  explicit Skyline(std::vector<int> first);

  void clear();
  // Of row i and column j, first[i] <= j <= i. What is written to the seven entries behind a row's is in the next row,
  // or nowhere.
  double& at(int i, int j) { return entries_[start_[i] + static_cast<std::size_t>(j - first_[i])]; }

  void factor();
  // After `factor`: x becomes the solution of A y = x.
  void solve(std::vector<double>& x);

 private:
  std::vector<int> first_, last_;  // of every row; last_: the last row with an entry in a column, for whole panels
  std::vector<std::size_t> start_;
  std::vector<double> entries_;
  std::size_t stride_;
  std::vector<double> upper_, inverse_;  // the factor's rows, and one over their diagonals
  std::vector<double> right_;            // what is computed in
};

}  // namespace wayproof
