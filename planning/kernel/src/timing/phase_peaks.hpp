// phase_peaks: bounds on the rates of a motion along a path, as block_peaks of planning/retime has them.
#pragma once

#include <array>

#include "timing/path_rates.hpp"

namespace wayproof {

// Largest rate over limit of all phases by order: upper bounds by Bernstein coefficients on quarters of phases. Every
// phase lies on one piece of the path.
std::array<double, 3> phase_peaks(const PathRates& path, const SpeedProfile& profile);

}  // namespace wayproof
