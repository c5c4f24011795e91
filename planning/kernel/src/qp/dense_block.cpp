#include "qp/dense_block.hpp"

#include <algorithm>
#include <numeric>

#include "math/multiversion.hpp"

namespace wayproof {
namespace {

// Sums run in this many lanes, in the same order for every instruction set.
constexpr std::size_t lanes = 8;

WAYPROOF_MULTIVERSION
void rows_times(const double* values, std::size_t rows, std::size_t stride, const double* x, double* y) {
  for (std::size_t r = 0; r < rows; ++r) {
    double sums[lanes] = {};
    for (std::size_t j = 0; j < stride; j += lanes)
      for (std::size_t l = 0; l < lanes; ++l) sums[l] += values[r * stride + j + l] * x[j + l];
    y[r] = ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
  }
}

WAYPROOF_MULTIVERSION
void add_rows(const double* values, std::size_t rows, std::size_t stride, const double* weight, double scale,
              double* sum) {
  for (std::size_t r = 0; r < rows; ++r) {
    const double factor = scale * weight[r];
    for (std::size_t j = 0; j < stride; ++j) sum[j] += factor * values[r * stride + j];
  }
}

// square = sum_r weight_r v_r v_r', where it is not above the diagonal. `lanes` entries at once stay in registers
// through all rows.
WAYPROOF_MULTIVERSION
void row_squares(const double* values, std::size_t rows, std::size_t width, std::size_t stride, const double* weight,
                 double* scaled, double* square) {
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t j = 0; j < stride; ++j) scaled[r * stride + j] = weight[r] * values[r * stride + j];
  for (std::size_t i = 0; i < width; ++i)
    for (std::size_t j = 0; j <= i; j += lanes) {
      double sums[lanes] = {};
      for (std::size_t r = 0; r < rows; ++r)
        for (std::size_t l = 0; l < lanes; ++l) sums[l] += scaled[r * stride + i] * values[r * stride + j + l];
      for (std::size_t l = 0; l < lanes; ++l) square[i * stride + j + l] = sums[l];
    }
}

}  // namespace

DenseBlock::DenseBlock(const std::int64_t* columns, const double* values, std::size_t rows, std::size_t width)
    : rows_(rows),
      width_(width),
      stride_((width + lanes - 1) / lanes * lanes),
      columns_(width),
      values_(rows * stride_),
      local_(stride_),
      scaled_(rows * stride_),
      square_(stride_ * stride_) {
  std::vector<std::size_t> order(width);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [columns](std::size_t a, std::size_t b) { return columns[a] < columns[b]; });
  for (std::size_t i = 0; i < width; ++i) {
    columns_[i] = columns[order[i]];
    for (std::size_t r = 0; r < rows; ++r) values_[r * stride_ + i] = values[r * width + order[i]];
    if (runs_.empty() || columns_[i] != columns_[i - 1] + 1) runs_.push_back({i, 0, columns_[i]});
    ++runs_.back().count;
  }
}

void DenseBlock::times(const double* x, double* y) {
  for (std::size_t i = 0; i < width_; ++i) local_[i] = x[columns_[i]];
  std::fill(local_.begin() + static_cast<std::ptrdiff_t>(width_), local_.end(), 0.0);
  rows_times(values_.data(), rows_, stride_, local_.data(), y);
}

void DenseBlock::add_transposed(const double* y, double scale, double* x) {
  std::fill(local_.begin(), local_.end(), 0.0);
  add_rows(values_.data(), rows_, stride_, y, scale, local_.data());
  for (std::size_t i = 0; i < width_; ++i) x[columns_[i]] += local_[i];
}

void DenseBlock::add_squares(const double* weight, Skyline& matrix) {
  row_squares(values_.data(), rows_, width_, stride_, weight, scaled_.data(), square_.data());
  for (std::size_t i = 0; i < width_; ++i)
    for (const Run& run : runs_) {
      if (run.begin > i) break;
      const double* from = &square_[i * stride_ + run.begin];
      double* to = &matrix.at(static_cast<int>(columns_[i]), static_cast<int>(run.column));
      const std::size_t count = std::min(run.count, i + 1 - run.begin);
      for (std::size_t k = 0; k < count; ++k) to[k] += from[k];
    }
}

}  // namespace wayproof
