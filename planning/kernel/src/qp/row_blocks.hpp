// RowBlocks: the rows of a penalty QP; the sparse ones in blocks of consecutive rows with the same columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "qp/dense_block.hpp"
#include "qp/penalty_qp.hpp"
#include "qp/skyline.hpp"

namespace wayproof {

class RowBlocks {
 public:
  // Of the program's rows A; it must outlive this.
  explicit RowBlocks(const PenaltyQp& program);

  // Lowers the first column of every row of A' A.
  void widen(std::vector<int>& first) const;

  // y = A x.
  void times(const std::vector<double>& x, std::vector<double>& y);
  // x += scale A' y.
  void add_transposed(const std::vector<double>& y, double scale, std::vector<double>& x);
  // matrix += A' diag(weight) A.
  void add_squares(const std::vector<double>& weight, Skyline& matrix);

 private:
  struct Block {
    std::size_t begin;
    int rows, width;
    int dense = -1;  // among the dense ones; -1: it is none
  };

  const std::int64_t* columns_of(const Block& b) const { return p_.columns.data() + p_.starts[b.begin]; }
  const double* values_of(const Block& b) const { return p_.values.data() + p_.starts[b.begin]; }
  bool same(std::size_t a, std::size_t b) const;

  const PenaltyQp& p_;
  std::vector<Block> blocks_;
  std::vector<DenseBlock> dense_;
  std::vector<double> local_, square_;
  std::size_t num_sparse_, num_before_products_;
  LaneBlocks lanes_;
  ProductBlocks products_;
};

}  // namespace wayproof
