// Timing along a path, on numpy arrays.
#include <nanobind/stl/pair.h>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "path/blended_path.hpp"
#include "path/box_visits.hpp"
#include "path/corners.hpp"
#include "path/duration_bound.hpp"
#include "path/path_motion.hpp"
#include "speeds/speed_cells.hpp"
#include "speeds/speed_passes.hpp"
#include "speeds/timed_path.hpp"
#include "speeds/utilization.hpp"

namespace wayproof {
namespace {

using Path = std::pair<Doubles, Doubles>;
constexpr std::size_t most_terms = 64;
using Flags = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

std::vector<double> copy_of(std::span<const double> numbers) { return {numbers.begin(), numbers.end()}; }

std::vector<double> copy_of(const Doubles& array, std::size_t count, const char* name) {
  return copy_of(finite(row(array, count, name), name));
}

PolynomialPath path_of(const Path& given, std::size_t most_terms) {
  const auto& [breaks, coefficients] = given;
  PolynomialPath path;
  path.breaks = copy_of(finite(row(breaks, "breaks"), "breaks"));
  if (path.breaks.size() < 2) refuse("breaks have fewer than two numbers");
  for (std::size_t i = 1; i < path.breaks.size(); ++i)
    if (!(path.breaks[i] > path.breaks[i - 1])) refuse("breaks do not rise at " + std::to_string(i));
  if (coefficients.ndim() != 3 || coefficients.shape(0) != path.pieces() || coefficients.shape(2) < 1)
    refuse("coefficients do not have the shape (pieces, terms, joints)");
  path.terms = coefficients.shape(1), path.joints = coefficients.shape(2);
  if (path.terms < 2 || path.terms > most_terms)
    refuse("coefficients have " + std::to_string(path.terms) + " terms, not 2 to " + std::to_string(most_terms));
  path.coefficients = copy_of(finite({coefficients.data(), coefficients.size()}, "coefficients"));
  return path;
}

std::vector<double> limits_of(const Doubles& array, std::size_t joints, const char* name) {
  std::vector<double> limits = copy_of(array, joints, name);
  for (double limit : limits) positive(limit, name);
  return limits;
}

// Of each smooth piece: times, pieces of the path, coefficients, both utilizations with their joints, and the duration
// before the audit. None if a piece has no profile.
nb::object timed(const Path& path, const Doubles& velocity, const Doubles& acceleration) {
  const PolynomialPath along = path_of(path, 3);
  const auto v = limits_of(velocity, along.joints, "velocity"),
             a = limits_of(acceleration, along.joints, "acceleration");
  const auto found = time_path(along, v, a);
  if (!found) return nb::none();
  nb::list pieces;
  for (const TimedPath& piece : *found) {
    const PathMotion& motion = piece.motion;
    const std::size_t n = motion.pieces.size();
    const auto use = [&](std::size_t order) {
      return nb::make_tuple(piece.uses[order].fraction, piece.uses[order].joint);
    };
    pieces.append(nb::make_tuple(array_of(motion.times, n + 1), array_of(motion.pieces, n),
                                 array_of(motion.coefficients, n, motion.terms, along.joints), use(0), use(1),
                                 piece.raw_duration));
  }
  return pieces;
}

// Empty if there are none.
auto speeds(const Doubles& edges, const Doubles& a, const Doubles& b, const Doubles& caps) {
  const auto along = finite(row(edges, "edges"), "edges");
  require(along.size() >= 2, "edges have fewer than two numbers");
  require(a.ndim() == 2 && b.ndim() == 2, "a and b do not have the shape (cells, rows)");
  const std::size_t count = along.size() - 1, rows = a.shape(1);
  const std::vector<double> found =
      squared_speeds(along, finite(table(a, count, rows, "a").all(), "a"),
                     finite(table(b, count, rows, "b").all(), "b"), ordered(row(caps, count + 1, "caps"), "caps"));
  return array_of(found, found.size());
}

auto profile(const Doubles& edges, const Doubles& x, const Flags& is_line, const Doubles& speed,
             const Doubles& acceleration, const Doubles& braking) {
  const std::size_t count = is_line.shape(0);
  require(count > 0, "is_line is empty: there are no cells");
  const CellLimits cells{finite(row(edges, count + 1, "edges"), "edges"),
                         {is_line.data(), count},
                         ordered(row(speed, count, "speed"), "speed"),
                         ordered(row(acceleration, count, "acceleration"), "acceleration"),
                         ordered(row(braking, count, "braking"), "braking")};
  const SpeedProfile found = profile_between(cells, finite(row(x, count + 1, "x"), "x"));
  const std::size_t n = found.h.size();
  return nb::make_tuple(array_of(found.s, n + 1), array_of(found.v, n), array_of(found.a, n), array_of(found.j, n),
                        array_of(found.h, n));
}

auto composed(const Path& path, const Doubles& s, const Doubles& v, const Doubles& a, const Doubles& j,
              const Doubles& h) {
  const PolynomialPath along = path_of(path, most_terms);
  const std::size_t n = row(h, "h").size();
  const SpeedProfile given{copy_of(s, n + 1, "s"), copy_of(v, n, "v"), copy_of(a, n, "a"), copy_of(j, n, "j"),
                           copy_of(h, n, "h")};
  const PathMotion found = compose(along, given);
  return nb::make_tuple(array_of(found.times, n + 1), array_of(found.pieces, n),
                        array_of(found.coefficients, n, found.terms, along.joints));
}

// The largest magnitude of a derivative of polynomials over the limit of their column, and the column.
auto used(const Doubles& coefficients, const Doubles& widths, const Doubles& limits, std::int64_t order) {
  require(coefficients.ndim() == 3 && coefficients.size() > 0,
          "coefficients do not have the shape (pieces, terms, columns)");
  require(order >= 0 && order <= 3, "order is not from 0 to 3");
  const std::size_t pieces = coefficients.shape(0), terms = coefficients.shape(1), columns = coefficients.shape(2);
  const std::vector<double> bounds = limits_of(limits, columns, "limits");
  const auto lengths = finite(row(widths, pieces, "widths"), "widths");
  const auto all = finite({coefficients.data(), coefficients.size()}, "coefficients");
  const Utilization found = utilization({lengths, all, terms, columns}, bounds, static_cast<std::size_t>(order));
  return nb::make_tuple(found.fraction, found.joint);
}

// Smallest number of derivatives that continue: 1 or 2.
std::size_t smoothness_of(std::int64_t smoothness) {
  require(smoothness == 1 || smoothness == 2, "smoothness is neither 1 nor 2");
  return static_cast<std::size_t>(smoothness);
}

auto corners_of(const Path& path, std::int64_t smoothness) {
  const std::vector<std::size_t> found = corners(path_of(path, most_terms), smoothness_of(smoothness));
  return array_of(std::vector<std::int64_t>(found.begin(), found.end()), found.size());
}

double least_duration(const Path& path, const Doubles& bases, const Doubles& limits, std::int64_t smoothness) {
  const PolynomialPath along = path_of(path, most_terms);
  const auto rates = ordered(table(limits, 3, along.joints, "limits").all(), "limits");
  for (double rate : rates) require(rate > 0, "limits are not positive");
  return duration_bound(along, finite(table(bases, along.pieces(), along.joints, "bases").all(), "bases"),
                        smoothness_of(smoothness), rates);
}

auto peaks_on_cells(const Path& path, const Doubles& limits, std::int64_t count, std::int64_t least) {
  const PolynomialPath along = path_of(path, most_terms);
  const auto rates = ordered(table(limits, 3, along.joints, "limits").all(), "limits");
  for (double rate : rates) require(rate > 0, "limits are not positive");
  constexpr std::int64_t most_cells = 100'000;
  require(count > 0 && count <= most_cells && least > 0 && least <= most_cells, "count and least are at least 1");
  const SpeedCells found = speed_cells(along, rates, static_cast<std::size_t>(count), static_cast<std::size_t>(least));
  const std::size_t n = found.pieces.size();
  return nb::make_tuple(array_of(found.edges, n + 1), array_of(found.pieces, n),
                        array_of(found.peaks, 6, n, along.joints));
}

auto blended(const Doubles& waypoints, double deviation, bool has_smooth_curvature) {
  require(waypoints.ndim() == 2 && waypoints.shape(0) >= 3 && waypoints.shape(1) >= 1,
          "waypoints do not have the shape (3 or more, joints)");
  const std::size_t joints = waypoints.shape(1);
  const BlendedPath found = blend(finite({waypoints.data(), waypoints.size()}, "waypoints"), joints,
                                  positive(deviation, "deviation"), has_smooth_curvature);
  const std::size_t n = found.breaks.size() - 1;
  return nb::make_tuple(array_of(found.breaks, n + 1), array_of(found.bases, n, joints),
                        array_of(found.coefficients, n, found.terms, joints));
}

auto visits(const Doubles& breaks, const Doubles& points, const Doubles& half, std::int64_t halvings) {
  const auto along = finite(row(breaks, "breaks"), "breaks");
  require(points.ndim() == 3 && points.shape(0) + 1 == along.size() && points.shape(1) >= 1 && points.shape(2) == 3,
          "points do not have the shape (breaks - 1, terms, 3)");
  constexpr int most_halvings = 30;
  require(halvings >= 0 && halvings <= most_halvings, "halvings is not from 0 to 30");
  const BoxVisits found = box_visits(along, finite({points.data(), points.size()}, "points"), points.shape(1),
                                     finite(row(half, 3, "half"), "half"), static_cast<int>(halvings));
  const std::size_t n = found.pieces.size();
  return nb::make_tuple(array_of(found.pieces, n), array_of(found.low, n), array_of(found.high, n));
}

}  // namespace

void bind_retime(nb::module_& m) {
  m.def("time_path", &timed, nb::arg("path"), nb::arg("velocity"), nb::arg("acceleration"),
        "Motions along the smooth pieces of a path (breaks, coefficients) of lines and parabolas: times, pieces, "
        "coefficients, (utilization, joint) of both limits, duration before the audit; None if toppra finds none.");
  m.def("squared_speeds", &speeds, nb::arg("edges"), nb::arg("a"), nb::arg("b"), nb::arg("caps"),
        "The greatest (ds/dt)^2 at the edges of cells, from rest to rest; empty if there are none.");
  m.def("corners", &corners_of, nb::arg("path"), nb::arg("smoothness"),
        "Pieces of a path (breaks, coefficients) at whose beginning one of the first derivatives jumps.");
  m.def("duration_bound", &least_duration, nb::arg("path"), nb::arg("bases"), nb::arg("limits"), nb::arg("smoothness"),
        "A lower bound of a path's duration under limits of velocity, acceleration and jerk.");
  m.def("speed_cells", &peaks_on_cells, nb::arg("path"), nb::arg("limits"), nb::arg("count"), nb::arg("least"),
        "Cells of a path: edges, pieces, and bounds on derivatives over limits, [6][cells][joints].");
  m.def("blend", &blended, nb::arg("waypoints"), nb::arg("deviation"), nb::arg("has_smooth_curvature"),
        "The path through waypoints with rounded corners: breaks, bases, coefficients.");
  m.def("box_visits", &visits, nb::arg("breaks"), nb::arg("points"), nb::arg("half"), nb::arg("halvings"),
        "Parts of a path that contain all visits of a point (Bernstein coefficients in the box's axes) to a box: "
        "pieces, low, high.");
  m.def("profile_between", &profile, nb::arg("edges"), nb::arg("x"), nb::arg("is_line"), nb::arg("speed"),
        nb::arg("acceleration"), nb::arg("braking"),
        "The fastest profile (s, v, a, j, h) with squared speeds at edges.");
  m.def("compose", &composed, nb::arg("path"), nb::arg("s"), nb::arg("v"), nb::arg("a"), nb::arg("j"), nb::arg("h"),
        "The motion along a path: times, pieces of the path, coefficients.");
  m.def("utilization", &used, nb::arg("coefficients"), nb::arg("widths"), nb::arg("limits"), nb::arg("order"),
        "The largest magnitude of a derivative of polynomials over its column's limit, and the column.");
}

}  // namespace wayproof
