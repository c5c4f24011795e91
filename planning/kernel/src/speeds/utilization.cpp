#include "speeds/utilization.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "math/bernstein.hpp"

namespace wayproof {
namespace {

// Largest share by which the bound exceeds the true peak.
constexpr double gap = 1e-9;

// Power basis to Bernstein form: C(i, k) / C(degree, k), [i][k].
std::vector<double> to_bernstein(std::size_t terms) {
  std::vector<double> matrix(terms * terms, 0.0);
  for (std::size_t i = 0; i < terms; ++i) {
    double ratio = 1;
    for (std::size_t k = 0; k <= i; ++k) {
      matrix[i * terms + k] = ratio;
      ratio = ratio * static_cast<double>(i - k) / static_cast<double>(terms - 1 - k);
    }
  }
  return matrix;
}

// Bernstein coefficients of a derivative over the limits, [joints][terms] for each piece.
std::vector<double> forms(const Polynomials& motion, std::span<const double> limits, std::size_t order,
                          std::size_t terms) {
  const std::vector<double> matrix = to_bernstein(terms);
  const std::size_t joints = motion.joints, pieces = motion.widths.size();
  std::vector<double> factors(terms, 1.0), found(pieces * joints * terms), scaled(terms);
  for (std::size_t k = 0; k < terms; ++k)
    for (std::size_t m = 1; m <= order; ++m) factors[k] *= static_cast<double>(k + m);
  for (std::size_t i = 0; i < pieces; ++i)
    for (std::size_t v = 0; v < joints; ++v) {
      double power = 1;
      for (std::size_t k = 0; k < terms; ++k, power *= motion.widths[i]) {
        const std::size_t at = k + order;
        const double c = at < motion.terms ? motion.coefficients[(i * motion.terms + at) * joints + v] : 0;
        scaled[k] = c * factors[k] * power;
      }
      double* to = &found[(i * joints + v) * terms];
      for (std::size_t r = 0; r < terms; ++r) {
        double sum = 0;
        for (std::size_t k = 0; k <= r; ++k) sum += matrix[r * terms + k] * scaled[k];
        to[r] = sum / limits[v];
      }
    }
  return found;
}

}  // namespace

Utilization utilization(const Polynomials& motion, std::span<const double> limits, std::size_t order) {
  const std::size_t terms = motion.terms > order ? motion.terms - order : 1, joints = motion.joints;
  const std::vector<double> rows = forms(motion, limits, order, terms);
  const std::size_t count = rows.size() / terms;
  double attained = -1;
  std::size_t joint = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double ends = std::max(std::abs(rows[i * terms]), std::abs(rows[i * terms + terms - 1]));
    if (ends > attained) attained = ends, joint = i % joints;
  }
  double closed = 0;
  std::vector<double> open;
  std::vector<std::size_t> owners;
  for (std::size_t i = 0; i < count; ++i) {
    const double* c = &rows[i * terms];
    double upper = 0;
    for (std::size_t k = 0; k < terms; ++k) upper = std::max(upper, std::abs(c[k]));
    if (upper > attained * (1 + gap)) {
      open.insert(open.end(), c, c + terms);
      owners.push_back(i % joints);
    } else {
      closed = std::max(closed, upper);
    }
  }
  double fraction = attained;
  if (!owners.empty()) {
    const std::size_t half = open.size();
    for (std::size_t k = 0; k < half; ++k) open.push_back(-open[k]);
    const Peak top = peak(open, terms, attained * gap);
    if (top.bound > fraction) fraction = top.bound, joint = owners[top.row % owners.size()];
  }
  return {std::max(fraction, closed), joint};
}

}  // namespace wayproof
