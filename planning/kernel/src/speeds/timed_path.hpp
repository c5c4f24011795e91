// TimedPath: a path of lines and parabolas timed under limits of velocity and acceleration, as planning/retime does it
// step by step: cells, TOPP-RA's speeds, profile, composition, audit.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "path/path_motion.hpp"
#include "speeds/utilization.hpp"

namespace wayproof {

// A smooth piece of a path, from rest to rest; `motion.pieces` are of the whole path.
struct TimedPath {
  PathMotion motion;
  std::array<Utilization, 2> uses;  // of the scaled motion: velocity, acceleration
  double raw_duration = 0;          // before it was scaled until it meets a limit [s]
};

// The smooth pieces in order; none if one of them has no profile.
std::optional<std::vector<TimedPath>> time_path(const PolynomialPath& path, std::span<const double> velocity,
                                                std::span<const double> acceleration);

}  // namespace wayproof
