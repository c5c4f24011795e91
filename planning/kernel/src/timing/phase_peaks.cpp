#include "timing/phase_peaks.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "math/multiversion.hpp"

namespace wayproof {
namespace {

constexpr int num_halvings = 2;

// A phase, its beginning relative to its piece of the path: s(t) = s + t (inner[0] + t (inner[1] + t inner[2])).
struct Phase {
  double s, inner[3], h;
};

// The piece of the path in powers of (s - begin), by repeated synthetic division.
[[gnu::always_inline]] inline void shift(Lanes* p, std::size_t terms, double offset) {
  for (std::size_t i = 0; i + 1 < terms; ++i)
    for (std::size_t k = terms - 1; k-- > i;) p[k] += offset * p[k + 1];
}

// p(s(t)) by Horner's rule, with room for 3 (terms - 1) + 1 coefficients in both.
[[gnu::always_inline]] inline void compose(const Lanes* p, std::size_t terms, const double (&inner)[3], Lanes* total,
                                           Lanes* product) {
  total[0] = p[terms - 1];
  std::size_t length = 1;
  for (std::size_t k = terms - 1; k-- > 0; length += 3) {
    for (std::size_t i = 0; i < length + 3; ++i) {
      Lanes sum{};
      for (std::size_t m = 0; m < 3; ++m)
        if (i >= m + 1 && i - m - 1 < length) sum += inner[m] * total[i - m - 1];
      product[i] = sum;
    }
    std::copy_n(product, length + 3, total);
    total[0] += p[k];
  }
}

// Coefficients in Bernstein form on [0, width]: powers are scaled, divided by binomials and summed k times.
[[gnu::always_inline]] inline void to_bernstein(Lanes* p, std::size_t terms, double width) {
  double scale = 1;
  for (std::size_t k = 0; k < terms; ++k) {
    p[k] *= scale;
    scale *= width * static_cast<double>(k + 1) / static_cast<double>(std::max<std::size_t>(terms - 1 - k, 1));
  }
  for (std::size_t i = 1; i < terms; ++i)
    for (std::size_t k = terms - 1; k >= i; --k) p[k] += p[k - 1];
}

[[gnu::always_inline]] inline double largest_coefficient(const Lanes* p, std::size_t terms) {
  Lanes most{};
  for (std::size_t k = 0; k < terms; ++k) most = larger_size(most, p[k]);
  return largest_of(most);
}

// The left half of an interval, and in place of the whole its right half (de Casteljau).
[[gnu::always_inline]] inline void halve(Lanes* p, std::size_t terms, Lanes* left) {
  for (std::size_t i = 0; i < terms; ++i) {
    left[i] = p[0];
    for (std::size_t k = 0; k + 1 + i < terms; ++k) p[k] = 0.5 * (p[k] + p[k + 1]);
  }
}

// Raises `peak` to the largest coefficient of all parts of an interval, whose coefficients are used up. Parts that stay
// below it as a whole are not halved. There is room for num_halvings more.
[[gnu::always_inline]] inline void raise(Lanes* p, std::size_t terms, double& peak) {
  int depths[num_halvings + 1] = {0};
  for (int open = 1; open > 0; --open) {
    Lanes* part = p + static_cast<std::size_t>(open - 1) * terms;
    const double most = largest_coefficient(part, terms);
    if (most <= peak) continue;
    int& depth = depths[open - 1];
    if (depth == num_halvings || terms < 3) {
      peak = most;
      continue;
    }
    halve(part, terms, part + terms);
    depths[open] = ++depth;
    open += 2;
  }
}

// Raises the peaks of all orders to those of a phase; `room` for 5 (3 terms) lanes.
WAYPROOF_MULTIVERSION
void raise_peaks(const PathRates::Group& group, const Phase& phase, Lanes* room, double* peaks) {
  const std::size_t terms = group.terms, most = 3 * terms;
  Lanes *piece = room, *motion = room + most, *form = motion + most;
  for (std::size_t k = 0; k < terms; ++k) piece[k] = load(group.coefficients + k * group.stride);
  shift(piece, terms, phase.s);
  compose(piece, terms, phase.inner, motion, form);
  std::size_t count = 3 * (terms - 1) + 1;
  for (int order = 0; order < 3 && count > 1; ++order) {
    --count;
    for (std::size_t k = 0; k < count; ++k) motion[k] = static_cast<double>(k + 1) * motion[k + 1];
    const Lanes inverse = load(group.inverse_limits[order]);
    for (std::size_t k = 0; k < count; ++k) form[k] = motion[k] * inverse;
    to_bernstein(form, count, phase.h);
    raise(form, count, peaks[order]);
  }
}

}  // namespace

std::array<double, 3> phase_peaks(const PathRates& path, const SpeedProfile& profile) {
  std::array<double, 3> peaks{};
  // Of the piece, the motion, its form and one part of each halving.
  std::vector<double> room((3 + num_halvings) * 3 * path.path().terms * num_lanes);
  for (std::size_t k = 0; k < profile.h.size(); ++k) {
    const std::size_t piece = path.path().locate((profile.s[k] + profile.s[k + 1]) / 2);
    const Phase phase{profile.s[k] - path.path().breaks[piece],
                      {profile.v[k], profile.a[k] / 2, profile.j[k] / 6},
                      profile.h[k]};
    for (std::size_t g = 0; g < path.groups(); ++g)
      raise_peaks(path.group(piece, g), phase, reinterpret_cast<Lanes*>(room.data()), peaks.data());
  }
  return peaks;
}

}  // namespace wayproof
