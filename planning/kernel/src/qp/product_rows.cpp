#include "qp/product_rows.hpp"

#include <algorithm>

#include "math/multiversion.hpp"

namespace wayproof {
namespace {

// Adds sum_r weight_r g_r g_r' to a square.
WAYPROOF_MULTIVERSION
void add_slope_squares(const double* slopes, std::size_t rows, std::size_t count, const double* weight,
                       double* square) {
  for (std::size_t r = 0; r < rows; ++r) {
    const double* g = slopes + r * count;
    for (std::size_t i = 0; i < count; ++i) {
      const double left = weight[r] * g[i];
      for (std::size_t j = 0; j < count; ++j) square[i * count + j] += left * g[j];
    }
  }
}

void add_scaled(double factor, const double* from, std::size_t count, double* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

// Rows [rows][count] times x, in one order for every instruction set.
void rows_times(const double* values, std::size_t rows, std::size_t count, const double* x, double* y) {
  for (std::size_t r = 0; r < rows; ++r) {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += values[r * count + i] * x[i];
    y[r] = sum;
  }
}

}  // namespace

ProductBlocks::ProductBlocks(const ProductRows& rows)
    : p_(rows), sum_(p_.num_slopes), square_(p_.num_slopes * p_.num_slopes) {
  for (std::size_t k = 0; k < p_.rows(); ++k) {
    if (blocks_.empty() || !same(blocks_.back().begin, k)) blocks_.push_back({k, k});
    blocks_.back().end = k + 1;
  }
}

bool ProductBlocks::same(std::size_t a, std::size_t b) const {
  return std::equal(columns_of(a), columns_of(a) + p_.num_weights, columns_of(b)) &&
         std::equal(weights_of(a), weights_of(a) + p_.num_weights, weights_of(b));
}

void ProductBlocks::widen(std::vector<int>& first) const {
  for (const Block& b : blocks_) {
    const std::int64_t* columns = columns_of(b.begin);
    auto low = static_cast<std::int64_t>(first.size());
    for (std::size_t i = 0; i < p_.num_weights; ++i)
      if (columns[i] >= 0) low = std::min(low, columns[i]);
    for (std::size_t i = 0; i < p_.num_weights; ++i)
      for (std::size_t j = 0; columns[i] >= 0 && j < p_.num_slopes; ++j)
        first[columns[i] + j] = std::min(first[columns[i] + j], static_cast<int>(low));
  }
}

void ProductBlocks::times(const double* x, double* y) {
  const std::size_t count = p_.num_slopes;
  for (const Block& b : blocks_) {
    const std::int64_t* columns = columns_of(b.begin);
    std::fill(sum_.begin(), sum_.end(), 0.0);
    for (std::size_t i = 0; i < p_.num_weights; ++i)
      if (columns[i] >= 0) add_scaled(weights_of(b.begin)[i], x + columns[i], count, sum_.data());
    rows_times(slopes_of(b.begin), b.end - b.begin, count, sum_.data(), y + b.begin);
  }
}

void ProductBlocks::add_transposed(const double* y, double scale, double* x) {
  const std::size_t count = p_.num_slopes;
  for (const Block& b : blocks_) {
    const std::int64_t* columns = columns_of(b.begin);
    std::fill(sum_.begin(), sum_.end(), 0.0);
    for (std::size_t r = b.begin; r < b.end; ++r) add_scaled(scale * y[r], slopes_of(r), count, sum_.data());
    for (std::size_t i = 0; i < p_.num_weights; ++i)
      if (columns[i] >= 0) add_scaled(weights_of(b.begin)[i], sum_.data(), count, x + columns[i]);
  }
}

void ProductBlocks::add_squares(const double* weight, Skyline& matrix) {
  const std::size_t count = p_.num_slopes;
  for (const Block& b : blocks_) {
    const std::int64_t* columns = columns_of(b.begin);
    const double* weights = weights_of(b.begin);
    std::fill(square_.begin(), square_.end(), 0.0);
    add_slope_squares(slopes_of(b.begin), b.end - b.begin, count, weight + b.begin, square_.data());
    for (std::size_t i = 0; i < p_.num_weights; ++i)
      for (std::size_t k = 0; k < p_.num_weights; ++k) {
        if (columns[k] < 0 || columns[i] < columns[k]) continue;
        const double factor = weights[i] * weights[k];
        for (std::size_t j = 0; j < count; ++j)
          add_scaled(factor, &square_[j * count], i == k ? j + 1 : count,
                     &matrix.at(static_cast<int>(columns[i] + j), static_cast<int>(columns[k])));
      }
  }
}

}  // namespace wayproof
