// DurationBound: a lower bound of a path's duration, as planning/pipeline/timing/path_duration_bound.py has it.
#pragma once

#include <cstddef>
#include <span>

#include "timing/speed_profile.hpp"

namespace wayproof {

// Of a path with `bases`, [pieces][joints], at rest at its corners, under limits of velocity, acceleration and jerk of
// every joint, [3][joints], positive; of jerk infinite where it is not limited. Rounding is not allowed for.
double duration_bound(const PolynomialPath& path, std::span<const double> bases, std::size_t smoothness,
                      std::span<const double> limits);

// The least time from rest without acceleration to a distance, at any speed there.
double duration_from_rest(double distance, double velocity, double acceleration, double jerk);

}  // namespace wayproof
