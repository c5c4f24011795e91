// SpeedCells: bounds on a path's derivatives on cells, relative to limits, for planning/retime/jerk/speed_dp.py.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "timing/speed_profile.hpp"

namespace wayproof {

struct SpeedCells {
  std::vector<double> edges;
  std::vector<std::int64_t> pieces;  // of the path, by cell
  std::vector<double> peaks;         // [6][cells][joints], in the order of `SpeedCells` in speed_dp.py
};

// About `count` cells of equal length, at least `least` on every piece; limits of velocity, acceleration and jerk of
// every joint, [3][joints].
SpeedCells speed_cells(const PolynomialPath& path, std::span<const double> limits, std::size_t count,
                       std::size_t least);

}  // namespace wayproof
