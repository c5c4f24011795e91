#include "search/cut_corners.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "checker/sample_order.hpp"

namespace wayproof {
namespace {

std::vector<int> set_rows(const std::vector<char>& flags) {
  std::vector<int> rows;
  for (std::size_t i = 0; i < flags.size(); ++i)
    if (flags[i]) rows.push_back(static_cast<int>(i));
  return rows;
}

// Ways to cut one corner: from p on the edge before it to q on the edge after it.
struct Cut {
  std::vector<double> p, q;
  double gain = 0;
};

}  // namespace

std::vector<double> backtrack(std::span<const double> desired, std::span<const double> free, EdgeVerdicts& edges,
                              const BacktrackSettings& settings) {
  const int nq = edges.nq, count = static_cast<int>(desired.size()) / nq;
  const auto at = [&](int i) { return static_cast<std::size_t>(i) * nq; };
  std::vector<double> path(desired.begin(), desired.end()), fractions(count, 0.0);
  std::vector<char> unchecked(count, 0);  // edges, by the waypoint that they begin at
  for (int i = 1; i + 1 < count; ++i)
    if (!std::equal(&desired[at(i)], &desired[at(i)] + nq, &free[at(i)])) unchecked[i - 1] = unchecked[i] = 1;
  for (;;) {
    const std::vector<int> rows = set_rows(unchecked);
    if (rows.empty()) return path;
    Edges some;
    for (int i : rows) some.add(&path[at(i)], &path[at(i + 1)], nq);
    const std::vector<char> verdicts = edges.are_free(some);
    std::vector<char> is_moved(count, 0);
    for (std::size_t k = 0; k < rows.size(); ++k)
      if (!verdicts[k])
        for (int i : {rows[k], rows[k] + 1}) is_moved[i] = fractions[i] < 1 && i > 0 && i < count - 1;
    std::fill(unchecked.begin(), unchecked.end(), 0);
    for (int i : set_rows(is_moved)) {
      fractions[i] = fractions[i] == 0 ? settings.first_fraction : fractions[i] * settings.growth;
      if (fractions[i] > settings.max_fraction) fractions[i] = 1;
      for (int v = 0; v < nq; ++v) {
        const double back = free[at(i) + v], wanted = desired[at(i) + v];
        path[at(i) + v] = fractions[i] == 1 ? back : wanted + fractions[i] * (back - wanted);
      }
      unchecked[i - 1] = unchecked[i] = 1;
    }
  }
}

std::vector<double> cut_corners(std::span<const double> waypoints, EdgeVerdicts& edges,
                                std::span<const double> fractions, double min_gain) {
  const int nq = edges.nq, count = static_cast<int>(waypoints.size()) / nq;
  if (count < 3) return {};
  const auto point = [&](int i) { return &waypoints[static_cast<std::size_t>(i) * nq]; };
  std::vector<double> delta(waypoints.size() - nq), lengths(count - 1);
  std::vector<std::int64_t> steps(count - 1);
  for (int e = 0; e < count - 1; ++e) {
    double* d = &delta[static_cast<std::size_t>(e) * nq];
    for (int v = 0; v < nq; ++v) d[v] = point(e + 1)[v] - point(e)[v];
    steps[e] = num_samples(d, nq, edges.resolution);
    lengths[e] = length(point(e), point(e + 1), nq);
  }
  const double least = min_gain * sum(lengths);
  std::vector<Cut> cuts;
  std::vector<int> corners;
  Edges some;
  for (int k = 0; k < count - 2; ++k)
    for (double fraction : fractions) {
      const double first = static_cast<double>(steps[k]), second = static_cast<double>(steps[k + 1]);
      const double off = std::floor(fraction * first), on = std::floor(fraction * second);
      const double before = (first - off) / first, after = on / second;
      Cut cut{std::vector<double>(nq), std::vector<double>(nq)};
      const double *d = &delta[static_cast<std::size_t>(k) * nq], *e = d + nq;
      for (int v = 0; v < nq; ++v) cut.p[v] = point(k)[v] + before * d[v], cut.q[v] = point(k + 1)[v] + after * e[v];
      cut.gain = ((1 - before) * lengths[k] + after * lengths[k + 1]) - length(cut.p.data(), cut.q.data(), nq);
      if (!(cut.gain > least && off > 0 && on > 0)) continue;
      some.add(cut.p.data(), cut.q.data(), nq);
      corners.push_back(k), cuts.push_back(std::move(cut));
    }
  if (cuts.empty()) return {};
  const std::vector<char> free = edges.are_free(some);
  std::vector<const Cut*> best(count - 2, nullptr);  // free cut of the largest gain, the first of equals
  for (std::size_t i = 0; i < cuts.size(); ++i)
    if (const Cut*& own = best[corners[i]]; free[i] && (!own || cuts[i].gain > own->gain)) own = &cuts[i];
  if (std::all_of(best.begin(), best.end(), [](const Cut* cut) { return !cut; })) return {};
  std::vector<double> path(point(0), point(1));
  const auto append = [&](const double* q) {
    if (!std::equal(q, q + nq, &path[path.size() - nq])) path.insert(path.end(), q, q + nq);
  };
  for (int k = 0; k < count - 2; ++k) {
    append(best[k] ? best[k]->p.data() : point(k + 1));
    if (best[k]) append(best[k]->q.data());
  }
  append(point(count - 1));
  return path;
}

}  // namespace wayproof
