// Relaxation of a path: waypoints move toward the chords of their neighbours. As planning/search/shortcut/relax.py has
// it, operation by operation, for joints that neither wrap nor float.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "search/edges.hpp"

namespace wayproof {

// Numbers of the method; relax.py says what they are.
struct RelaxSettings {
  int max_sweeps;
  double min_gain, first_whole_fraction, max_whole_fraction, growth, shrinkage;
};

// Returns the relaxed path, rows of as many waypoints. `is_over` is called before each sweep.
std::vector<double> relax_path(std::span<const double> waypoints, const RelaxSettings& settings, EdgeVerdicts& edges,
                               const std::function<bool()>& is_over);

}  // namespace wayproof
