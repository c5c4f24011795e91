// BlendedPath: a path of straight lines with rounded corners, as planning/retime/blend.py makes it, number for number.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace wayproof {

// Over [0, 1]: bases[i] plus the polynomial of piece i, coefficients [pieces][terms][joints].
struct BlendedPath {
  std::size_t terms = 0;
  std::vector<double> breaks, bases, coefficients;
};

// Of waypoints, [n][joints], n at least 3, none in the middle of a straight line and none twice: rounded where it stays
// within `deviation` of the corner, positive. With a continuous r'' the corners are of degree 4, else of degree 2.
BlendedPath blend(std::span<const double> waypoints, std::size_t joints, double deviation, bool has_smooth_curvature);

}  // namespace wayproof
