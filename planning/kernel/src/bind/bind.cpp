// The Python module planning.kernel._native, and its enums.
#include "bind/bind.hpp"

#include <nanobind/nanobind.h>

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <string>
#include <utility>

#include "model/kinds.hpp"

namespace wayproof {
namespace {

// In Python the names of the enums of model/kinds.hpp are in capitals.
template <typename Kind>
void bind_kind(nb::module_& m, const char* name, const char* doc,
               std::initializer_list<std::pair<const char*, Kind>> members) {
  nb::enum_<Kind> bound(m, name, doc);
  for (const auto& [lower, value] : members) {
    std::string upper = lower;
    std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
    bound.value(upper.c_str(), value);
  }
}

void bind_kinds(nb::module_& m) {
#define WAYPROOF_NAMED(name) {#name, Kind::name},
  {
    using Kind = ShapeKind;
    bind_kind<Kind>(m, "ShapeKind", "Kinds of convex shapes.", {WAYPROOF_SHAPE_KINDS(WAYPROOF_NAMED)});
  }
  {
    using Kind = JointKind;
    bind_kind<Kind>(m, "JointKind", "Kinds of joints.", {WAYPROOF_JOINT_KINDS(WAYPROOF_NAMED)});
  }
  {
    using Kind = Verdict;
    bind_kind<Kind>(m, "Verdict", "Collision verdicts; arrays have their values.", {WAYPROOF_VERDICTS(WAYPROOF_NAMED)});
  }
  {
    using Kind = Outcome;
    bind_kind<Kind>(m, "Outcome", "Outcomes of a clearance proof.", {WAYPROOF_OUTCOMES(WAYPROOF_NAMED)});
  }
  {
    using Kind = Freedom;
    bind_kind<Kind>(m, "Freedom", "Kinds of rotation tolerances.", {WAYPROOF_FREEDOMS(WAYPROOF_NAMED)});
  }
#undef WAYPROOF_NAMED
}

}  // namespace
}  // namespace wayproof

NB_MODULE(_native, m) {
  nanobind::set_leak_warnings(false);  // leak warnings about its globals at the end of a process are of no use
  m.doc() = "Native collision bounds and kinematics; see planning/kernel.";
  wayproof::bind_kinds(m);
  wayproof::bind_scene(m);
  wayproof::bind_checker(m);
  wayproof::bind_ik(m);
  wayproof::bind_prover(m);
  wayproof::bind_refine(m);
  wayproof::bind_curve(m);
  wayproof::bind_timing(m);
  wayproof::bind_retime(m);
  wayproof::bind_search(m);
  wayproof::bind_shortcut(m);
  wayproof::bind_dynamics(m);
  wayproof::bind_torques(m);
  wayproof::bind_loads(m);
}
