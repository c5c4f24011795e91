#include "qp/product_rows.hpp"

#include <algorithm>
#include <array>

#include "math/lanes.hpp"
#include "math/multiversion.hpp"

namespace wayproof {
namespace {

using Rows = ProductBlocks::Rows;

[[gnu::always_inline]] inline void add_scaled(double factor, const double* from, std::size_t count, double* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

WAYPROOF_MULTIVERSION
void rows_times(const Rows& b, const double* x, double* sum, double* y) {
  std::fill_n(sum, b.num_slopes, 0.0);
  for (std::size_t i = 0; i < b.num_weights; ++i)
    if (b.columns[i] >= 0) add_scaled(b.weights[i], x + b.columns[i], b.num_slopes, sum);
  for (std::size_t r = 0; r < b.rows; ++r) {
    double total = 0;
    for (std::size_t i = 0; i < b.num_slopes; ++i) total += b.slopes[r * b.num_slopes + i] * sum[i];
    y[r] = total;
  }
}

WAYPROOF_MULTIVERSION
void add_transposed_rows(const Rows& b, const double* y, double scale, double* sum, double* x) {
  std::fill_n(sum, b.num_slopes, 0.0);
  for (std::size_t r = 0; r < b.rows; ++r) add_scaled(scale * y[r], b.slopes + r * b.num_slopes, b.num_slopes, sum);
  for (std::size_t i = 0; i < b.num_weights; ++i)
    if (b.columns[i] >= 0) add_scaled(b.weights[i], sum, b.num_slopes, x + b.columns[i]);
}

// Adds the products of all pairs of weights with the square sum_r weight_r g_r g_r' of slopes.
WAYPROOF_MULTIVERSION
void add_row_squares(const Rows& b, const double* weight, double* square, Skyline& matrix) {
  const std::size_t count = b.num_slopes;
  std::fill_n(square, count * count, 0.0);
  for (std::size_t r = 0; r < b.rows; ++r) {
    const double* g = b.slopes + r * count;
    for (std::size_t i = 0; i < count; ++i) add_scaled(weight[r] * g[i], g, count, square + i * count);
  }
  for (std::size_t i = 0; i < b.num_weights; ++i)
    for (std::size_t k = 0; k < b.num_weights; ++k) {
      if (b.columns[k] < 0 || b.columns[i] < b.columns[k]) continue;
      const double factor = b.weights[i] * b.weights[k];
      for (std::size_t j = 0; j < count; ++j)
        add_scaled(factor, square + j * count, i == k ? j + 1 : count,
                   &matrix.at(static_cast<int>(b.columns[i] + j), static_cast<int>(b.columns[k])));
    }
}

// Of a row of a square, 1 up to the diagonal and 0 above it.
constexpr auto not_above = [] {
  std::array<std::array<double, num_lanes>, num_lanes> ones{};
  for (std::size_t i = 0; i < num_lanes; ++i)
    for (std::size_t k = 0; k <= i; ++k) ones[i][k] = 1;
  return ones;
}();

// The same for at most as many slopes as there are lanes, with zeros behind them: room is needed behind x and rows of
// the matrix, to which zeros are added.
WAYPROOF_MULTIVERSION
void lanes_times(const Rows& b, const double* x, double* y) {
  Lanes sum = {};
  for (std::size_t i = 0; i < b.num_weights; ++i)
    if (b.columns[i] >= 0) sum += b.weights[i] * load(x + b.columns[i]);
  for (std::size_t r = 0; r < b.rows; ++r) y[r] = sum_of(load(b.slopes + r * num_lanes) * sum);
}

WAYPROOF_MULTIVERSION
void add_transposed_lanes(const Rows& b, const double* y, double scale, double* x) {
  Lanes sum = {};
  for (std::size_t r = 0; r < b.rows; ++r) sum += (scale * y[r]) * load(b.slopes + r * num_lanes);
  for (std::size_t i = 0; i < b.num_weights; ++i)
    if (b.columns[i] >= 0) add_to(x + b.columns[i], b.weights[i] * sum);
}

// square = sum_r weight_r g_r g_r'.
WAYPROOF_MULTIVERSION
void square_lanes(const Rows& b, const double* weight, double* square) {
  Lanes sums[num_lanes] = {};
  for (std::size_t r = 0; r < b.rows; ++r) {
    const double* g = b.slopes + r * num_lanes;
    const Lanes all = weight[r] * load(g);
    for (std::size_t i = 0; i < num_lanes; ++i) sums[i] += g[i] * all;
  }
  for (std::size_t i = 0; i < num_lanes; ++i) store(square + i * num_lanes, sums[i]);
}

// Adds the squares of consecutive blocks with the same columns, each times the products of its weights. `factors`: a
// number of each block.
WAYPROOF_MULTIVERSION
void add_lane_squares(const Rows& first, const double* weights, std::size_t blocks, const double* squares,
                      double* factors, Skyline& matrix) {
  for (std::size_t i = 0; i < first.num_weights; ++i)
    for (std::size_t k = 0; k < first.num_weights; ++k) {
      if (first.columns[k] < 0 || first.columns[i] < first.columns[k]) continue;
      for (std::size_t b = 0; b < blocks; ++b)
        factors[b] = weights[b * first.num_weights + i] * weights[b * first.num_weights + k];
      for (std::size_t j = 0; j < first.num_slopes; ++j) {
        Lanes sum = {};
        for (std::size_t b = 0; b < blocks; ++b) sum += factors[b] * load(squares + (b * num_lanes + j) * num_lanes);
        if (i == k) sum *= load(not_above[j].data());
        add_to(&matrix.at(static_cast<int>(first.columns[i] + j), static_cast<int>(first.columns[k])), sum);
      }
    }
}

}  // namespace

ProductBlocks::ProductBlocks(const ProductRows& rows)
    : p_(rows), in_lanes_(p_.num_slopes <= num_lanes), sum_(p_.num_slopes), square_(p_.num_slopes * p_.num_slopes) {
  if (in_lanes_) {
    padded_.resize(p_.rows() * num_lanes);
    for (std::size_t k = 0; k < p_.rows(); ++k)
      std::copy_n(&p_.slopes[k * p_.num_slopes], p_.num_slopes, &padded_[k * num_lanes]);
  }
  for (std::size_t k = 0; k < p_.rows(); ++k) {
    if (blocks_.empty() || !same(blocks_.back().begin, k)) blocks_.push_back({k, k});
    blocks_.back().end = k + 1;
  }
  if (!in_lanes_) return;
  for (const Block& b : blocks_)
    block_weights_.insert(block_weights_.end(), weights_of(b.begin), weights_of(b.begin) + p_.num_weights);
  squares_.resize(blocks_.size() * num_lanes * num_lanes), factors_.resize(blocks_.size());
}

bool ProductBlocks::has_columns_of(const Block& a, const Block& b) const {
  return std::equal(columns_of(a.begin), columns_of(a.begin) + p_.num_weights, columns_of(b.begin));
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

ProductBlocks::Rows ProductBlocks::rows_of(const Block& b) const {
  const double* slopes = in_lanes_ ? &padded_[b.begin * num_lanes] : &p_.slopes[b.begin * p_.num_slopes];
  return {columns_of(b.begin), weights_of(b.begin), slopes, p_.num_weights, p_.num_slopes, b.end - b.begin};
}

void ProductBlocks::times(const std::vector<double>& x, double* y) {
  if (blocks_.empty()) return;
  variables_.resize(x.size() + num_lanes);
  std::copy(x.begin(), x.end(), variables_.begin());
  for (const Block& b : blocks_) {
    if (in_lanes_)
      lanes_times(rows_of(b), variables_.data(), y + b.begin);
    else
      rows_times(rows_of(b), x.data(), sum_.data(), y + b.begin);
  }
}

void ProductBlocks::add_transposed(const double* y, double scale, std::vector<double>& x) {
  if (blocks_.empty()) return;
  variables_.resize(x.size() + num_lanes);
  std::copy(x.begin(), x.end(), variables_.begin());
  for (const Block& b : blocks_) {
    if (in_lanes_)
      add_transposed_lanes(rows_of(b), y + b.begin, scale, variables_.data());
    else
      add_transposed_rows(rows_of(b), y + b.begin, scale, sum_.data(), variables_.data());
  }
  std::copy_n(variables_.begin(), x.size(), x.begin());
}

void ProductBlocks::add_squares(const double* weight, Skyline& matrix) {
  for (std::size_t i = 0; !in_lanes_ && i < blocks_.size(); ++i)
    add_row_squares(rows_of(blocks_[i]), weight + blocks_[i].begin, square_.data(), matrix);
  for (std::size_t begin = 0, end = 0; in_lanes_ && begin < blocks_.size(); begin = end) {
    for (end = begin; end < blocks_.size() && has_columns_of(blocks_[begin], blocks_[end]); ++end)
      square_lanes(rows_of(blocks_[end]), weight + blocks_[end].begin,
                   &squares_[(end - begin) * num_lanes * num_lanes]);
    add_lane_squares(rows_of(blocks_[begin]), &block_weights_[begin * p_.num_weights], end - begin, squares_.data(),
                     factors_.data(), matrix);
  }
}

}  // namespace wayproof
