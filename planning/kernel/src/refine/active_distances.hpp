// Active distances: which rows of distances take part in the program of a convex step.
//
// A row that the minimum without it does not break costs nothing there and changes nothing: the program without all
// such rows has the same minimum, and most rows are such. So a step begins with those that are likely to bind, and is
// solved again with those that its minimum breaks, until there are none.
#pragma once

#include <vector>

#include "refine/convex_step.hpp"

namespace wayproof {

// Whether each margin takes part at first.
std::vector<char> likely_rows(const StepBox& box, const DistanceMargins& margins);

// Lets margins take part that are broken at the minimum x without them; returns whether there are any.
bool add_broken(const CurveColumns& columns, const StepBox& box, const DistanceMargins& margins,
                const std::vector<double>& x, std::vector<char>& takes_part);

}  // namespace wayproof
