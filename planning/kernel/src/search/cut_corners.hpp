// Waypoints moved: back toward a free path, and corners that become two. As planning/search/shortcut/backtracking.py
// and corners.py have it, operation by operation.
#pragma once

#include <span>
#include <vector>

#include "search/edges.hpp"

namespace wayproof {

// Numbers of the method; backtracking.py says what they are.
struct BacktrackSettings {
  double first_fraction, growth, max_fraction;
};

// Returns a path of free edges near to the desired one: waypoints at blocked edges move back toward the free path,
// which has as many and the same ends.
std::vector<double> backtrack(std::span<const double> desired, std::span<const double> free, EdgeVerdicts& edges,
                              const BacktrackSettings& settings);

// Returns a shorter path of free edges from one of free edges; none where no cut of a corner, by one of the `fractions`
// of its edges, gains at least `min_gain` of the length.
std::vector<double> cut_corners(std::span<const double> waypoints, EdgeVerdicts& edges,
                                std::span<const double> fractions, double min_gain);

}  // namespace wayproof
