// DenseBlock: rows of a penalty QP with the same many columns, as those of loads are, which depend on every coordinate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "qp/skyline.hpp"

namespace wayproof {

class DenseBlock {
 public:
  // Rows of `width` values each, one after another; no column is there twice.
  DenseBlock(const std::int64_t* columns, const double* values, std::size_t rows, std::size_t width);

  // y = A x, and x += scale A' y, y of these rows alone.
  void times(const double* x, double* y);
  void add_transposed(const double* y, double scale, double* x);
  // matrix += A' diag(weight) A.
  void add_squares(const double* weight, Skyline& matrix);
  // The same with a symmetric weight for every three rows, [rows / 3][3][3].
  void add_weighted_squares(const double* weights, Skyline& matrix);

 private:
  void add_square(Skyline& matrix);

  // Columns in sequence: `count` of them, the first at `begin` in the block.
  struct Run {
    std::size_t begin, count;
    std::int64_t column;
  };

  std::size_t rows_, width_, stride_;
  std::vector<std::int64_t> columns_;  // ascending
  std::vector<Run> runs_;
  std::vector<double> values_;                   // [rows][stride], zero beyond the width
  std::vector<double> local_, scaled_, square_;  // what is computed in
};

}  // namespace wayproof
