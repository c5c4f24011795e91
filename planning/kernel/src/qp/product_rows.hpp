// ProductRows: rows of a penalty QP whose entries are products of a weight and a slope, a_ij = weight_i slope_j, as
// those of distances along a spline are: i runs over control points and j over coordinates, whose columns are in
// sequence.
//
// Consecutive rows with the same columns and weights are a block, whose products share a matrix of slopes alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "qp/skyline.hpp"

namespace wayproof {

struct ProductRows {
  std::size_t num_weights = 0, num_slopes = 0;
  std::vector<std::int64_t> columns;    // [rows][weights], of the first slope; -1 for none
  std::vector<double> weights, slopes;  // [rows][weights], [rows][slopes]

  std::size_t rows() const { return num_weights ? weights.size() / num_weights : 0; }
};

class ProductBlocks {
 public:
  // A block: rows with the same columns and weights.
  struct Rows {
    const std::int64_t* columns;
    const double *weights, *slopes;
    std::size_t num_weights, num_slopes, rows;
  };

  // The rows must outlive this.
  explicit ProductBlocks(const ProductRows& rows);

  // Lowers the first column of every row of A' A.
  void widen(std::vector<int>& first) const;
  // y = A x, and x += scale A' y, y of these rows alone.
  void times(const std::vector<double>& x, double* y);
  void add_transposed(const double* y, double scale, std::vector<double>& x);
  // matrix += A' diag(weight) A.
  void add_squares(const double* weight, Skyline& matrix);

 private:
  struct Block {
    std::size_t begin, end;
  };

  const std::int64_t* columns_of(std::size_t row) const { return &p_.columns[row * p_.num_weights]; }
  const double* weights_of(std::size_t row) const { return &p_.weights[row * p_.num_weights]; }
  Rows rows_of(const Block& block) const;
  bool same(std::size_t a, std::size_t b) const;
  bool has_columns_of(const Block& a, const Block& b) const;

  const ProductRows& p_;
  std::vector<Block> blocks_;
  bool in_lanes_;
  std::vector<double> padded_;                    // slopes, with zeros behind those of a row to fill all lanes
  std::vector<double> block_weights_;             // [blocks][weights]
  std::vector<double> sum_, square_, variables_;  // what is computed in
  std::vector<double> squares_, factors_;         // the same, of blocks with the same columns
};

}  // namespace wayproof
