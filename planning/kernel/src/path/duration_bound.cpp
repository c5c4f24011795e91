#include "path/duration_bound.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "math/elementary.hpp"
#include "path/corners.hpp"

namespace wayproof {
namespace {

// Steps between samples of each smooth piece.
constexpr std::size_t steps = 64;

struct Samples {
  std::vector<double> q;  // [steps + 1][joints]
  std::size_t joints;

  double moved(std::size_t to, std::size_t from, std::size_t joint) const {
    return std::abs(q[to * joints + joint] - q[from * joints + joint]);
  }
};

// Between two breaks, both ends included.
Samples samples_of(const PolynomialPath& path, std::span<const double> bases, std::size_t first, std::size_t last) {
  const double begin = path.breaks[first], width = path.breaks[last] - begin;
  Samples found{{}, path.joints};
  found.q.reserve((steps + 1) * path.joints);
  std::size_t piece = first;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double s = i == steps ? path.breaks[last] : begin + width * (static_cast<double>(i) / steps);
    while (piece + 1 < last && s >= path.breaks[piece + 1]) ++piece;
    const double local = s - path.breaks[piece];
    for (std::size_t v = 0; v < path.joints; ++v) {
      double total = 0;
      for (std::size_t k = path.terms; k-- > 0;) total = total * local + path.piece(piece)[k * path.joints + v];
      found.q.push_back(bases[piece * path.joints + v] + total);
    }
  }
  return found;
}

// From rest to rest.
double piece_bound(const Samples& samples, std::span<const double> limits) {
  const std::size_t joints = samples.joints;
  std::array<double, steps + 1> times{}, before{}, after{};
  for (std::size_t i = 0; i <= steps; ++i)
    for (std::size_t v = 0; v < joints; ++v) {
      const double velocity = limits[v], acceleration = limits[joints + v], jerk = limits[2 * joints + v];
      before[i] = std::max(before[i], duration_from_rest(samples.moved(i, 0, v), velocity, acceleration, jerk));
      after[i] = std::max(after[i], duration_from_rest(samples.moved(i, steps, v), velocity, acceleration, jerk));
    }
  for (std::size_t i = 1; i <= steps; ++i) {
    double step = 0;
    for (std::size_t v = 0; v < joints; ++v) step = std::max(step, samples.moved(i, i - 1, v) / limits[v]);
    times[i] = times[i - 1] + step;
    // The bound to a sample is its own, or that of one before it and the steps from there.
    before[i] = std::max(before[i], before[i - 1] + step);
  }
  double bound = 0;
  for (std::size_t i = steps + 1; i-- > 0;) {
    if (i < steps) after[i] = std::max(after[i], after[i + 1] + (times[i + 1] - times[i]));
    bound = std::max(bound, before[i] + after[i]);
  }
  return bound;
}

}  // namespace

double duration_from_rest(double distance, double velocity, double acceleration, double jerk) {
  const double jerk_time = std::min(acceleration / jerk, std::sqrt(2 * velocity / jerk));
  const double speed = jerk_time > 0 ? std::min(velocity, acceleration * jerk_time / 2) : 0;
  const double jerk_distance = speed * jerk_time / 3;
  const double ramp_time = (velocity - speed) / acceleration, ramp_distance = ramp_time * (speed + velocity) / 2;
  const double in_ramp = std::clamp(distance - jerk_distance, 0.0, std::max(ramp_distance, 0.0));
  const double at_speed = std::max(distance - jerk_distance - ramp_distance, 0.0);
  const double cube = 6 * std::min(distance, jerk_distance) / jerk;
  const double in_jerk = std::isnormal(cube) ? cube_root(cube) : 0;
  // The root that does not cancel where the distance is small against the speed.
  const double root = std::sqrt(speed * speed + 2 * acceleration * in_ramp);
  return in_jerk + 2 * in_ramp / std::max(root + speed, 1e-300) + at_speed / velocity;
}

double duration_bound(const PolynomialPath& path, std::span<const double> bases, std::size_t smoothness,
                      std::span<const double> limits) {
  std::vector<std::size_t> edges = corners(path, smoothness);
  edges.insert(edges.begin(), 0);
  edges.push_back(path.pieces());
  double total = 0;
  for (std::size_t i = 1; i < edges.size(); ++i)
    total += piece_bound(samples_of(path, bases, edges[i - 1], edges[i]), limits);
  return total;
}

}  // namespace wayproof
