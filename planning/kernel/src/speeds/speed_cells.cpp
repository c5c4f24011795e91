#include "speeds/speed_cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "path/path_motion.hpp"
#include "speeds/path_cells.hpp"

namespace wayproof {
namespace {

// As planning/retime/block_peaks.py has it: how often a polynomial is halved before its coefficients bound it.
constexpr int bisections = 2;

// Largest magnitude of Bernstein coefficients after `rest` bisections; changes them.
double largest(std::span<double> c, int rest) {
  const std::size_t terms = c.size();
  // Lines have their largest values at their ends.
  if (rest == 0 || terms < 3) {
    double most = 0;
    for (double value : c) most = std::max(most, std::abs(value));
    return most;
  }
  std::vector<double> left(terms);
  for (std::size_t k = 0; k < terms; ++k) {
    left[k] = c[0];
    for (std::size_t i = 0; i + 1 < terms - k; ++i) c[i] = (c[i] + c[i + 1]) / 2;
  }
  // What is left in c are the last coefficients of every round: those of the right half.
  return std::max(largest(left, rest - 1), largest(c, rest - 1));
}

// Bernstein coefficients of a joint's derivative on a cell of some width.
void form_of(const PolynomialPath& cells, std::size_t cell, std::size_t joint, std::size_t order, double width,
             std::vector<double>& form) {
  const std::size_t terms = cells.terms > order ? cells.terms - order : 1;
  form.assign(terms, 0.0);
  double power = 1;
  for (std::size_t k = 0; k + order < cells.terms; ++k, power *= width) {
    double factor = 1;
    for (std::size_t m = 0; m < order; ++m) factor *= static_cast<double>(k + order - m);
    form[k] = cells.piece(cell)[(k + order) * cells.joints + joint] * factor * power;
  }
  // Power basis to Bernstein form in place: divided by binomials, then summed up in rounds.
  const auto degree = static_cast<double>(terms - 1);
  double binomial = 1;
  for (std::size_t k = 1; k < terms; ++k) {
    binomial *= (degree - static_cast<double>(k) + 1) / static_cast<double>(k);
    form[k] /= binomial;
  }
  for (std::size_t round = 1; round < terms; ++round)
    for (std::size_t k = terms - 1; k >= round; --k) form[k] += form[k - 1];
}

}  // namespace

SpeedCells speed_cells(const PolynomialPath& path, std::span<const double> limits, std::size_t count,
                       std::size_t least) {
  std::vector<double> widths(path.pieces());
  for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = path.breaks[i + 1] - path.breaks[i];
  const double total = numpy_sum(widths);
  SpeedCells found;
  PolynomialPath cells;
  cells.terms = path.terms, cells.joints = path.joints;
  for (std::size_t i = 0; i < widths.size(); ++i) {
    const double wanted = std::ceil(static_cast<double>(count) * widths[i] / total);
    const std::size_t parts = std::max(static_cast<std::size_t>(wanted), least);
    const double width = widths[i] / static_cast<double>(parts);
    for (std::size_t part = 0; part < parts; ++part) {
      found.edges.push_back(static_cast<double>(part) * width + path.breaks[i]);
      found.pieces.push_back(static_cast<std::int64_t>(i));
      append_shifted(path.piece(i), path.terms, path.joints, found.edges.back() - path.breaks[i], cells.coefficients);
    }
  }
  found.edges.push_back(path.breaks.back());
  const std::size_t size = found.pieces.size() * path.joints;
  found.peaks.resize(6 * size);
  // r' over limits of velocity, acceleration and jerk, r'' over the last two, r''' over the last.
  constexpr std::array<std::size_t, 4> first_table{0, 0, 3, 5};
  std::vector<double> form;
  for (std::size_t cell = 0; cell < found.pieces.size(); ++cell)
    for (std::size_t v = 0; v < path.joints; ++v)
      for (std::size_t order = 1; order <= 3; ++order) {
        form_of(cells, cell, v, order, found.edges[cell + 1] - found.edges[cell], form);
        const double peak = largest(form, bisections);
        for (std::size_t rate = order - 1; rate < 3; ++rate)
          found.peaks[(first_table[order] + rate - (order - 1)) * size + cell * path.joints + v] =
              peak / limits[rate * path.joints + v];
      }
  return found;
}

}  // namespace wayproof
