// What timing along a path by toppra computes beside its linear programs, on numpy arrays.
#include <nanobind/stl/pair.h>

#include <cmath>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "math/bernstein.hpp"
#include "path/path_cells.hpp"
#include "path/path_motion.hpp"

namespace wayproof {
namespace {

using Path = std::pair<Doubles, Doubles>;
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

auto cells(const Path& path, const Doubles& velocity, const Doubles& acceleration) {
  const PolynomialPath along = path_of(path, 3);
  const auto v = limits_of(velocity, along.joints, "velocity"),
             a = limits_of(acceleration, along.joints, "acceleration");
  const PathCells found = cut_into_cells(along, v, a);
  const std::size_t count = found.path.pieces(), rows = found.a.size() / count;
  bool* flags = new bool[count];
  std::copy(found.is_line.begin(), found.is_line.end(), flags);
  const nb::capsule owner(flags, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  return nb::make_tuple(array_of(found.path.breaks, count + 1), nb::ndarray<nb::numpy, bool>(flags, {count}, owner),
                        array_of(found.speed, count), array_of(found.acceleration, count),
                        array_of(found.a, count, rows), array_of(found.b, count, rows), array_of(found.caps, count + 1),
                        found.time_unit);
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
  constexpr std::size_t most_terms = 64;
  const PolynomialPath along = path_of(path, most_terms);
  const std::size_t n = row(h, "h").size();
  const SpeedProfile given{copy_of(s, n + 1, "s"), copy_of(v, n, "v"), copy_of(a, n, "a"), copy_of(j, n, "j"),
                           copy_of(h, n, "h")};
  const PathMotion found = compose(along, given);
  return nb::make_tuple(array_of(found.times, n + 1), array_of(found.pieces, n),
                        array_of(found.coefficients, n, found.terms, along.joints));
}

// The largest magnitude of polynomials over the limit of their column, and the column; an upper bound, within a share
// `gap` of what is attained. Coefficients in Bernstein form: [pieces][terms][columns].
auto utilization(const Doubles& polynomials, const Doubles& limits, double gap) {
  require(polynomials.ndim() == 3 && polynomials.size() > 0,
          "polynomials do not have the shape (pieces, terms, columns)");
  const std::size_t pieces = polynomials.shape(0), terms = polynomials.shape(1), columns = polynomials.shape(2);
  const std::vector<double> bounds = limits_of(limits, columns, "limits");
  const auto all = finite({polynomials.data(), polynomials.size()}, "polynomials");
  const auto at = [&](std::size_t i, std::size_t k, std::size_t c) { return all[(i * terms + k) * columns + c]; };
  const auto size = [&](std::size_t i, std::size_t k, std::size_t c) { return std::abs(at(i, k, c)) / bounds[c]; };
  double attained = -1;
  std::size_t column = 0;
  for (std::size_t i = 0; i < pieces; ++i)
    for (std::size_t c = 0; c < columns; ++c) {
      const double ends = std::max(size(i, 0, c), size(i, terms - 1, c));
      if (ends > attained) attained = ends, column = c;
    }
  const double open = attained * (1 + gap);
  double closed = 0;
  std::vector<double> rows;
  std::vector<std::size_t> owners;
  for (std::size_t i = 0; i < pieces; ++i)
    for (std::size_t c = 0; c < columns; ++c) {
      double upper = 0;
      for (std::size_t k = 0; k < terms; ++k) upper = std::max(upper, size(i, k, c));
      if (!(upper > open)) {
        closed = std::max(closed, upper);
        continue;
      }
      for (std::size_t k = 0; k < terms; ++k) rows.push_back(at(i, k, c) / bounds[c]);
      owners.push_back(c);
    }
  double fraction = attained;
  if (!owners.empty()) {
    const std::size_t half = rows.size();
    for (std::size_t k = 0; k < half; ++k) rows.push_back(-rows[k]);
    const Peak top = peak(rows, terms, attained * gap);
    if (top.bound > fraction) fraction = top.bound, column = owners[top.row % owners.size()];
  }
  return nb::make_tuple(std::max(fraction, closed), column);
}

}  // namespace

void bind_retime(nb::module_& m) {
  m.def(
      "path_cells", &cells, nb::arg("path"), nb::arg("velocity"), nb::arg("acceleration"),
      "Cells of a path (breaks, coefficients) of lines and parabolas: edges, is_line, speed, acceleration, a, b, caps, "
      "time_unit.");
  m.def("profile_between", &profile, nb::arg("edges"), nb::arg("x"), nb::arg("is_line"), nb::arg("speed"),
        nb::arg("acceleration"), nb::arg("braking"),
        "The fastest profile (s, v, a, j, h) with squared speeds at edges.");
  m.def("compose", &composed, nb::arg("path"), nb::arg("s"), nb::arg("v"), nb::arg("a"), nb::arg("j"), nb::arg("h"),
        "The motion along a path: times, pieces of the path, coefficients.");
  m.def("utilization", &utilization, nb::arg("polynomials"), nb::arg("limits"), nb::arg("gap"),
        "The largest magnitude over its column's limit, of Bernstein coefficients, and the column.");
}

}  // namespace wayproof
