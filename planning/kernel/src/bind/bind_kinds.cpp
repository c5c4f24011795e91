// The enums of model/kinds.hpp; in Python their names are in capitals.
#include <algorithm>
#include <cctype>
#include <string>
#include <utility>

#include "bind/bind.hpp"
#include "model/kinds.hpp"

namespace wayproof {
namespace {

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

}  // namespace

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

}  // namespace wayproof
