#include "qp/ball_rows.hpp"

#include <algorithm>
#include <cmath>

namespace wayproof {
namespace {

constexpr std::size_t three = 3;
// Lengths are those of vectors with one more component, of this size: they have derivatives at zero.
constexpr double smallest_length = 1e-2;
// What makes a unit vector's length 1 again: sqrt(1 + 1e-4) - 1.
constexpr double offset = 4.9998750062496094e-05;

double length_of(double x, double y, double z) {
  return std::sqrt(x * x + y * y + z * z + smallest_length * smallest_length);
}

}  // namespace

std::array<double, 3> BallRows::vector(std::size_t ball, const std::vector<double>& x) const {
  const auto begin = static_cast<std::size_t>(starts[ball]), end = static_cast<std::size_t>(starts[ball + 1]);
  std::array<double, three> found{centers[three * ball], centers[three * ball + 1], centers[three * ball + 2]};
  const double* value = values.data() + three * begin;
  for (double& component : found)
    for (std::size_t i = begin; i < end; ++i) component += *value++ * x[static_cast<std::size_t>(columns[i])];
  return found;
}

void BallRows::append(const BallRows& others, std::size_t ball) {
  const auto begin = others.starts[ball], end = others.starts[ball + 1],
             first = static_cast<std::int64_t>(three) * begin;
  columns.insert(columns.end(), others.columns.begin() + begin, others.columns.begin() + end);
  values.insert(values.end(), others.values.begin() + first,
                others.values.begin() + static_cast<std::int64_t>(three) * end);
  const auto center = others.centers.begin() + static_cast<std::int64_t>(three * ball);
  centers.insert(centers.end(), center, center + three);
  starts.push_back(static_cast<std::int64_t>(columns.size()));
}

BallBlocks::BallBlocks(const BallRows& balls)
    : p_(balls),
      vectors_(p_.centers.size()),
      changes_(p_.centers.size()),
      normals_(p_.centers.size()),
      inverse_lengths_(p_.size()),
      local_(p_.centers.size()),
      weights_(three * p_.centers.size()) {
  const auto columns_of = [this](std::size_t k) { return p_.columns.data() + p_.starts[k]; };
  std::size_t begin = 0;
  while (begin < p_.size()) {
    std::size_t end = begin + 1;
    const std::int64_t* columns = columns_of(begin);
    const auto width = static_cast<std::size_t>(p_.starts[begin + 1] - p_.starts[begin]);
    while (end < p_.size() && std::equal(columns, columns + width, columns_of(end), columns_of(end + 1))) ++end;
    const double* values = p_.values.data() + three * static_cast<std::size_t>(p_.starts[begin]);
    blocks_.push_back({begin, end, DenseBlock(columns, values, three * (end - begin), width)});
    begin = end;
  }
}

void BallBlocks::widen(std::vector<int>& first) const {
  for (const Block& block : blocks_) {
    const std::int64_t *begin = p_.columns.data() + p_.starts[block.begin],
                       *end = p_.columns.data() + p_.starts[block.begin + 1];
    if (begin == end) continue;
    const int low = static_cast<int>(*std::min_element(begin, end));
    for (const std::int64_t* column = begin; column != end; ++column) first[*column] = std::min(first[*column], low);
  }
}

void BallBlocks::move_to(const std::vector<double>& x, double* y) {
  for (Block& block : blocks_) {
    block.rows.times(x.data(), &vectors_[three * block.begin]);
    for (std::size_t k = block.begin; k < block.end; ++k) {
      double *vector = &vectors_[three * k], *normal = &normals_[three * k];
      for (std::size_t i = 0; i < three; ++i) vector[i] += p_.centers[three * k + i];
      const double length = length_of(vector[0], vector[1], vector[2]);
      inverse_lengths_[k] = 1 / length;
      for (std::size_t i = 0; i < three; ++i) normal[i] = vector[i] * inverse_lengths_[k];
      y[k] = offset - length;
    }
  }
}

double BallBlocks::value_after(std::size_t ball, double share) const {
  const double *v = &vectors_[three * ball], *w = &changes_[three * ball];
  return offset - length_of(v[0] + share * w[0], v[1] + share * w[1], v[2] + share * w[2]);
}

void BallBlocks::times(const std::vector<double>& x, double* y) {
  for (Block& block : blocks_) {
    block.rows.times(x.data(), &changes_[three * block.begin]);
    for (std::size_t k = block.begin; k < block.end; ++k) {
      const double *normal = &normals_[three * k], *along = &changes_[three * k];
      y[k] = -(normal[0] * along[0] + normal[1] * along[1] + normal[2] * along[2]);
    }
  }
}

void BallBlocks::add_transposed(const double* y, double scale, std::vector<double>& x) {
  for (Block& block : blocks_) {
    for (std::size_t k = block.begin; k < block.end; ++k)
      for (std::size_t i = 0; i < three; ++i) local_[three * k + i] = -y[k] * normals_[three * k + i];
    block.rows.add_transposed(&local_[three * block.begin], scale, x.data());
  }
}

void BallBlocks::add_squares(const double* weight, const double* multiplier, Skyline& matrix) {
  for (std::size_t k = 0; k < p_.size(); ++k) {
    const double *normal = &normals_[three * k], across = multiplier[k] * inverse_lengths_[k];
    double* of = &weights_[three * three * k];
    for (std::size_t i = 0; i < three; ++i)
      for (std::size_t j = 0; j < three; ++j)
        of[three * i + j] = (weight[k] - across) * normal[i] * normal[j] + (i == j ? across : 0.0);
  }
  for (Block& block : blocks_) block.rows.add_weighted_squares(&weights_[three * three * block.begin], matrix);
}

}  // namespace wayproof
