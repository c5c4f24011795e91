#include "math/bernstein.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace wayproof {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr int most_halvings = 40;
constexpr std::size_t most_nodes = 20000;

struct Node {
  double upper;
  std::size_t row;
  double low, width;
  int depth;
  std::vector<double> c;

  bool operator<(const Node& other) const { return upper < other.upper; }
  double where() const { return low + (c.back() >= c.front() ? width : 0); }
};

Node half(const Node& node, bool right) {
  Node h{0, node.row, node.low + (right ? node.width / 2 : 0), node.width / 2, node.depth + 1, node.c};
  const std::size_t n = h.c.size();
  for (std::size_t i = 1; i < n; ++i) {
    if (right)
      for (std::size_t j = 0; j + i < n; ++j) h.c[j] = 0.5 * (h.c[j] + h.c[j + 1]);
    else
      for (std::size_t j = n - 1; j >= i; --j) h.c[j] = 0.5 * (h.c[j - 1] + h.c[j]);
  }
  h.upper = *std::max_element(h.c.begin(), h.c.end());
  return h;
}

}  // namespace

Peak peak(std::span<const double> coefficients, std::size_t terms, double tolerance) {
  const std::size_t rows = coefficients.size() / terms;
  std::vector<double> uppers(rows);
  double taken = -inf;
  for (std::size_t i = 0; i < rows; ++i) {
    const double* c = coefficients.data() + i * terms;
    // Comparisons with NaN would let it pass below every bound.
    if (std::any_of(c, c + terms, [](double x) { return std::isnan(x); })) return {inf, i, 0};
    uppers[i] = *std::max_element(c, c + terms);
    taken = std::max({taken, c[0], c[terms - 1]});
  }
  std::vector<Node> heap;
  Node dropped{-inf, 0, 0, 1, 0, {0, 0}};
  for (std::size_t i = 0; i < rows; ++i) {
    const double* c = coefficients.data() + i * terms;
    if (uppers[i] > taken + tolerance)
      heap.push_back({uppers[i], i, 0, 1, 0, {c, c + terms}});
    else if (uppers[i] > dropped.upper)
      dropped = {uppers[i], i, 0, 1, 0, {c, c + terms}};
  }
  std::make_heap(heap.begin(), heap.end());
  for (std::size_t nodes = heap.size(); !heap.empty() && nodes < most_nodes; nodes += 2) {
    if (heap.front().upper <= taken + tolerance || heap.front().depth >= most_halvings) break;
    std::pop_heap(heap.begin(), heap.end());
    const Node node = std::move(heap.back());
    heap.pop_back();
    for (bool right : {false, true}) {
      Node h = half(node, right);
      taken = std::max({taken, h.c.front(), h.c.back()});
      heap.push_back(std::move(h));
      std::push_heap(heap.begin(), heap.end());
    }
  }
  const Node& top = heap.empty() || heap.front().upper < dropped.upper ? dropped : heap.front();
  return {top.upper, top.row, top.where()};
}

}  // namespace wayproof
