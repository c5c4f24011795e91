// BallRows: rows of a penalty QP that keep vectors in the unit ball: |c_k + A_k x| <= 1, as loads are that are vectors.
//
// They are convex but not linear. The interior point method takes each as a row a . x >= -1 whose left side is
// -|c + A x|: a is its gradient where the method is, and its second derivative, times the multiplier, is in the normal
// equations (Boyd and Vandenberghe, "Convex Optimization", 2004, ch. 11).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "qp/dense_block.hpp"
#include "qp/skyline.hpp"

namespace wayproof {

struct BallRows {
  std::vector<std::int64_t> starts{0}, columns;  // of each ball, which its three components share; none twice
  std::vector<double> values;                    // of each ball [3][its columns], one after another
  std::vector<double> centers;                   // c, [balls][3]

  std::size_t size() const { return centers.size() / 3; }
  // c + A x of a ball.
  std::array<double, 3> vector(std::size_t ball, const std::vector<double>& x) const;
  // Appends a ball of others.
  void append(const BallRows& others, std::size_t ball);
};

class BallBlocks {
 public:
  // The rows must outlive this. Consecutive balls with the same columns are a block.
  explicit BallBlocks(const BallRows& balls);

  // Lowers the first column of every row of A' A.
  void widen(std::vector<int>& first) const;
  // y = -|c + A x|; what is below is at this x.
  void move_to(const std::vector<double>& x, double* y);
  // What `move_to` would give for a ball after a share of the step that `times` was last asked about.
  double value_after(std::size_t ball, double share) const;
  // y = a x of the gradients a, and x += scale a' y.
  void times(const std::vector<double>& x, double* y);
  void add_transposed(const double* y, double scale, std::vector<double>& x);
  // matrix += a' diag(weight) a, and the second derivatives times multipliers.
  void add_squares(const double* weight, const double* multiplier, Skyline& matrix);

 private:
  struct Block {
    std::size_t begin, end;
    DenseBlock rows;
  };

  const BallRows& p_;
  std::vector<Block> blocks_;
  std::vector<double> vectors_, changes_;          // c + A x, and A x of `times`, [balls][3]
  std::vector<double> normals_, inverse_lengths_;  // of vectors: directions [balls][3], and one over the lengths
  std::vector<double> local_, weights_;            // what is computed in
};

}  // namespace wayproof
