#include "refine/active_balls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace wayproof {
namespace {

// As those of active_rows.cpp.
constexpr double likely_share = 0.25, likely_change = 0.6;

double length_of(const std::array<double, 3>& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

// The largest change of a vector's length within the box, to first order.
double reach_of(const BallRows& balls, std::size_t ball, const std::array<double, 3>& center, double length) {
  const auto begin = static_cast<std::size_t>(balls.starts[ball]),
             end = static_cast<std::size_t>(balls.starts[ball + 1]);
  const double *x = &balls.values[3 * begin], *y = x + (end - begin), *z = y + (end - begin);
  double reach = 0;
  for (std::size_t i = 0; i < end - begin; ++i)
    reach += std::abs(center[0] * x[i] + center[1] * y[i] + center[2] * z[i]);
  return length > 0 ? reach / length : 0;
}

// The last column of a ball, and how many it has: they tell balls of different columns apart.
std::pair<std::int64_t, std::int64_t> key_of(const BallRows& balls, std::size_t k) {
  const std::int64_t length = balls.starts[k + 1] - balls.starts[k];
  return {length ? balls.columns[static_cast<std::size_t>(balls.starts[k + 1] - 1)] : -1, length};
}

}  // namespace

std::vector<char> likely_balls(const BallRows& balls) {
  std::vector<char> takes_part(balls.size());
  for (std::size_t k = 0; k < takes_part.size(); ++k) {
    const std::array<double, 3> center{balls.centers[3 * k], balls.centers[3 * k + 1], balls.centers[3 * k + 2]};
    const double length = length_of(center);
    takes_part[k] = 1 - length < std::min(likely_share * reach_of(balls, k, center, length), likely_change);
  }
  return takes_part;
}

bool add_broken(const BallRows& balls, const std::vector<double>& x, std::vector<char>& takes_part) {
  bool is_any = false;
  for (std::size_t k = 0; k < takes_part.size(); ++k)
    if (!takes_part[k] && length_of(balls.vector(k, x)) > 1) takes_part[k] = 1, is_any = true;
  return is_any;
}

std::vector<std::size_t> in_blocks(const BallRows& balls, const std::vector<char>& takes_part) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < takes_part.size(); ++k)
    if (takes_part[k]) order.push_back(k);
  std::stable_sort(order.begin(), order.end(),
                   [&balls](std::size_t a, std::size_t b) { return key_of(balls, a) < key_of(balls, b); });
  return order;
}

}  // namespace wayproof
