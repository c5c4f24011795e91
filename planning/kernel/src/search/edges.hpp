// Edges of paths between configurations of joints that neither wrap nor float; their lengths as numpy sums them on
// x86-64, and who says which of them are free.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace wayproof {

// Edges between rows of configurations.
struct Edges {
  std::vector<double> from, to;

  void add(const double* begin, const double* end, int nq) {
    from.insert(from.end(), begin, begin + nq);
    to.insert(to.end(), end, end + nq);
  }
};

// Verdicts on edges whose samples are at most `resolution` apart; they may end the work by an exception.
class EdgeVerdicts {
 public:
  EdgeVerdicts(int nq, double resolution) : nq(nq), resolution(resolution) {}
  virtual ~EdgeVerdicts() = default;

  // Whether each edge is free.
  virtual std::vector<char> are_free(const Edges& edges) = 0;
  // The first edge that is free, or their number if none is: from one row to each of the others, or the reverse.
  virtual std::size_t first_free(std::span<const double> from, std::span<const double> to) = 0;

  const int nq;
  const double resolution;
};

// Length of b - a. In two sums, of the even and of the odd coordinates.
double length(const double* a, const double* b, int nq);

// In eight sums from eight numbers on.
double sum(std::span<const double> x);

// The sum of the lengths of the edges between rows.
double path_length(std::span<const double> path, int nq);

}  // namespace wayproof
