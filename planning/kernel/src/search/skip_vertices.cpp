#include "search/skip_vertices.hpp"

#include <algorithm>
#include <cstdint>

#include "checker/sample_order.hpp"

namespace wayproof {
namespace {

// Points on a polyline, in order: the waypoints, and points between at samples of the edges.
struct Points {
  std::vector<double> qs;
  std::vector<int> first_edge, last_edge;  // that each lies on

  int count() const { return static_cast<int>(first_edge.size()); }

  void add(const double* q, int nq, int first, int last) {
    qs.insert(qs.end(), q, q + nq);
    first_edge.push_back(first), last_edge.push_back(last);
  }
};

// Edges are cut at their samples, so that every piece of a free edge is free.
Points subdivide(std::span<const double> waypoints, const EdgeVerdicts& edges, int max_parts) {
  const int nq = edges.nq, last = static_cast<int>(waypoints.size()) / nq - 1;
  Points points;
  std::vector<double> delta(nq), q(nq);
  for (int e = 0; e < last; ++e) {
    const double *a = &waypoints[static_cast<std::size_t>(e) * nq], *b = a + nq;
    for (int v = 0; v < nq; ++v) delta[v] = b[v] - a[v];
    const std::int64_t steps = num_samples(delta.data(), nq, edges.resolution);
    const std::int64_t parts = std::min<std::int64_t>(max_parts, steps);
    points.add(a, nq, e - 1, e);
    for (std::int64_t part = 1; part < parts; ++part) {
      const std::int64_t step = part * steps / parts;
      const double fraction = static_cast<double>(step) / static_cast<double>(steps);
      for (int v = 0; v < nq; ++v) q[v] = a[v] + fraction * delta[v];
      points.add(q.data(), nq, e, e);
    }
  }
  points.add(&waypoints[static_cast<std::size_t>(last) * nq], nq, last - 1, last);
  return points;
}

}  // namespace

std::vector<double> skip_vertices(std::span<const double> waypoints, EdgeVerdicts& edges,
                                  const std::function<bool()>& is_over) {
  const int nq = edges.nq, last = static_cast<int>(waypoints.size()) / nq - 1;
  const auto point = [&](int i) { return &waypoints[static_cast<std::size_t>(i) * nq]; };
  std::vector<int> chain{0}, untried{last};
  std::vector<char> is_dead(last + 1, 0);
  while (!chain.empty() && chain.back() < last) {
    const int here = chain.back();
    int furthest = untried.back();
    if (is_over()) furthest = std::min(furthest, here + 1);
    std::vector<int> others;
    std::vector<double> rows;
    for (int i = furthest; i > here; --i)
      if (!is_dead[i]) others.push_back(i), rows.insert(rows.end(), point(i), point(i) + nq);
    const std::size_t first = others.empty() ? 0 : edges.first_free({point(here), static_cast<std::size_t>(nq)}, rows);
    const int there = first < others.size() ? others[first] : here;
    untried.back() = there - 1;
    if (there > here) {
      chain.push_back(there), untried.push_back(last);
    } else {
      is_dead[here] = 1;
      chain.pop_back(), untried.pop_back();
    }
  }
  std::vector<double> path;
  for (int i : chain) path.insert(path.end(), point(i), point(i) + nq);
  return path;
}

std::vector<double> tighten(std::span<const double> waypoints, EdgeVerdicts& edges, int max_parts) {
  const int nq = edges.nq;
  const Points points = subdivide(waypoints, edges, max_parts);
  const auto point = [&](int i) { return &points.qs[static_cast<std::size_t>(i) * nq]; };
  std::vector<int> chain{points.count() - 1};
  while (chain.back() > 0) {
    const int here = chain.back();
    // The first point on the edge of this one, at which a free edge ends in any case.
    const auto& last_edges = points.last_edge;
    const int nearest = static_cast<int>(
        std::lower_bound(last_edges.begin(), last_edges.end(), points.first_edge[here]) - last_edges.begin());
    const std::size_t count = static_cast<std::size_t>(nearest) * nq;
    const std::size_t first =
        count ? edges.first_free({points.qs.data(), count}, {point(here), static_cast<std::size_t>(nq)}) : 0;
    chain.push_back(static_cast<int>(first));
  }
  std::reverse(chain.begin(), chain.end());
  std::vector<double> path;
  for (int i : chain) path.insert(path.end(), point(i), point(i) + nq);
  return path;
}

}  // namespace wayproof
