#include "search/edges.hpp"

#include <cmath>

namespace wayproof {

double length(const double* a, const double* b, int nq) {
  double even = 0, odd = 0;
  for (int v = 0; v < nq; v += 2) even += (b[v] - a[v]) * (b[v] - a[v]);
  for (int v = 1; v < nq; v += 2) odd += (b[v] - a[v]) * (b[v] - a[v]);
  return std::sqrt(even + odd);
}

double sum(std::span<const double> x) {
  double total = 0;
  std::size_t k = 0;
  if (x.size() >= 8) {
    double r[8] = {x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7]};
    for (k = 8; k + 8 <= x.size(); k += 8)
      for (int l = 0; l < 8; ++l) r[l] += x[k + l];
    total = ((r[0] + r[1]) + (r[2] + r[3])) + ((r[4] + r[5]) + (r[6] + r[7]));
  }
  for (; k < x.size(); ++k) total += x[k];
  return total;
}

double path_length(std::span<const double> path, int nq) {
  std::vector<double> lengths;
  const auto width = static_cast<std::size_t>(nq);
  for (std::size_t k = 0; k + width < path.size(); k += width)
    lengths.push_back(length(&path[k], &path[k + width], nq));
  return sum(lengths);
}

}  // namespace wayproof
