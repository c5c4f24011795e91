#include "path/blended_path.hpp"

#include <algorithm>
#include <cmath>

#include "speeds/path_cells.hpp"

namespace wayproof {
namespace {

// As planning/retime/blend.py has them.
constexpr double least_corner_cosine = -0.98, least_turn = 1e-9, least_length = 1e-9;

// Lines between waypoints: lengths and unit directions, which a line keeps to its end.
struct Lines {
  std::size_t joints;
  std::vector<double> lengths, directions;

  std::size_t count() const { return lengths.size(); }
  const double* direction(std::size_t i) const { return &directions[i * joints]; }
};

Lines lines_of(std::span<const double> waypoints, std::size_t joints) {
  Lines lines{joints, {}, {}};
  std::vector<double> squares(joints);
  for (std::size_t i = joints; i < waypoints.size(); i += joints) {
    const std::size_t begin = lines.directions.size();
    for (std::size_t v = 0; v < joints; ++v) {
      const double step = waypoints[i + v] - waypoints[i - joints + v];
      lines.directions.push_back(step);
      squares[v] = step * step;
    }
    const double length = std::sqrt(numpy_sum(squares));
    for (std::size_t v = begin; v < lines.directions.size(); ++v) lines.directions[v] /= length;
    lines.lengths.push_back(length);
  }
  return lines;
}

// How far from every waypoint its corner begins; 0 at both ends and at corners that are not rounded.
std::vector<double> blend_lengths(const Lines& lines, double most_offset) {
  std::vector<double> found{0}, squares(lines.joints), products(lines.joints);
  for (std::size_t i = 1; i < lines.count(); ++i) {
    const double *before = lines.direction(i - 1), *after = lines.direction(i);
    for (std::size_t v = 0; v < lines.joints; ++v) {
      squares[v] = (after[v] - before[v]) * (after[v] - before[v]);
      products[v] = before[v] * after[v];
    }
    const double turn = std::sqrt(numpy_sum(squares)), cosine = numpy_sum(products);
    const double most = std::min(lines.lengths[i - 1], lines.lengths[i]) / 2;
    const bool is_rounded = turn > least_turn && cosine > least_corner_cosine;
    found.push_back(is_rounded ? std::min(most_offset / std::max(turn, least_turn), most) : 0);
  }
  found.push_back(0);
  return found;
}

}  // namespace

BlendedPath blend(std::span<const double> waypoints, std::size_t joints, double deviation, bool has_smooth_curvature) {
  const Lines lines = lines_of(waypoints, joints);
  const double factor = has_smooth_curvature ? 16.0 / 3 : 4.0;
  const std::vector<double> lambda = blend_lengths(lines, deviation * factor);
  BlendedPath path;
  path.terms = has_smooth_curvature ? 5 : 3;
  std::vector<double> widths;
  const auto append = [&](double width, std::size_t waypoint) {
    const auto base = waypoints.subspan(waypoint * joints, joints);
    widths.push_back(width);
    path.bases.insert(path.bases.end(), base.begin(), base.end());
    path.coefficients.resize(path.coefficients.size() + path.terms * joints, 0.0);
    return path.coefficients.data() + path.coefficients.size() - path.terms * joints;
  };
  for (std::size_t i = 0; i < lines.count(); ++i) {
    const double* along = lines.direction(i);
    const double straight = lines.lengths[i] - lambda[i] - lambda[i + 1];
    if (straight > least_length) {
      double* c = append(straight, i);
      for (std::size_t v = 0; v < joints; ++v) c[v] = lambda[i] * along[v], c[joints + v] = along[v];
    }
    const double width = 2 * lambda[i + 1];
    if (!(width > 0)) continue;
    const double* after = lines.direction(i + 1);
    double* c = append(width, i + 1);
    for (std::size_t v = 0; v < joints; ++v) {
      const double turn = after[v] - along[v];
      c[v] = -lambda[i + 1] * along[v], c[joints + v] = along[v];
      if (has_smooth_curvature) {
        c[3 * joints + v] = turn / (width * width);
        c[4 * joints + v] = -turn / (2 * (width * width * width));
      } else {
        c[2 * joints + v] = turn / (2 * width);
      }
    }
  }
  const double total = numpy_sum(widths);
  path.breaks.push_back(0);
  double sum = 0;
  for (double width : widths) path.breaks.push_back((sum += width) / total);
  path.breaks.back() = 1;
  std::vector<double> powers(path.terms, 1.0);
  for (std::size_t k = 1; k < path.terms; ++k) powers[k] = powers[k - 1] * total;
  for (std::size_t i = 0; i < path.coefficients.size(); ++i) path.coefficients[i] *= powers[i / joints % path.terms];
  return path;
}

}  // namespace wayproof
