#include "timing/phase_peaks.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace wayproof {
namespace {

constexpr int num_halvings = 2;

// Polynomials of all joints, [terms][joints].
struct Polynomials {
  std::size_t terms = 0, joints = 0;
  std::vector<double> c;

  Polynomials(std::size_t num_terms, std::size_t num_joints)
      : terms(num_terms), joints(num_joints), c(num_terms * num_joints) {}
  double* term(std::size_t k) { return &c[k * joints]; }
  const double* term(std::size_t k) const { return &c[k * joints]; }
};

void add_scaled(double factor, const double* from, std::size_t count, double* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

// The piece of the path in powers of (s - begin), by repeated synthetic division.
Polynomials shifted(const PolynomialPath& path, std::size_t piece, double begin) {
  Polynomials found(path.terms, path.joints);
  const double* from = path.piece(piece);
  found.c.assign(from, from + path.terms * path.joints);
  const double offset = begin - path.breaks[piece];
  for (std::size_t i = 0; i + 1 < path.terms; ++i)
    for (std::size_t k = path.terms - 1; k-- > i;) add_scaled(offset, found.term(k + 1), path.joints, found.term(k));
  return found;
}

// p(x(t)) with x(t) = inner[0] t + inner[1] t^2 + inner[2] t^3, by Horner's rule.
Polynomials composed(const Polynomials& outer, const double (&inner)[3]) {
  Polynomials total((outer.terms - 1) * 3 + 1, outer.joints), product = total;
  std::copy_n(outer.term(outer.terms - 1), outer.joints, total.term(0));
  std::size_t length = 1;
  for (std::size_t k = outer.terms - 1; k-- > 0;) {
    std::fill(product.c.begin(), product.c.end(), 0.0);
    for (std::size_t m = 0; m < 3; ++m) add_scaled(inner[m], total.term(0), length * outer.joints, product.term(m + 1));
    std::swap(total.c, product.c);
    add_scaled(1, outer.term(k), outer.joints, total.term(0));
    length += 3;
  }
  return total;
}

Polynomials derivative(const Polynomials& p) {
  Polynomials found(std::max<std::size_t>(p.terms - 1, 1), p.joints);
  for (std::size_t k = 1; k < p.terms; ++k) add_scaled(static_cast<double>(k), p.term(k), p.joints, found.term(k - 1));
  return found;
}

// Coefficients in Bernstein form on [0, width]: powers are scaled, divided by binomials and summed k times.
Polynomials bernstein(const Polynomials& p, double width) {
  Polynomials found = p;
  double scale = 1;
  for (std::size_t k = 0; k < p.terms; ++k) {
    for (std::size_t i = 0; i < p.joints; ++i) found.term(k)[i] *= scale;
    scale *= width * static_cast<double>(k + 1) / static_cast<double>(std::max<std::size_t>(p.terms - 1 - k, 1));
  }
  for (std::size_t i = 1; i < p.terms; ++i)
    for (std::size_t k = p.terms - 1; k >= i; --k) add_scaled(1, found.term(k - 1), p.joints, found.term(k));
  return found;
}

// Largest coefficient over limit, after halving (de Casteljau), which uses the polynomials up.
double largest(Polynomials& p, const double* limits, int halvings) {
  if (halvings > 0 && p.terms > 2) {
    Polynomials left(p.terms, p.joints);
    for (std::size_t i = 0; i < p.terms; ++i) {
      std::copy_n(p.term(0), p.joints, left.term(i));
      for (std::size_t k = 0; k + 1 + i < p.terms; ++k)
        for (std::size_t d = 0; d < p.joints; ++d) p.term(k)[d] = 0.5 * (p.term(k)[d] + p.term(k + 1)[d]);
    }
    return std::max(largest(left, limits, halvings - 1), largest(p, limits, halvings - 1));
  }
  // The largest of each joint first, in place of its first coefficient: a division takes longer than to compare.
  double* most = p.term(0);
  for (std::size_t d = 0; d < p.joints; ++d) most[d] = std::abs(most[d]);
  for (std::size_t k = 1; k < p.terms; ++k)
    for (std::size_t d = 0; d < p.joints; ++d) most[d] = std::max(most[d], std::abs(p.term(k)[d]));
  double found = 0;
  for (std::size_t d = 0; d < p.joints; ++d) found = std::max(found, most[d] / limits[d]);
  return found;
}

}  // namespace

std::vector<double> phase_peaks(const PolynomialPath& path, const SpeedProfile& profile, const RateLimits& limits) {
  const std::size_t n = profile.h.size();
  std::vector<double> found(3 * n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t piece = path.locate((profile.s[k] + profile.s[k + 1]) / 2);
    Polynomials rate = composed(shifted(path, piece, profile.s[k]), {profile.v[k], profile.a[k] / 2, profile.j[k] / 6});
    for (std::size_t order = 0; order < 3; ++order) {
      rate = derivative(rate);
      Polynomials form = bernstein(rate, profile.h[k]);
      found[order * n + k] = largest(form, &limits[order * path.joints], num_halvings);
    }
  }
  return found;
}

}  // namespace wayproof
