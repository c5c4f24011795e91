// optimize_profile: faster jerk-limited profiles, as planning/retime/jerk/profile_optimizer.py has them.
#pragma once

#include <vector>

#include "timing/speed_profile.hpp"

namespace wayproof {

// Returns the profile that begins with the phases of the given durations between the parameters, or the given one;
// within the limits.
SpeedProfile optimize_profile(const PolynomialPath& path, const SpeedProfile& profile, const std::vector<double>& h,
                              const std::vector<double>& parameters, const RateLimits& limits);

}  // namespace wayproof
