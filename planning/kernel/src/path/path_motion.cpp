#include "path/path_motion.hpp"

#include <algorithm>
#include <cmath>

#include "speeds/path_cells.hpp"

namespace wayproof {
namespace {

// Shortest phase relative to the whole duration; shorter ones are left out.
constexpr double least_phase_share = 1e-12;

// Up to three phases of a cell, in order: time, beginning, speed and acceleration there.
struct CellPhases {
  double times[3], accelerated, braked, speeds[3], accelerations[3];
};

CellPhases phases_of(const CellLimits& cells, std::span<const double> x, std::size_t i) {
  const double width = cells.edges[i + 1] - cells.edges[i];
  const double before = std::sqrt(x[i]), after = std::sqrt(x[i + 1]);
  const double needed = (x[i + 1] - x[i]) / (2 * width);
  double a = cells.acceleration[i], b = cells.braking[i];
  if (a == b)
    a = b = std::max(a, std::abs(needed));
  else
    a = std::max(a, needed), b = std::max(b, -needed);
  // Squared speed at which full acceleration meets full braking.
  const double share = b / (a + b);
  const double meeting = share * x[i] + (1 - share) * x[i + 1] + 2 * share * a * width;
  double top = std::min(cells.speed[i], std::sqrt(meeting));
  top = std::max(top, std::max(before, after));
  CellPhases p{{(top - before) / a, 0, (top - after) / b}, 0, 0, {before, top, top}, {a, 0, -b}};
  p.accelerated = p.times[0] * (top + before) / 2;
  p.braked = p.times[2] * (top + after) / 2;
  p.times[1] = std::max(width - p.accelerated - p.braked, 0.0) / top;
  if (!cells.is_line[i]) {
    p.times[0] = 2 * width / (before + after);
    p.times[1] = p.times[2] = 0;
    p.accelerations[0] = needed;
  }
  return p;
}

// p(x(t)) with x(t) = inner[0] t + inner[1] t^2 + ..., by Horner's rule.
void append_composed(const std::vector<double>& outer, std::size_t terms, std::size_t joints,
                     std::span<const double> inner, std::vector<double>& to) {
  const std::size_t degree = (terms - 1) * inner.size();
  std::vector<double> total((degree + 1) * joints, 0.0), product(total.size());
  std::copy(outer.end() - static_cast<std::ptrdiff_t>(joints), outer.end(), total.begin());
  std::size_t count = joints;
  for (std::size_t k = terms - 1; k-- > 0;) {
    std::fill(product.begin(), product.end(), 0.0);
    for (std::size_t m = 0; m < inner.size(); ++m)
      for (std::size_t i = 0; i < count; ++i) product[(m + 1) * joints + i] += inner[m] * total[i];
    std::swap(total, product);
    for (std::size_t v = 0; v < joints; ++v) total[v] += outer[k * joints + v];
    count += inner.size() * joints;
  }
  to.insert(to.end(), total.begin(), total.end());
}

}  // namespace

SpeedProfile profile_between(const CellLimits& cells, std::span<const double> x) {
  const std::size_t count = cells.is_line.size();
  std::vector<CellPhases> phases;
  phases.reserve(count);
  for (std::size_t i = 0; i < count; ++i) phases.push_back(phases_of(cells, x, i));
  std::vector<double> times;
  for (std::size_t k = 0; k < 3; ++k)
    for (const CellPhases& p : phases) times.push_back(p.times[k]);
  const double least = least_phase_share * numpy_sum(times);
  SpeedProfile found;
  for (std::size_t i = 0; i < count; ++i) {
    const CellPhases& p = phases[i];
    const double begin = cells.edges[i];
    const bool keep[3] = {p.times[0] > least, p.times[1] > least, p.times[2] > least};
    // The distance of an omitted phase is added to the next, so that every edge begins a phase.
    const double parameters[3] = {begin, keep[0] ? begin + p.accelerated : begin,
                                  keep[0] || keep[1] ? cells.edges[i + 1] - p.braked : begin};
    for (std::size_t k = 0; k < 3; ++k) {
      if (!keep[k]) continue;
      found.s.push_back(parameters[k]);
      found.v.push_back(p.speeds[k]);
      found.a.push_back(p.accelerations[k]);
      found.j.push_back(0);
      found.h.push_back(p.times[k]);
    }
  }
  found.s.push_back(cells.edges[count]);
  return found;
}

PathMotion compose(const PolynomialPath& path, const SpeedProfile& profile) {
  const bool has_jerk = std::any_of(profile.j.begin(), profile.j.end(), [](double j) { return j != 0; });
  const std::size_t inner_terms = has_jerk ? 3 : 2;
  PathMotion motion;
  motion.terms = (path.terms - 1) * inner_terms + 1;
  motion.times.push_back(0);
  std::vector<double> local;
  for (std::size_t i = 0; i < profile.h.size(); ++i) {
    const double middle = (profile.s[i] + profile.s[i + 1]) / 2;
    const auto after = std::upper_bound(path.breaks.begin() + 1, path.breaks.end() - 1, middle);
    const auto piece = static_cast<std::size_t>(after - path.breaks.begin()) - 1;
    local.clear();
    append_shifted(path.piece(piece), path.terms, path.joints, profile.s[i] - path.breaks[piece], local);
    const double inner[3] = {profile.v[i], profile.a[i] / 2, profile.j[i] / 6};
    append_composed(local, path.terms, path.joints, {inner, inner_terms}, motion.coefficients);
    motion.pieces.push_back(static_cast<std::int64_t>(piece));
    motion.times.push_back(i ? motion.times.back() + profile.h[i] : profile.h[i]);
  }
  return motion;
}

void append_shifted(const double* coefficients, std::size_t terms, std::size_t joints, double offset,
                    std::vector<double>& to) {
  const std::size_t begin = to.size();
  to.insert(to.end(), coefficients, coefficients + terms * joints);
  double* c = to.data() + begin;
  for (std::size_t i = 0; i + 1 < terms; ++i)
    for (std::size_t k = terms - 1; k-- > i;)
      for (std::size_t v = 0; v < joints; ++v) c[k * joints + v] += offset * c[(k + 1) * joints + v];
}

}  // namespace wayproof
