// Relaxation of a path: waypoints move toward the chords of their neighbours. As planning/search/shortcut/relax.py has
// it, operation by operation, for joints that neither wrap nor float.
#pragma once

#include <functional>
#include <span>
#include <vector>

namespace wayproof {

// Numbers of the method; relax.py says what they are.
struct RelaxSettings {
  int max_sweeps;
  double min_gain, first_whole_fraction, max_whole_fraction, growth, shrinkage;
};

// Edges between rows of configurations.
struct Edges {
  std::vector<double> from, to;
};

// Whether each edge is free.
using EdgeVerdicts = std::function<std::vector<char>(const Edges&)>;

// Returns the relaxed path, rows of as many waypoints. `is_over` is called before each sweep.
std::vector<double> relax_path(std::span<const double> waypoints, int nq, const RelaxSettings& settings,
                               const EdgeVerdicts& are_free, const std::function<bool()>& is_over);

}  // namespace wayproof
