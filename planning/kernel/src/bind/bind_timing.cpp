// Profiles along paths, on numpy arrays and without the interpreter's lock.
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <utility>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "timing/profile_optimizer.hpp"
#include "timing/speed_dp.hpp"

namespace wayproof {
namespace {

using Path = std::tuple<Doubles, Doubles>;
using Profile = std::tuple<Doubles, Doubles, Doubles, Doubles, Doubles>;

std::vector<double> copy_of(std::span<const double> numbers) { return {numbers.begin(), numbers.end()}; }

std::vector<double> copy_of(const Doubles& array, std::size_t count, const char* name) {
  return copy_of(finite(row(array, count, name), name));
}

std::vector<double> rising(const Doubles& array, const char* name) {
  const auto numbers = finite(row(array, name), name);
  for (std::size_t i = 1; i < numbers.size(); ++i)
    if (!(numbers[i] > numbers[i - 1])) refuse(std::string(name) + " do not rise at " + std::to_string(i));
  return copy_of(numbers);
}

std::vector<double> all_positive(std::vector<double> numbers, const char* name) {
  for (double x : numbers) positive(x, name);
  return numbers;
}

PolynomialPath path_of(const Path& given) {
  const auto& [breaks, coefficients] = given;
  PolynomialPath path;
  path.breaks = rising(breaks, "breaks");
  if (path.breaks.size() < 2) refuse("breaks have fewer than two numbers");
  if (coefficients.ndim() != 3 || coefficients.shape(0) != path.pieces() || coefficients.shape(1) < 1)
    refuse("coefficients do not have the shape (pieces, terms, joints)");
  path.terms = coefficients.shape(1), path.joints = coefficients.shape(2);
  path.coefficients = copy_of(finite({coefficients.data(), coefficients.size()}, "coefficients"));
  return path;
}

SpeedProfile profile_of(const Profile& given) {
  const auto& [s, v, a, j, h] = given;
  const std::size_t n = row(h, "h").size();
  if (n < 1) refuse("h is empty");
  return {rising(s, "s"), copy_of(v, n, "v"), copy_of(a, n, "a"), copy_of(j, n, "j"),
          all_positive(copy_of(h, n, "h"), "h")};
}

auto arrays_of(const SpeedProfile& profile) {
  const std::size_t n = profile.h.size();
  return nb::make_tuple(array_of(profile.s, n + 1), array_of(profile.v, n), array_of(profile.a, n),
                        array_of(profile.j, n), array_of(profile.h, n));
}

auto optimized(const Path& path, const Profile& profile, const std::tuple<Doubles, Doubles>& phases,
               const Doubles& limits) {
  const PolynomialPath along = path_of(path);
  const SpeedProfile given = profile_of(profile);
  if (given.s.size() != given.h.size() + 1) refuse("s has not one number more than h");
  const std::vector<double> parameters = rising(std::get<1>(phases), "parameters");
  if (parameters.size() < 5) refuse("there are fewer than four phases");
  const std::vector<double> durations =
      all_positive(copy_of(std::get<0>(phases), parameters.size() - 1, "durations"), "durations");
  const std::vector<double> bounds = all_positive(copy_of(table(limits, 3, along.joints, "limits").all()), "limits");
  SpeedProfile found;
  {
    nb::gil_scoped_release released;
    found = optimize_profile(along, given, durations, parameters, bounds);
  }
  return arrays_of(found);
}

auto chain(const Doubles& positions, const Doubles& peaks, const Doubles& speeds, const Doubles& jerk_shares,
           std::int64_t most_intervals) {
  SpeedGrid grid;
  grid.positions = rising(positions, "positions");
  if (grid.nodes() < 2) refuse("positions have fewer than two numbers");
  if (speeds.ndim() != 2) refuse("speeds do not have the shape (positions, levels)");
  const Table levels = table(speeds, grid.nodes(), speeds.shape(1), "speeds");
  if (peaks.ndim() != 3 || peaks.shape(0) != 6 || peaks.shape(1) != grid.nodes() - 1)
    refuse("peaks do not have the shape (6, positions - 1, blocks)");
  if (levels.columns < 1 || most_intervals < 1) refuse("speeds and most_intervals are at least 1");
  grid.blocks = peaks.shape(2), grid.levels = levels.columns;
  grid.peaks = copy_of(finite({peaks.data(), peaks.size()}, "peaks"));
  grid.speeds = copy_of(finite(levels.all(), "speeds"));
  grid.jerk_shares = copy_of(finite(row(jerk_shares, "jerk_shares"), "jerk_shares"));
  grid.most_intervals = static_cast<std::size_t>(most_intervals);
  SpeedChain found;
  {
    nb::gil_scoped_release released;
    found = fastest_chain(grid);
  }
  const std::size_t count = found.begin.size();
  return nb::make_tuple(array_of(found.begin, count), array_of(found.end, count), array_of(found.before, count),
                        array_of(found.after, count), array_of(found.bounds, count, 3));
}

}  // namespace

void bind_timing(nb::module_& m) {
  m.def("optimize_profile", &optimized, nb::arg("path"), nb::arg("profile"), nb::arg("phases"), nb::arg("limits"),
        "A faster profile (s, v, a, j, h) along a path (breaks, coefficients), or the given one; phases: durations and "
        "the parameters between them; limits: [3][joints].");
  m.def("fastest_chain", &chain, nb::arg("positions"), nb::arg("peaks"), nb::arg("speeds"), nb::arg("jerk_shares"),
        nb::arg("most_intervals"), "The fastest speed segments: nodes at both ends, speeds there, bounds in between.");
}

}  // namespace wayproof
