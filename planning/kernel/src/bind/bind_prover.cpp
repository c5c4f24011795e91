// Prover, on numpy arrays; it holds the interpreter's lock only to poll for an interrupt.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <memory>
#include <tuple>
#include <utility>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "math/bernstein.hpp"
#include "prover/beside_prover.hpp"
#include "prover/joint_bounds.hpp"
#include "prover/prover.hpp"

namespace wayproof {
namespace {

std::vector<double> copy_of(std::span<const double> numbers) { return {numbers.begin(), numbers.end()}; }

Motion motion(const Tree& tree, const Group& group, const Doubles& breaks, const Doubles& bases,
              const Doubles& coefficients) {
  const std::size_t nq = group.positions.size(), nv = group.velocities.size();
  if (!(coefficients.ndim() == 3 && coefficients.shape(0) >= 1 && coefficients.shape(1) >= 1 &&
        coefficients.shape(2) == nv))
    refuse("coefficients are not of shape (pieces, terms, " + std::to_string(nv) + "), one or more of both");
  const std::size_t pieces = coefficients.shape(0), terms = coefficients.shape(1);
  const auto times = finite(row(breaks, pieces + 1, "breaks"), "breaks");
  require(std::is_sorted(times.begin(), times.end()), "breaks are not in increasing order");
  const auto begins = finite(table(bases, pieces, nq, "bases").all(), "bases");
  const auto powers = finite({coefficients.data(), coefficients.size()}, "coefficients");
  return Motion(tree, group, copy_of(times), copy_of(begins), copy_of(powers), static_cast<int>(terms));
}

void make(Prover* self, const std::shared_ptr<Scene>& scene, const Integers& positions, const Integers& velocities,
          const Doubles& state, const std::tuple<Doubles, Doubles, Doubles>& curve, const Doubles& margins,
          double slack) {
  const auto required = ordered(row(margins, scene->pairs.size(), "margins"), "margins");
  finite(slack, "slack");
  Group moving = group(*scene, positions, velocities, state);
  const auto& [breaks, bases, coefficients] = curve;
  Motion moves = motion(scene->tree, moving, breaks, bases, coefficients);
  new (self) Prover(immutable(scene), std::move(moving), std::move(moves), copy_of(required), slack);
}

// A group's positions and velocities, and the breaks, bases and coefficients of its motion.
using GroupMotion = std::tuple<Integers, Integers, Doubles, Doubles, Doubles>;

void make_beside(BesideProver* self, const std::shared_ptr<Scene>& scene, const GroupMotion& first,
                 const GroupMotion& second, const Doubles& state, const Doubles& margins, double slack) {
  const auto required = ordered(row(margins, scene->pairs.size(), "margins"), "margins");
  finite(slack, "slack");
  const auto group_of = [&](const GroupMotion& of) { return group(*scene, std::get<0>(of), std::get<1>(of), state); };
  const auto motion_of = [&](const Group& moving, const GroupMotion& of) {
    return motion(scene->tree, moving, std::get<2>(of), std::get<3>(of), std::get<4>(of));
  };
  Group all = group_of(first);
  const Group other = group_of(second);
  std::array<Motion, 2> motions{motion_of(all, first), motion_of(other, second)};
  for (const int position : other.positions)
    require(std::ranges::find(all.positions, position) == all.positions.end(), "both motions move one joint");
  all.positions.insert(all.positions.end(), other.positions.begin(), other.positions.end());
  all.velocities.insert(all.velocities.end(), other.velocities.begin(), other.velocities.end());
  Group both(scene->tree, all.positions, all.velocities, all.state);
  new (self) BesideProver(immutable(scene), std::move(both), std::move(motions), copy_of(required), slack);
}

template <typename AnyProver>
auto prove(AnyProver& prover, const nb::callable& interrupt) {
  nb::gil_scoped_release released;
  return prover.prove([&interrupt] {
    nb::gil_scoped_acquire held;
    interrupt();
  });
}

Proof prove_in_order(Prover& prover, const nb::callable& interrupt, double resolution) {
  positive(resolution, "resolution");
  const nb::gil_scoped_release released;
  return prover.prove_in_order(
      [&interrupt] {
        const nb::gil_scoped_acquire held;
        interrupt();
      },
      resolution);
}

// The segment reached by halvings (0 first, 1 second half) of the whole motion: begin, end, centre, and a row
// (approach, lower bound, lower bound along one direction) per pair.
auto bounds(Prover& prover, const std::vector<int>& halvings) {
  Segment segment = prover.motion().whole();
  for (const int which : halvings) segment = prover.motion().half(segment, index(which, 2, "halvings"));
  std::vector<double> rows;
  for (const PairBound& b : prover.bounds(segment)) rows.insert(rows.end(), {b.approach, b.lower, b.along});
  return nb::make_tuple(segment.begin, segment.end, segment.time, array_of(rows, rows.size() / 3, 3));
}

std::tuple<double, std::size_t, double> peak_of(const Doubles& coefficients, double tolerance) {
  require(coefficients.ndim() == 2 && coefficients.shape(0) >= 1 && coefficients.shape(1) >= 1,
          "coefficients are not of shape (n, terms), one or more of both");
  const Peak found = peak({coefficients.data(), coefficients.size()}, coefficients.shape(1), tolerance);
  return {found.bound, found.row, found.fraction};
}

nb::tuple tuple_of(const JointPeak& peak) { return nb::make_tuple(peak.bound, peak.joint, peak.piece, peak.fraction); }

// Forms by order, [joints][pieces][terms]; their largest magnitudes; the peak of positions over their bounds and of
// rates over their limits (value, joint, piece, fraction); largest sums of jumps and the last jump of each.
auto bounds_of_joints(const std::tuple<Doubles, Doubles, Doubles>& curve, const Doubles& lower, const Doubles& upper,
                      const Doubles& rates, double position_tolerance, double rate_gap) {
  const auto& [breaks, bases, coefficients] = curve;
  require(coefficients.ndim() == 3 && coefficients.size() > 0, "coefficients are not of shape (pieces, terms, joints)");
  const std::size_t pieces = coefficients.shape(0), terms = coefficients.shape(1), joints = coefficients.shape(2);
  const auto times = finite(row(breaks, pieces + 1, "breaks"), "breaks");
  for (std::size_t i = 0; i < pieces; ++i) require(times[i] < times[i + 1], "breaks do not rise");
  require(rates.ndim() == 2 && rates.shape(0) >= 2 && rates.shape(0) <= 3, "rates has neither two nor three rows");
  const JointMotion motion{times, finite(table(bases, pieces, joints, "bases").all(), "bases"),
                           finite({coefficients.data(), coefficients.size()}, "coefficients"), terms, joints};
  const JointLimitRows limits{ordered(row(lower, joints, "lower"), "lower"),
                              ordered(row(upper, joints, "upper"), "upper"),
                              ordered(table(rates, rates.shape(0), joints, "rates").all(), "rates"),
                              positive(position_tolerance, "position_tolerance"), positive(rate_gap, "rate_gap")};
  const JointBounds found = joint_bounds(motion, limits);
  nb::list forms, peaks, jumps;
  for (std::size_t k = 0; k < found.forms.size(); ++k)
    forms.append(array_of(found.forms[k], joints, pieces, std::max<std::size_t>(terms - std::min(k, terms - 1), 1)));
  for (const JointPeak& peak : found.rates) peaks.append(tuple_of(peak));
  for (const JumpSums& sums : found.jumps)
    jumps.append(nb::make_tuple(array_of(sums.largest, joints), array_of(sums.last, joints)));
  return nb::make_tuple(forms, array_of(found.magnitudes, found.forms.size(), joints), tuple_of(found.position), peaks,
                        jumps);
}

}  // namespace

void bind_prover(nb::module_& m) {
  nb::class_<ClosestApproach>(m, "ClosestApproach", "The pair (by number, or -1) that had the least of something.")
      .def_ro("pair", &ClosestApproach::pair)
      .def_ro("distance", &ClosestApproach::distance)
      .def_ro("time", &ClosestApproach::time);
  nb::class_<Proof>(m, "Proof", "Outcome of a clearance proof, and its evidence.")
      .def_ro("outcome", &Proof::outcome)
      .def_ro("pair", &Proof::pair)
      .def_ro("distance", &Proof::distance)
      .def_ro("uncertainty", &Proof::uncertainty)
      .def_ro("time", &Proof::time)
      .def_ro("until", &Proof::until)
      .def_ro("nearest", &Proof::nearest)
      .def_ro("tightest", &Proof::tightest)
      .def_ro("floor", &Proof::floor)
      .def_ro("segments", &Proof::segments)
      .def_ro("looks", &Proof::looks);
  nb::class_<Prover>(m, "Prover", "Whether every pair keeps its distance throughout a motion.")
      .def("__init__", &make, nb::arg("scene"), nb::arg("positions"), nb::arg("velocities"), nb::arg("state"),
           nb::arg("curve"), nb::arg("margins"), nb::arg("slack"))
      .def("prove", &prove<Prover>, nb::arg("interrupt"))
      .def("prove_in_order", &prove_in_order, nb::arg("interrupt"), nb::arg("resolution"))
      .def("bounds", &bounds, nb::arg("halvings"));
  nb::class_<Encounter>(m, "Encounter", "A pair (by number, or -1) at an instant of either motion.")
      .def_ro("pair", &Encounter::pair)
      .def_ro("distance", &Encounter::distance)
      .def_prop_ro("times", [](const Encounter& e) { return std::make_tuple(e.times[0], e.times[1]); });
  nb::class_<BesideProof>(m, "BesideProof", "Outcome of a proof whatever the timing, and its evidence.")
      .def_ro("outcome", &BesideProof::outcome)
      .def_ro("worst", &BesideProof::worst)
      .def_ro("pairs", &BesideProof::pairs)
      .def_ro("segments", &BesideProof::segments);
  nb::class_<BesideProver>(m, "BesideProver", "Whether pairs keep their distance at any two instants of two motions.")
      .def("__init__", &make_beside, nb::arg("scene"), nb::arg("first"), nb::arg("second"), nb::arg("state"),
           nb::arg("margins"), nb::arg("slack"))
      .def("prove", &prove<BesideProver>, nb::arg("interrupt"));
  m.def("joint_bounds", &bounds_of_joints, nb::arg("curve"), nb::arg("lower"), nb::arg("upper"), nb::arg("rates"),
        nb::arg("position_tolerance"), nb::arg("rate_gap"),
        "Of the joints of a motion (breaks, bases, coefficients): Bernstein forms by order, magnitudes, peaks of "
        "positions and of rates, sums of jumps.");
  m.def("peak", &peak_of, nb::arg("coefficients"), nb::arg("tolerance"),
        "An upper bound on polynomials in Bernstein form, the row where it is, and the fraction of its "
        "interval.");
}

}  // namespace wayproof
