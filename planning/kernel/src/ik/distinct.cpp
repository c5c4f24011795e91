#include "ik/distinct.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace wayproof {
namespace {

constexpr double pi = 3.141592653589793, turn = 2 * pi;
// Rounding of the coordinate by which rows are sorted.
constexpr double rounding = 1e-9;

// From 0 to a turn, as numpy's remainder.
double within_turn(double x) {
  const double rest = std::fmod(x, turn);
  return rest < 0 ? rest + turn : rest;
}

// Roots of clusters, the least row of each.
class Clusters {
 public:
  explicit Clusters(std::size_t count) : parents_(count) { std::iota(parents_.begin(), parents_.end(), 0); }

  std::size_t root(std::size_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t k) {
    const std::size_t a = root(i), b = root(k);
    parents_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parents_;
};

}  // namespace

std::vector<bool> first_of_clusters(std::span<const double> rows, std::span<const std::int64_t> targets,
                                    const std::vector<bool>& is_periodic, double tolerance) {
  const std::size_t count = targets.size(), nq = is_periodic.size();
  const auto are_duplicates = [&](std::size_t i, std::size_t k) {
    for (std::size_t v = 0; v < nq; ++v) {
      double delta = rows[i * nq + v] - rows[k * nq + v];
      if (is_periodic[v]) delta = within_turn(delta + pi) - pi;
      if (!(std::abs(delta) <= tolerance)) return false;
    }
    return targets[i] == targets[k];
  };
  // Rows whose first coordinates are near follow one another, around the turn if that is periodic.
  std::vector<double> keys(count);
  for (std::size_t i = 0; i < count; ++i) keys[i] = is_periodic[0] ? within_turn(rows[i * nq]) : rows[i * nq];
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t k) { return keys[i] < keys[k]; });
  Clusters clusters(count);
  for (std::size_t at = 0; at < count; ++at)
    for (std::size_t step = 1; step < count; ++step) {
      const bool wraps = at + step >= count;
      if (wraps && !is_periodic[0]) break;
      const std::size_t i = order[at], k = order[wraps ? at + step - count : at + step];
      if (!(keys[k] + (wraps ? turn : 0) - keys[i] <= tolerance + rounding)) break;
      if (are_duplicates(i, k)) clusters.join(i, k);
    }
  std::vector<bool> is_first(count);
  for (std::size_t i = 0; i < count; ++i) is_first[i] = clusters.root(i) == i;
  return is_first;
}

}  // namespace wayproof
