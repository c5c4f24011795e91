#include "speeds/timed_path.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "path/corners.hpp"
#include "speeds/path_cells.hpp"
#include "speeds/speed_passes.hpp"

namespace wayproof {
namespace {

// Relative reserve to every limit, as planning/retime/limits/timed_piece.py has it.
constexpr double limit_reserve = 1e-9;

PolynomialPath part_of(const PolynomialPath& path, std::size_t first, std::size_t last) {
  const auto begin = path.breaks.begin() + static_cast<std::ptrdiff_t>(first);
  PolynomialPath part;
  part.terms = path.terms, part.joints = path.joints;
  part.breaks.assign(begin, path.breaks.begin() + static_cast<std::ptrdiff_t>(last) + 1);
  part.coefficients.assign(path.piece(first), path.piece(last));
  return part;
}

std::optional<SpeedProfile> profile_of(const PolynomialPath& piece, std::span<const double> velocity,
                                       std::span<const double> acceleration) {
  const PathCells cells = cut_into_cells(piece, velocity, acceleration);
  const std::size_t count = cells.path.pieces();
  const std::unique_ptr<bool[]> is_line(new bool[count]);
  std::copy(cells.is_line.begin(), cells.is_line.end(), is_line.get());
  const CellLimits limits{
      cells.path.breaks, {is_line.get(), count}, cells.speed, cells.acceleration, cells.acceleration};
  std::vector<double> x(2, 0.0);
  if (count > 1 || !is_line[0]) {
    x = squared_speeds(cells.path.breaks, cells.a, cells.b, cells.caps);
    if (x.empty()) return std::nullopt;
    const double unit = cells.time_unit * cells.time_unit;
    for (double& square : x) square /= unit;
    for (std::size_t i = 0; i < count; ++i)
      if (!is_line[i] && !(x[i] + x[i + 1] > 0)) return std::nullopt;
  }
  return profile_between(limits, x);
}

// The motion takes `scale` times as long.
void scale_time(PathMotion& motion, double scale, std::size_t joints) {
  for (double& time : motion.times) time *= scale;
  const double inverse = 1 / scale;
  std::vector<double> powers(motion.terms, 1.0);
  for (std::size_t k = 1; k < motion.terms; ++k) powers[k] = powers[k - 1] * inverse;
  for (std::size_t i = 0; i < motion.coefficients.size(); ++i)
    motion.coefficients[i] *= powers[i / joints % motion.terms];
}

}  // namespace

std::optional<std::vector<TimedPath>> time_path(const PolynomialPath& path, std::span<const double> velocity,
                                                std::span<const double> acceleration) {
  std::vector<TimedPath> found;
  std::vector<std::size_t> edges = corners(path, 1);
  edges.push_back(path.pieces());
  for (std::size_t first = 0; const std::size_t last : edges) {
    const PolynomialPath piece = part_of(path, first, last);
    const auto profile = profile_of(piece, velocity, acceleration);
    if (!profile) return std::nullopt;
    TimedPath timed{compose(piece, *profile), {}, 0};
    PathMotion& motion = timed.motion;
    timed.raw_duration = motion.times.back();
    std::vector<double> widths(motion.pieces.size());
    for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = motion.times[i + 1] - motion.times[i];
    const Polynomials raw{widths, motion.coefficients, motion.terms, path.joints};
    timed.uses = {utilization(raw, velocity, 1), utilization(raw, acceleration, 2)};
    const double scale = std::max(timed.uses[0].fraction, std::sqrt(timed.uses[1].fraction)) * (1 + limit_reserve);
    timed.uses[0].fraction /= scale, timed.uses[1].fraction /= scale * scale;
    scale_time(motion, scale, path.joints);
    for (auto& i : motion.pieces) i += static_cast<std::int64_t>(first);
    found.push_back(std::move(timed));
    first = last;
  }
  return found;
}

}  // namespace wayproof
