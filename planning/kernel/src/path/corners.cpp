#include "path/corners.hpp"

#include <algorithm>
#include <cmath>

namespace wayproof {
namespace {

// Smallest relative jump that is a corner. The parameter of a whole path has length 1, so that r' is a reference for
// the size of r'' as well.
constexpr double least_jump = 1e-8;

// A joint's derivative of an order at a distance into a piece, by Horner's rule.
double derivative(const PolynomialPath& path, std::size_t piece, std::size_t joint, std::size_t order, double local) {
  double total = 0;
  for (std::size_t k = path.terms; k-- > order;) {
    double factor = 1;
    for (std::size_t m = 0; m < order; ++m) factor *= static_cast<double>(k - m);
    total = total * local + factor * path.piece(piece)[k * path.joints + joint];
  }
  return total;
}

bool is_corner(const PolynomialPath& path, std::size_t piece, std::size_t smoothness) {
  const double width = path.breaks[piece] - path.breaks[piece - 1];
  double scale = 1e-300;
  for (std::size_t order = 1; order <= smoothness; ++order) {
    double jump = 0, size_before = 0, size_after = 0;
    for (std::size_t v = 0; v < path.joints; ++v) {
      const double end = derivative(path, piece - 1, v, order, width), begin = derivative(path, piece, v, order, 0);
      jump += (begin - end) * (begin - end), size_before += end * end, size_after += begin * begin;
    }
    scale = std::max(scale, std::sqrt(std::max(size_before, size_after)));
    if (std::sqrt(jump) > least_jump * scale) return true;
  }
  return false;
}

}  // namespace

std::vector<std::size_t> corners(const PolynomialPath& path, std::size_t smoothness) {
  std::vector<std::size_t> found;
  for (std::size_t i = 1; i < path.pieces(); ++i)
    if (is_corner(path, i, smoothness)) found.push_back(i);
  return found;
}

}  // namespace wayproof
