#include "qp/row_blocks.hpp"

#include <algorithm>

#include "math/dot.hpp"
#include "math/multiversion.hpp"

namespace wayproof {
namespace {

// Blocks of more columns are computed as dense ones.
constexpr int widest_sparse = 8;

// Rows [rows][width] times x.
WAYPROOF_MULTIVERSION
void rows_times(const double* values, int rows, int width, const double* x, double* y) {
  for (int r = 0; r < rows; ++r) y[r] = dot(values + static_cast<std::ptrdiff_t>(r) * width, x, width);
}

// Adds sum_r weight_r v_r v_r' to a square; entries above its diagonal may be left out.
WAYPROOF_MULTIVERSION
void add_row_squares(const double* values, int rows, int width, const double* weight, double* square) {
  for (int r = 0; r < rows; ++r) {
    const double* v = values + static_cast<std::ptrdiff_t>(r) * width;
    for (int i = 0; i < width; ++i) {
      const double left = weight[r] * v[i];
      double* out = square + static_cast<std::ptrdiff_t>(i) * width;
      const int end = std::min(width, (i / pad + 1) * pad);
      for (int j = 0; j < end; ++j) out[j] += left * v[j];
    }
  }
}

// Adds sum_r weight_r v_r to a row.
WAYPROOF_MULTIVERSION
void add_rows(const double* values, int rows, int width, const double* weight, double* sum) {
  for (int r = 0; r < rows; ++r)
    for (int i = 0; i < width; ++i) sum[i] += weight[r] * values[static_cast<std::ptrdiff_t>(r) * width + i];
}

}  // namespace

RowBlocks::RowBlocks(const PenaltyQp& program)
    : p_(program),
      num_sparse_(p_.starts.size() - 1),
      num_before_products_(num_sparse_ + p_.lanes.rows),
      lanes_(p_.lanes),
      products_(p_.products) {
  for (std::size_t k = 0; k < num_sparse_; ++k) {
    if (blocks_.empty() || !same(blocks_.back().begin, k))
      blocks_.push_back({k, 0, static_cast<int>(p_.starts[k + 1] - p_.starts[k])});
    ++blocks_.back().rows;
  }
  int widest = 0;
  for (Block& b : blocks_) {
    if (b.width > widest_sparse) {
      b.dense = static_cast<int>(dense_.size());
      dense_.emplace_back(columns_of(b), values_of(b), static_cast<std::size_t>(b.rows),
                          static_cast<std::size_t>(b.width));
    } else {
      widest = std::max(widest, b.width);
    }
  }
  local_.resize(widest), square_.resize(static_cast<std::size_t>(widest) * widest);
}

void RowBlocks::widen(std::vector<int>& first) const {
  for (const Block& b : blocks_) {
    if (b.width == 0) continue;
    const std::int64_t* columns = columns_of(b);
    const int low = static_cast<int>(*std::min_element(columns, columns + b.width));
    for (int i = 0; i < b.width; ++i) first[columns[i]] = std::min(first[columns[i]], low);
  }
  lanes_.widen(first);
  products_.widen(first);
}

void RowBlocks::times(const std::vector<double>& x, std::vector<double>& y) {
  y.resize(p_.least.size());
  for (const Block& b : blocks_) {
    if (b.dense >= 0) {
      dense_[b.dense].times(x.data(), &y[b.begin]);
      continue;
    }
    const std::int64_t* columns = columns_of(b);
    for (int i = 0; i < b.width; ++i) local_[i] = x[columns[i]];
    rows_times(values_of(b), b.rows, b.width, local_.data(), &y[b.begin]);
  }
  lanes_.times(x, y.data() + num_sparse_);
  products_.times(x, y.data() + num_before_products_);
}

void RowBlocks::add_transposed(const std::vector<double>& y, double scale, std::vector<double>& x) {
  for (const Block& b : blocks_) {
    if (b.dense >= 0) {
      dense_[b.dense].add_transposed(&y[b.begin], scale, x.data());
      continue;
    }
    std::fill_n(local_.begin(), b.width, 0.0);
    add_rows(values_of(b), b.rows, b.width, &y[b.begin], local_.data());
    const std::int64_t* columns = columns_of(b);
    for (int i = 0; i < b.width; ++i) x[columns[i]] += scale * local_[i];
  }
  lanes_.add_transposed(y.data() + num_sparse_, scale, x);
  products_.add_transposed(y.data() + num_before_products_, scale, x);
}

void RowBlocks::add_squares(const std::vector<double>& weight, Skyline& matrix) {
  for (const Block& b : blocks_) {
    if (b.dense >= 0) {
      dense_[b.dense].add_squares(&weight[b.begin], matrix);
      continue;
    }
    std::fill_n(square_.begin(), static_cast<std::size_t>(b.width) * b.width, 0.0);
    add_row_squares(values_of(b), b.rows, b.width, &weight[b.begin], square_.data());
    const std::int64_t* columns = columns_of(b);
    for (int i = 0; i < b.width; ++i)
      for (int j = 0; j <= i; ++j) {
        const auto high = std::max(columns[i], columns[j]), low = std::min(columns[i], columns[j]);
        matrix.at(static_cast<int>(high), static_cast<int>(low)) += square_[static_cast<std::size_t>(i) * b.width + j];
      }
  }
  lanes_.add_squares(weight.data() + num_sparse_, matrix);
  products_.add_squares(weight.data() + num_before_products_, matrix);
}

bool RowBlocks::same(std::size_t a, std::size_t b) const {
  return std::equal(p_.columns.begin() + p_.starts[a], p_.columns.begin() + p_.starts[a + 1],
                    p_.columns.begin() + p_.starts[b], p_.columns.begin() + p_.starts[b + 1]);
}

}  // namespace wayproof
