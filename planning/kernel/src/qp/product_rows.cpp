#include "qp/product_rows.hpp"

#include <algorithm>
#include <type_traits>

#include "math/multiversion.hpp"

namespace wayproof {
namespace {

// A block: rows with the same columns and weights.
struct Rows {
  const std::int64_t* columns;
  const double *weights, *slopes;
  std::size_t num_weights, num_slopes, rows;
};

// Numbers of slopes that loops are compiled for, those of arms; 0 stands for any other. The order of additions is the
// same for all of them, and for every instruction set.
template <class Work>
[[gnu::always_inline]] inline void with_fixed_size(std::size_t count, const Work& work) {
  if (count == 7) return work(std::integral_constant<std::size_t, 7>{});
  if (count == 6) return work(std::integral_constant<std::size_t, 6>{});
  work(std::integral_constant<std::size_t, 0>{});
}

[[gnu::always_inline]] inline void add_scaled(double factor, const double* from, std::size_t count, double* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

WAYPROOF_MULTIVERSION
void rows_times(const Rows& b, const double* x, double* buffer, double* y) {
  with_fixed_size(b.num_slopes, [&](auto fixed) __attribute__((always_inline)) {
    const std::size_t count = fixed ? fixed : b.num_slopes;
    double local[fixed + 1];
    double* sum = fixed ? local : buffer;
    std::fill_n(sum, count, 0.0);
    for (std::size_t i = 0; i < b.num_weights; ++i)
      if (b.columns[i] >= 0) add_scaled(b.weights[i], x + b.columns[i], count, sum);
    for (std::size_t r = 0; r < b.rows; ++r) {
      double total = 0;
      for (std::size_t i = 0; i < count; ++i) total += b.slopes[r * count + i] * sum[i];
      y[r] = total;
    }
  });
}

WAYPROOF_MULTIVERSION
void add_transposed_rows(const Rows& b, const double* y, double scale, double* buffer, double* x) {
  with_fixed_size(b.num_slopes, [&](auto fixed) __attribute__((always_inline)) {
    const std::size_t count = fixed ? fixed : b.num_slopes;
    double local[fixed + 1];
    double* sum = fixed ? local : buffer;
    std::fill_n(sum, count, 0.0);
    for (std::size_t r = 0; r < b.rows; ++r) add_scaled(scale * y[r], b.slopes + r * count, count, sum);
    for (std::size_t i = 0; i < b.num_weights; ++i)
      if (b.columns[i] >= 0) add_scaled(b.weights[i], sum, count, x + b.columns[i]);
  });
}

// Adds the products of all pairs of weights with the square sum_r weight_r g_r g_r' of slopes.
WAYPROOF_MULTIVERSION
void add_row_squares(const Rows& b, const double* weight, double* buffer, Skyline& matrix) {
  with_fixed_size(b.num_slopes, [&](auto fixed) __attribute__((always_inline)) {
    const std::size_t count = fixed ? fixed : b.num_slopes;
    double local[fixed * fixed + 1];
    double* square = fixed ? local : buffer;
    std::fill_n(square, count * count, 0.0);
    for (std::size_t r = 0; r < b.rows; ++r) {
      const double* g = b.slopes + r * count;
      for (std::size_t i = 0; i < count; ++i) add_scaled(weight[r] * g[i], g, count, square + i * count);
    }
    for (std::size_t i = 0; i < b.num_weights; ++i)
      for (std::size_t k = 0; k < b.num_weights; ++k) {
        if (b.columns[k] < 0 || b.columns[i] < b.columns[k]) continue;
        const double factor = b.weights[i] * b.weights[k];
        for (std::size_t j = 0; j < count; ++j) {
          double* to = &matrix.at(static_cast<int>(b.columns[i] + j), static_cast<int>(b.columns[k]));
          if (i == k)
            add_scaled(factor, square + j * count, j + 1, to);
          else
            add_scaled(factor, square + j * count, count, to);
        }
      }
  });
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
  for (const Block& b : blocks_)
    rows_times(Rows{columns_of(b.begin), weights_of(b.begin), slopes_of(b.begin), p_.num_weights, p_.num_slopes,
                    b.end - b.begin},
               x, sum_.data(), y + b.begin);
}

void ProductBlocks::add_transposed(const double* y, double scale, double* x) {
  for (const Block& b : blocks_)
    add_transposed_rows(Rows{columns_of(b.begin), weights_of(b.begin), slopes_of(b.begin), p_.num_weights,
                             p_.num_slopes, b.end - b.begin},
                        y + b.begin, scale, sum_.data(), x);
}

void ProductBlocks::add_squares(const double* weight, Skyline& matrix) {
  for (const Block& b : blocks_)
    add_row_squares(Rows{columns_of(b.begin), weights_of(b.begin), slopes_of(b.begin), p_.num_weights, p_.num_slopes,
                         b.end - b.begin},
                    weight + b.begin, square_.data(), matrix);
}

}  // namespace wayproof
