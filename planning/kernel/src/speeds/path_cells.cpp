#include "speeds/path_cells.hpp"

#include <algorithm>
#include <cmath>

#include "path/path_motion.hpp"

namespace wayproof {
namespace {

// As planning/retime/toppra/toppra_retimer.py has them.
constexpr double least_cells = 2, cells_per_radian = 6, most_cells = 64;
constexpr int curved_factor = 2;
constexpr double unbounded = 1e6, least_relative_rate = 1e-9;

double length(const double* x, std::size_t count) {
  double even = 0, odd = 0;
  for (std::size_t v = 0; v < count; v += 2) even += x[v] * x[v];
  for (std::size_t v = 1; v < count; v += 2) odd += x[v] * x[v];
  return count == 1 ? std::abs(x[0]) : std::sqrt(even + odd);
}

bool is_line(const PolynomialPath& path, std::size_t piece) {
  const double* c = path.piece(piece);
  for (std::size_t i = 2 * path.joints; i < path.terms * path.joints; ++i)
    if (c[i] != 0) return false;
  return true;
}

// Cells of every piece: more for larger changes of direction.
std::vector<std::size_t> counts_of(const PolynomialPath& path, const std::vector<bool>& lines) {
  const int factor = std::count(lines.begin(), lines.end(), true) ? 1 : curved_factor;
  double max_rate = 0;
  for (std::size_t i = 0; i < path.pieces(); ++i)
    max_rate = std::max(max_rate, length(path.piece(i) + path.joints, path.joints));
  std::vector<std::size_t> counts(path.pieces(), 1);
  for (std::size_t i = 0; i < path.pieces(); ++i) {
    if (lines[i]) continue;
    const double width = path.breaks[i + 1] - path.breaks[i];
    const double turn = length(path.piece(i) + 2 * path.joints, path.joints) * width * 2 / max_rate;
    const double count = std::min(std::ceil(least_cells + cells_per_radian * turn), most_cells);
    counts[i] = static_cast<std::size_t>(factor) * static_cast<std::size_t>(count);
  }
  return counts;
}

// r' at the beginning of a cell, and at its end; lines have one.
struct Rates {
  std::vector<double> first, last;
};

Rates rates_of(const PolynomialPath& cells) {
  Rates rates;
  for (std::size_t i = 0; i < cells.pieces(); ++i) {
    const double* c = cells.piece(i);
    const double width = cells.breaks[i + 1] - cells.breaks[i];
    for (std::size_t v = 0; v < cells.joints; ++v) {
      const double slope = c[cells.joints + v];
      rates.first.push_back(slope);
      rates.last.push_back(cells.terms > 2 ? slope + 2 * c[2 * cells.joints + v] * width : slope);
    }
  }
  return rates;
}

// The largest speed and acceleration along each cell.
void limit_lines(PathCells& cells, const Rates& rates, std::span<const double> velocity,
                 std::span<const double> acceleration) {
  const std::size_t joints = cells.path.joints, count = cells.path.pieces();
  std::vector<double> peaks(count * joints);
  for (std::size_t i = 0; i < peaks.size(); ++i) peaks[i] = std::max(std::abs(rates.first[i]), std::abs(rates.last[i]));
  const double least = least_relative_rate * *std::max_element(peaks.begin(), peaks.end());
  for (std::size_t i = 0; i < count; ++i) {
    double speed = INFINITY, most = INFINITY;
    for (std::size_t v = 0; v < joints; ++v) {
      const double peak = std::max(peaks[i * joints + v], least);
      speed = std::min(speed, velocity[v] / peak);
      most = std::min(most, acceleration[v] / peak);
    }
    cells.speed.push_back(speed);
    cells.acceleration.push_back(most);
  }
}

// The largest (ds/dt)^2 at both ends of a cell; planning/retime/jerk/velocity_bounds.py has the formulas.
void bound_ends(const double* first, const double* last, std::span<const double> velocity, double* bounds) {
  bounds[0] = bounds[1] = INFINITY;
  for (std::size_t v = 0; v < velocity.size(); ++v) {
    const double begin = std::abs(first[v]), end = std::abs(last[v]), top = std::max(begin, end), level = top * top;
    const double ratio = end / begin, gain = ratio - 1, loss = 1 / (ratio * ratio) - 1;
    double tau = (2 * gain + loss) / (-3 * gain * loss);
    if (!(tau > 0 && tau < 1)) tau = 0.5;
    const double rise = 1 + gain * tau, product = rise * rise * (1 + loss * tau);
    const double excess = product < 1 ? 1 : product;  // NaN stays
    const bool is_sloped = excess * begin * end < level;
    const double square = velocity[v] * velocity[v];
    bounds[0] = std::min(bounds[0], square / (is_sloped ? excess * (begin * begin) : level));
    bounds[1] = std::min(bounds[1], square / (is_sloped ? excess * (end * end) : level));
  }
}

// The smaller bound of both adjacent cells at each edge.
void bound_edges(PathCells& cells, const Rates& rates, std::span<const double> velocity) {
  const std::size_t joints = cells.path.joints, count = cells.path.pieces();
  const double unit = cells.time_unit * cells.time_unit;
  cells.caps.assign(count + 1, unbounded);
  for (std::size_t i = 0; i < count; ++i) {
    double bounds[2];
    bound_ends(&rates.first[i * joints], &rates.last[i * joints], velocity, bounds);
    for (std::size_t end : {0, 1}) cells.caps[i + end] = std::min(cells.caps[i + end], bounds[end] * unit);
  }
}

// Limits of acceleration at both ends of every cell, of the joints that move, in both directions.
void limit_curves(PathCells& cells, std::span<const double> acceleration) {
  const PolynomialPath& path = cells.path;
  std::vector<std::size_t> moving;
  for (std::size_t v = 0; v < path.joints; ++v)
    for (std::size_t i = 0; i < path.pieces() && (moving.empty() || moving.back() != v); ++i)
      for (std::size_t k = 1; k < path.terms; ++k)
        if (path.piece(i)[k * path.joints + v] != 0) {
          moving.push_back(v);
          break;
        }
  const double unit = cells.time_unit * cells.time_unit;
  for (std::size_t i = 0; i < path.pieces(); ++i) {
    const double* c = path.piece(i);
    const double width = path.breaks[i + 1] - path.breaks[i];
    for (double local : {0.0, width})
      for (double sign : {1.0, -1.0})
        for (std::size_t v : moving) {
          const double bend = path.terms > 2 ? 2 * c[2 * path.joints + v] : 0;
          const double rate = path.terms > 2 ? bend * local + c[path.joints + v] : c[path.joints + v];
          const double a = sign * (rate / acceleration[v]), b = sign * (bend / acceleration[v]);
          cells.a.push_back((a + 2 * local * b) / unit);
          cells.b.push_back(b / unit);
        }
  }
}

}  // namespace

double numpy_sum(std::span<const double> x) {
  const std::size_t count = x.size();
  if (count > 128) {
    const std::size_t half = count / 2 - count / 2 % 8;
    return numpy_sum(x.first(half)) + numpy_sum(x.subspan(half));
  }
  double total = 0;
  std::size_t k = 0;
  if (count >= 8) {
    double r[8] = {x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7]};
    for (k = 8; k + 8 <= count; k += 8)
      for (std::size_t l = 0; l < 8; ++l) r[l] += x[k + l];
    total = ((r[0] + r[1]) + (r[2] + r[3])) + ((r[4] + r[5]) + (r[6] + r[7]));
  }
  for (; k < count; ++k) total += x[k];
  return total;
}

