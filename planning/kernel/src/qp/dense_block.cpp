#include "qp/dense_block.hpp"

#include <algorithm>
#include <numeric>

#include "math/lanes.hpp"
#include "math/multiversion.hpp"

namespace wayproof {
namespace {

WAYPROOF_MULTIVERSION
void rows_times(const double* values, std::size_t rows, std::size_t stride, const double* x, double* y) {
  for (std::size_t r = 0; r < rows; ++r) {
    Lanes sums = {};
    for (std::size_t j = 0; j < stride; j += num_lanes) sums += load(values + r * stride + j) * load(x + j);
    y[r] = sum_of(sums);
  }
}

WAYPROOF_MULTIVERSION
void add_rows(const double* values, std::size_t rows, std::size_t stride, const double* weight, double scale,
              double* sum) {
  for (std::size_t r = 0; r < rows; ++r) {
    const double factor = scale * weight[r];
    for (std::size_t j = 0; j < stride; j += num_lanes) add_to(sum + j, factor * load(values + r * stride + j));
  }
}

// Adds the products of `count` entries of rows from `scaled` on with `chunks` times eight of `values`, summed over
// rows.
template <std::size_t count, std::size_t chunks>
[[gnu::always_inline]] inline void add_products(const double* scaled, const double* values, std::size_t rows,
                                                std::size_t stride, double* square) {
  Lanes sums[count][chunks] = {};
  for (std::size_t r = 0; r < rows; ++r, scaled += stride, values += stride)
    for (std::size_t c = 0; c < chunks; ++c) {
      const Lanes v = load(values + c * num_lanes);
      for (std::size_t i = 0; i < count; ++i) sums[i][c] += scaled[i] * v;
    }
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < chunks; ++c) store(square + i * stride + c * num_lanes, sums[i][c]);
}

WAYPROOF_MULTIVERSION
void scale_rows(const double* values, std::size_t rows, std::size_t stride, const double* weight, double* scaled) {
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t j = 0; j < stride; j += num_lanes)
      store(scaled + r * stride + j, weight[r] * load(values + r * stride + j));
}

// Every three rows times a matrix [3][3].
WAYPROOF_MULTIVERSION
void mix_rows(const double* values, std::size_t rows, std::size_t stride, const double* weights, double* mixed) {
  for (std::size_t r = 0; r < rows; r += 3, weights += 9, values += 3 * stride, mixed += 3 * stride)
    for (std::size_t j = 0; j < stride; j += num_lanes) {
      const Lanes x = load(values + j), y = load(values + stride + j), z = load(values + 2 * stride + j);
      for (std::size_t i = 0; i < 3; ++i)
        store(mixed + i * stride + j, (weights[3 * i] * x + weights[3 * i + 1] * y) + weights[3 * i + 2] * z);
    }
}

// square = sum_r scaled_r v_r', where it is not above the diagonal. Four rows of it at once stay in registers through
// all rows of the block.
WAYPROOF_MULTIVERSION
void row_squares(const double* values, std::size_t rows, std::size_t stride, const double* scaled, double* square) {
  for (std::size_t i = 0; i < stride; i += 4) {
    std::size_t j = 0;
    for (; j + num_lanes <= i; j += 2 * num_lanes)
      add_products<4, 2>(scaled + i, values + j, rows, stride, square + i * stride + j);
    if (j <= i) add_products<4, 1>(scaled + i, values + j, rows, stride, square + i * stride + j);
  }
}

}  // namespace

DenseBlock::DenseBlock(const std::int64_t* columns, const double* values, std::size_t rows, std::size_t width)
    : rows_(rows),
      width_(width),
      stride_((width + num_lanes - 1) / num_lanes * num_lanes),
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
  scale_rows(values_.data(), rows_, stride_, weight, scaled_.data());
  add_square(matrix);
}

void DenseBlock::add_weighted_squares(const double* weights, Skyline& matrix) {
  mix_rows(values_.data(), rows_, stride_, weights, scaled_.data());
  add_square(matrix);
}

void DenseBlock::add_square(Skyline& matrix) {
  row_squares(values_.data(), rows_, stride_, scaled_.data(), square_.data());
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
