#include "timing/speed_dp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace wayproof {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double tiny = 1e-300;
// Times closer than this are equal: rounding does not decide between one long segment and several short ones.
constexpr double equal = 1e-12;

// Bounds on the path's acceleration and jerk, not positive where there are none.
struct Bounds {
  double a = -1, j = -1;
};

// Where a segment begins, and the faster time to its end.
struct Choice {
  double time = inf;
  std::size_t node = 0, level = 0;
};

class Chain {
 public:
  explicit Chain(const SpeedGrid& grid)
      : g_(grid),
        best_(g_.nodes() * g_.levels),
        peaks_(6 * g_.blocks),
        inverse_(2 * g_.blocks),
        at_begin_(g_.jerk_shares.size()),
        at_end_(g_.levels * g_.jerk_shares.size()),
        is_known_(g_.levels) {}

  SpeedChain solve() {
    best_[0].time = 0;
    for (std::size_t end = 1; end < g_.nodes(); ++end) {
      // Segments from the nearest node to the farthest one, whose peaks are those of the nearer ones and of one more
      // interval.
      std::fill(peaks_.begin(), peaks_.end(), 0.0);
      const std::size_t first = end - std::min(end, g_.most_intervals);
      for (std::size_t begin = end; begin-- > first;) {
        widen(begin);
        connect(begin, end);
      }
    }
    return backtracked();
  }

 private:
  double speed(std::size_t node, std::size_t level) const { return g_.speeds[node * g_.levels + level]; }
  Choice& best(std::size_t node, std::size_t level) { return best_[node * g_.levels + level]; }

  void widen(std::size_t interval) {
    const std::size_t intervals = g_.nodes() - 1;
    for (std::size_t n = 0; n < 6; ++n)
      for (std::size_t i = 0; i < g_.blocks; ++i) {
        double& peak = peaks_[n * g_.blocks + i];
        peak = std::max(peak, g_.peaks[(n * intervals + interval) * g_.blocks + i]);
      }
    for (std::size_t i = 0; i < g_.blocks; ++i) {
      inverse_[i] = 1 / std::max(peaks_[g_.blocks + i], tiny);
      inverse_[g_.blocks + i] = 1 / std::max(peaks_[2 * g_.blocks + i], tiny);
    }
  }

  // Bounds where v is the greatest speed, which keep every limit up to the widened node.
  Bounds bounds(double v, double jerk_share) const {
    const std::size_t n = g_.blocks;
    const double *m1v = peaks_.data(), *m2a = m1v + 3 * n, *m2j = m1v + 4 * n, *m3j = m1v + 5 * n;
    const double v2 = v * v, v3 = v2 * v;
    double of_acceleration = inf, of_curvature = inf, fastest = 0;
    for (std::size_t i = 0; i < n; ++i) {
      fastest = std::max(fastest, m1v[i]);
      of_acceleration = std::min(of_acceleration, (1 - m2a[i] * v2) * inverse_[i]);
      of_curvature = std::min(of_curvature, (1 - m3j[i] * v3) / std::max(3 * m2j[i] * v, tiny));
    }
    if (fastest * v > 1 + 1e-12) return {};
    Bounds found{std::min(of_acceleration, jerk_share * of_curvature), inf};
    for (std::size_t i = 0; i < n; ++i)
      found.j = std::min(found.j, ((1 - m3j[i] * v3) - 3 * m2j[i] * (v * found.a)) * inverse_[n + i]);
    return found;
  }

  // Time of a segment: a triangular or trapezoidal acceleration, and the rest at the greater speed.
  static double duration(const Bounds& b, double v0, double v1, double length) {
    if (!(b.a > 0 && b.j > 0)) return inf;
    const double change = std::abs(v1 - v0);
    const double ramp = change * b.j < b.a * b.a ? 2 * std::sqrt(change / b.j) : change / b.a + b.a / b.j;
    const double cruise = length - (v0 + v1) / 2 * ramp;
    return cruise >= 0 ? ramp + cruise / std::max(v0, v1) : inf;
  }

  // Bounds of one greatest speed for every jerk share, computed when they are first needed.
  const Bounds* at(double v, Bounds* found, char& is_known) const {
    if (!is_known)
      for (std::size_t i = 0; i < g_.jerk_shares.size(); ++i) found[i] = bounds(v, g_.jerk_shares[i]);
    is_known = 1;
    return found;
  }

  // Of equal times the one from the farthest node is taken.
  static void take(double time, std::size_t node, std::size_t level, Choice& choice) {
    const bool is_equal = time <= choice.time * (1 + equal) && time < inf;
    if (time < choice.time * (1 - equal) || (is_equal && node < choice.node))
      choice = {std::min(time, choice.time), node, level};
  }

  void connect(std::size_t begin, std::size_t end) {
    const double length = g_.positions[end] - g_.positions[begin];
    const std::size_t shares = g_.jerk_shares.size();
    std::fill(is_known_.begin(), is_known_.end(), 0);
    for (std::size_t level = 0; level < g_.levels; ++level) {
      const double time = best(begin, level).time, v0 = speed(begin, level);
      if (time == inf) continue;
      char is_begin_known = 0;
      for (std::size_t after = 0; after < g_.levels; ++after) {
        const double v1 = speed(end, after), top = std::max(v0, v1);
        Choice& choice = best(end, after);
        if (!(top > 0) || time + length / top > choice.time * (1 + equal)) continue;
        const Bounds* b =
            v0 >= v1 ? at(v0, at_begin_.data(), is_begin_known) : at(v1, &at_end_[after * shares], is_known_[after]);
        for (std::size_t i = 0; i < shares; ++i) {
          const double total = time + duration(b[i], v0, v1, length);
          take(total, begin, level, choice);
        }
      }
    }
  }

  SpeedChain backtracked() {
    SpeedChain found;
    if (best(g_.nodes() - 1, 0).time == inf) return found;
    std::vector<std::size_t> nodes, levels;
    for (std::size_t node = g_.nodes() - 1, level = 0;;) {
      nodes.push_back(node), levels.push_back(level);
      if (node == 0) break;
      const Choice choice = best(node, level);
      node = choice.node, level = choice.level;
    }
    for (std::size_t i = nodes.size() - 1; i > 0; --i) {
      const std::size_t begin = nodes[i], end = nodes[i - 1];
      const double v0 = speed(begin, levels[i]), v1 = speed(end, levels[i - 1]);
      std::fill(peaks_.begin(), peaks_.end(), 0.0);
      for (std::size_t interval = begin; interval < end; ++interval) widen(interval);
      Bounds chosen;
      double least = inf;
      for (double share : g_.jerk_shares) {
        const Bounds b = bounds(std::max(v0, v1), share);
        const double time = duration(b, v0, v1, g_.positions[end] - g_.positions[begin]);
        if (time < least) least = time, chosen = b;
      }
      found.begin.push_back(static_cast<std::int64_t>(begin));
      found.end.push_back(static_cast<std::int64_t>(end));
      found.before.push_back(v0), found.after.push_back(v1);
      found.bounds.insert(found.bounds.end(), {std::max(v0, v1), chosen.a, chosen.j});
    }
    return found;
  }

  const SpeedGrid& g_;
  std::vector<Choice> best_;
  std::vector<double> peaks_, inverse_;
  std::vector<Bounds> at_begin_, at_end_;
  std::vector<char> is_known_;
};

}  // namespace

SpeedChain fastest_chain(const SpeedGrid& grid) { return Chain(grid).solve(); }

}  // namespace wayproof
