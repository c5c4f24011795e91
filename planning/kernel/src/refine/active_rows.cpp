#include "refine/active_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace wayproof {
namespace {

// Share of a row's largest change within the box that steps rarely exceed, and the change itself, of a load over its
// bound, that they rarely exceed.
constexpr double likely_share = 0.25, likely_change = 0.6;

// The last column of a row, and its length: they tell rows of different columns apart.
std::pair<std::int64_t, std::int64_t> key_of(const MoreRows& rows, std::size_t k) {
  const std::int64_t length = rows.starts[k + 1] - rows.starts[k];
  return {length ? rows.columns[static_cast<std::size_t>(rows.starts[k + 1] - 1)] : -1, length};
}

}  // namespace

std::vector<char> likely_rows(const MoreRows& rows) {
  std::vector<char> takes_part(rows.least.size());
  for (std::size_t k = 0; k < takes_part.size(); ++k) {
    double reach = 0;
    for (auto i = rows.starts[k]; i < rows.starts[k + 1]; ++i) reach += std::abs(rows.values[i]);
    takes_part[k] = -rows.least[k] < std::min(likely_share * reach, likely_change);
  }
  return takes_part;
}

bool add_broken(const MoreRows& rows, const std::vector<double>& x, std::vector<char>& takes_part) {
  bool is_any = false;
  for (std::size_t k = 0; k < takes_part.size(); ++k) {
    if (takes_part[k]) continue;
    double sum = -rows.least[k];
    for (auto i = rows.starts[k]; i < rows.starts[k + 1]; ++i)
      sum += rows.values[i] * x[static_cast<std::size_t>(rows.columns[i])];
    if (sum < 0) takes_part[k] = 1, is_any = true;
  }
  return is_any;
}

std::vector<std::size_t> in_blocks(const MoreRows& rows, const std::vector<char>& takes_part) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < takes_part.size(); ++k)
    if (takes_part[k]) order.push_back(k);
  std::stable_sort(order.begin(), order.end(),
                   [&rows](std::size_t a, std::size_t b) { return key_of(rows, a) < key_of(rows, b); });
  return order;
}

}  // namespace wayproof
