// Waypoints of a path left out by the furthest free edges. As planning/search/shortcut/vertex_skipping.py has it,
// operation by operation.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "search/edges.hpp"

namespace wayproof {

// Returns some of the waypoints, joined by free edges, both ends among them; none if no free edges lead from end to
// end. Once `is_over`, only the given path's own edges are tried.
std::vector<double> skip_vertices(std::span<const double> waypoints, EdgeVerdicts& edges,
                                  const std::function<bool()>& is_over);

// Returns a path of free edges from one of free edges, from its end to its beginning; it leaves that one at waypoints
// or at points that cut its edges into at most `max_parts` pieces.
std::vector<double> tighten(std::span<const double> waypoints, EdgeVerdicts& edges, int max_parts);

}  // namespace wayproof
