#include "prover/joint_bounds.hpp"

#include <algorithm>
#include <cmath>

namespace wayproof {
namespace {

// As planning/certify/intervals/rounding.py has them.
constexpr double unit_roundoff = 0x1p-53, conversion = 5, halvings = 65;

// C(i, k) / C(degree, k), [i][k].
std::vector<double> power_to_bernstein(std::size_t terms) {
  std::vector<double> binomials(terms * terms, 0.0), matrix(terms * terms, 0.0);
  for (std::size_t i = 0; i < terms; ++i)
    for (std::size_t k = 0; k <= i; ++k)
      binomials[i * terms + k] =
          k == 0 || k == i ? 1 : binomials[(i - 1) * terms + k - 1] + binomials[(i - 1) * terms + k];
  for (std::size_t i = 0; i < terms; ++i)
    for (std::size_t k = 0; k <= i; ++k)
      matrix[i * terms + k] = binomials[i * terms + k] / binomials[(terms - 1) * terms + k];
  return matrix;
}

// Of polynomials, [pieces][terms][joints]: Bernstein coefficients, [joints][pieces][terms].
std::vector<double> form_of(std::span<const double> coefficients, std::size_t terms, const JointMotion& motion) {
  const std::vector<double> matrix = power_to_bernstein(terms);
  const std::size_t joints = motion.joints, pieces = motion.pieces();
  std::vector<double> found(coefficients.size()), scaled(terms);
  for (std::size_t i = 0; i < pieces; ++i) {
    const double width = motion.breaks[i + 1] - motion.breaks[i];
    for (std::size_t v = 0; v < joints; ++v) {
      double power = 1;
      for (std::size_t k = 0; k < terms; ++k, power *= width)
        scaled[k] = coefficients[(i * terms + k) * joints + v] * power;
      double* to = &found[(v * pieces + i) * terms];
      for (std::size_t r = 0; r < terms; ++r) {
        double sum = 0;
        for (std::size_t k = 0; k <= r; ++k) sum += matrix[r * terms + k] * scaled[k];
        to[r] = sum;
      }
    }
  }
  return found;
}

// Of the derivative; at least one term, which may be zero.
std::vector<double> derivative(const std::vector<double>& coefficients, std::size_t terms, const JointMotion& motion) {
  const std::size_t joints = motion.joints, pieces = motion.pieces();
  if (terms == 1) return std::vector<double>(pieces * joints, 0.0);
  std::vector<double> found;
  found.reserve(pieces * (terms - 1) * joints);
  for (std::size_t i = 0; i < pieces; ++i)
    for (std::size_t k = 1; k < terms; ++k)
      for (std::size_t v = 0; v < joints; ++v)
        found.push_back(coefficients[(i * terms + k) * joints + v] * static_cast<double>(k));
  return found;
}

JointPeak peak_of(const std::vector<double>& rows, std::size_t terms, double tolerance, std::size_t pieces) {
  const Peak top = peak(rows, terms, tolerance);
  return {top.bound, static_cast<std::int64_t>(top.row / pieces), static_cast<std::int64_t>(top.row % pieces),
          top.fraction};
}

// `joint` counts the upper bounds that there are, then the lower ones.
JointPeak position_peak(const JointMotion& motion, const JointLimitRows& limits, const JointBounds& bounds) {
  const std::size_t joints = motion.joints, pieces = motion.pieces(), terms = motion.terms;
  std::vector<double> errors(joints, 0.0), rows;
  for (std::size_t v = 0; v < joints; ++v) {
    for (std::size_t i = 0; i < pieces; ++i) errors[v] = std::max(errors[v], std::abs(motion.bases[i * joints + v]));
    errors[v] = rounding_share(terms) * bounds.magnitudes[v] + 2 * unit_roundoff * errors[v];
  }
  const auto append = [&](std::size_t v, bool is_upper) {
    const double most = limits.upper[v] - errors[v], least = limits.lower[v] + errors[v];
    if (!std::isfinite(is_upper ? limits.upper[v] : limits.lower[v])) return;
    for (std::size_t i = 0; i < pieces; ++i)
      for (std::size_t k = 0; k < terms; ++k) {
        const double q = bounds.forms[0][(v * pieces + i) * terms + k] + motion.bases[i * joints + v];
        rows.push_back(is_upper ? q - most : least - q);
      }
  };
  for (std::size_t v = 0; v < joints; ++v) append(v, true);
  for (std::size_t v = 0; v < joints; ++v) append(v, false);
  if (rows.empty()) return {};
  return peak_of(rows, terms, limits.position_tolerance, pieces);
}

JointPeak rate_peak(const JointMotion& motion, std::span<const double> limits, const std::vector<double>& form,
                    std::size_t terms, double gap) {
  const std::size_t pieces = motion.pieces();
  std::vector<double> rows;
  std::vector<std::int64_t> limited;
  for (std::size_t v = 0; v < motion.joints; ++v) {
    if (!std::isfinite(limits[v])) continue;
    limited.push_back(static_cast<std::int64_t>(v));
    for (std::size_t k = 0; k < pieces * terms; ++k) rows.push_back(form[v * pieces * terms + k] / limits[v]);
  }
  if (limited.empty()) return {};
  const std::size_t half = rows.size();
  for (std::size_t k = 0; k < half; ++k) rows.push_back(-rows[k]);
  JointPeak found = peak_of(rows, terms, gap, pieces);
  found.joint = limited[static_cast<std::size_t>(found.joint) % limited.size()];
  return found;
}

// Jumps of one order; `from_rest`: the value at the beginning and at the end are jumps as well.
JumpSums jumps_of(const JointMotion& motion, const JointBounds& bounds, std::size_t order, bool from_rest) {
  const std::size_t joints = motion.joints, pieces = motion.pieces();
  const std::size_t terms = motion.terms > order ? motion.terms - order : 1;
  JumpSums found;
  for (std::size_t v = 0; v < joints; ++v) {
    const double* form = &bounds.forms[order][v * pieces * terms];
    const auto at = [&](std::size_t piece, std::size_t k) {
      return order == 0 ? motion.bases[piece * joints + v] + form[piece * terms + k] : form[piece * terms + k];
    };
    double sum = 0, most = 0, least = 0;
    std::int64_t count = 0, last_most = 0, last_least = 0;
    const auto jump = [&](double size) {
      sum = count ? sum + size : size;
      if (sum > most) most = sum, last_most = count;
      if (sum < least) least = sum, last_least = count;
      ++count;
    };
    if (from_rest) jump(at(0, 0));
    for (std::size_t i = 1; i < pieces; ++i) jump(at(i, 0) - at(i - 1, terms - 1));
    if (from_rest) jump(-at(pieces - 1, terms - 1));
    found.largest.push_back(most - least);
    found.last.push_back(std::max(last_most, last_least));
  }
  return found;
}

}  // namespace

double rounding_share(std::size_t terms) {
  double growth = 1;
  for (std::size_t k = 1; k < terms; ++k) growth *= 3;
  return static_cast<double>(terms + 1) * unit_roundoff * (conversion * growth + halvings);
}

JointBounds joint_bounds(const JointMotion& motion, const JointLimitRows& limits) {
  const std::size_t joints = motion.joints, orders = limits.rates.size() / joints;
  JointBounds bounds;
  std::vector<double> coefficients(motion.coefficients.begin(), motion.coefficients.end());
  std::size_t terms = motion.terms;
  for (std::size_t order = 0; order <= orders; ++order) {
    if (order > 0) {
      coefficients = derivative(coefficients, terms, motion);
      terms = std::max<std::size_t>(terms - 1, 1);
    }
    bounds.forms.push_back(form_of(coefficients, terms, motion));
    const std::vector<double>& form = bounds.forms.back();
    const std::size_t size = motion.pieces() * terms;
    for (std::size_t v = 0; v < joints; ++v) {
      double largest = 0;
      for (std::size_t k = 0; k < size; ++k) {
        const double value = std::abs(form[v * size + k]);
        if (value > largest || std::isnan(value)) largest = value;
      }
      bounds.magnitudes.push_back(largest);
    }
    if (order > 0)
      bounds.rates.push_back(
          rate_peak(motion, limits.rates.subspan((order - 1) * joints, joints), form, terms, limits.rate_gap));
  }
  bounds.position = position_peak(motion, limits, bounds);
  for (std::size_t order = 0; order < 3; ++order) bounds.jumps.push_back(jumps_of(motion, bounds, order, order == 2));
  return bounds;
}

}  // namespace wayproof