PathCells cut_into_cells(const PolynomialPath& path, std::span<const double> velocity,
                         std::span<const double> acceleration) {
  std::vector<bool> lines(path.pieces());
  for (std::size_t i = 0; i < path.pieces(); ++i) lines[i] = is_line(path, i);
  const std::vector<std::size_t> counts = counts_of(path, lines);
  PathCells cells;
  cells.path.terms = path.terms, cells.path.joints = path.joints;
  for (std::size_t i = 0; i < path.pieces(); ++i) {
    const double width = (path.breaks[i + 1] - path.breaks[i]) / static_cast<double>(counts[i]);
    for (std::size_t part = 0; part < counts[i]; ++part) {
      const double offset = static_cast<double>(part) * width;
      cells.path.breaks.push_back(path.breaks[i] + offset);
      cells.pieces.push_back(static_cast<std::int64_t>(i));
      cells.is_line.push_back(lines[i]);
      append_shifted(path.piece(i), path.terms, path.joints, offset, cells.path.coefficients);
    }
  }
  cells.path.breaks.push_back(path.breaks.back());
  const Rates rates = rates_of(cells.path);
  limit_lines(cells, rates, velocity, acceleration);
  std::vector<double> durations(cells.path.pieces());
  for (std::size_t i = 0; i < durations.size(); ++i)
    durations[i] = (cells.path.breaks[i + 1] - cells.path.breaks[i]) / cells.speed[i];
  cells.time_unit = numpy_sum(durations);
  bound_edges(cells, rates, velocity);
  limit_curves(cells, acceleration);
  return cells;
}

}  // namespace wayproof
