// PathCells: a path of lines and parabolas cut into cells, with the limits on speed and acceleration along each.
//
// What planning/retime/toppra does in numpy for joints with a limit of their own each, number for number; that is
// where the method is described.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "timing/speed_profile.hpp"

namespace wayproof {

struct PathCells {
  PolynomialPath path;               // a piece for each cell
  std::vector<std::int64_t> pieces;  // of the path that was cut
  std::vector<bool> is_line;
  std::vector<double> speed, acceleration;  // largest ds/dt and d2s/dt2 on a line

  // In units of the duration at the velocity limits: a u + b x <= 1 on every cell, [cells][rows], for u = d2s/dt2 and
  // x = (ds/dt)^2 at its beginning; and the largest x at every edge.
  std::vector<double> a, b, caps;
  double time_unit = 0;
};

// Of a path with two or three terms, and positive limits of every joint.
PathCells cut_into_cells(const PolynomialPath& path, std::span<const double> velocity,
                         std::span<const double> acceleration);

// The sum as numpy has it: in eight sums, of halves where there are many.
double numpy_sum(std::span<const double> numbers);

}  // namespace wayproof
