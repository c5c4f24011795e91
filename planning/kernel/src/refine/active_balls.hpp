// Active balls: of a convex step's vectors of loads, those that its minimum is likely to move out of the unit ball
// without a row that keeps them in it. See active_rows.hpp.
#pragma once

#include <cstddef>
#include <vector>

#include "qp/ball_rows.hpp"

namespace wayproof {

// The balls that a step is likely to reach the bound of, by how much lengths change at most within the box.
std::vector<char> likely_balls(const BallRows& balls);

// Adds those whose vectors are outside at x; returns whether there are any.
bool add_broken(const BallRows& balls, const std::vector<double>& x, std::vector<char>& takes_part);

// The balls that take part, those with the same columns one after another, otherwise in their order.
std::vector<std::size_t> in_blocks(const BallRows& balls, const std::vector<char>& takes_part);

}  // namespace wayproof
