// Active rows: of a convex step's rows of loads, those that its minimum is likely to break without them.
//
// A row that the minimum without it does not break would change nothing there: most rows are left out of the program,
// and added if they are broken after all.
#pragma once

#include <cstddef>
#include <vector>

#include "refine/convex_step.hpp"

namespace wayproof {

// The rows that a step is likely to reach, by how much they change at most within the box.
std::vector<char> likely_rows(const MoreRows& rows);

// Adds the rows that are broken at x; returns whether there are any.
bool add_broken(const MoreRows& rows, const std::vector<double>& x, std::vector<char>& takes_part);

// The rows that take part, those with the same columns one after another, otherwise in their order.
std::vector<std::size_t> in_blocks(const MoreRows& rows, const std::vector<char>& takes_part);

}  // namespace wayproof
