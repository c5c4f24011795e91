// phase_peaks: bounds on the rates of a motion along a path, phase by phase, as block_peaks of planning/retime has
// them.
#pragma once

#include <vector>

#include "timing/speed_profile.hpp"

namespace wayproof {

// Largest rate over limit of every phase, [3][phases]: upper bounds by Bernstein coefficients on quarters of the phase.
// Every phase lies on one piece of the path.
std::vector<double> phase_peaks(const PolynomialPath& path, const SpeedProfile& profile, const RateLimits& limits);

}  // namespace wayproof
