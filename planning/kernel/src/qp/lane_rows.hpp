// LaneRows: rows of a penalty QP that are alike for several coordinates, as those of rates along a spline are: each has
// a value for its coordinate of four control points, and one for each of two variables that all coordinates share.
//
// Coordinates are lanes: a line has the rows of up to eight of them, not all of which need to exist.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/lanes.hpp"
#include "qp/skyline.hpp"

namespace wayproof {

struct LaneRows {
  // Of four points, then of the two variables.
  static constexpr std::size_t num_points = 4, num_values = 6, low = 4, high = 5;

  // Lines with the same columns: `begin` to `end` of all lines.
  struct Group {
    std::array<std::int64_t, num_points> points;  // columns of the first coordinate; -1 for none
    std::int64_t low, high;                       // columns of the two variables; -1 for none
    std::size_t lanes;                            // number of coordinates
    std::size_t begin, end;
  };
  // A line: which of its lanes have a row, as bits, and the values of all lanes, 0 of those without.
  struct Line {
    unsigned taken = 0;
    std::array<double, num_values * num_lanes> values{};
  };

  std::vector<Group> groups;
  std::vector<Line> lines;
  std::size_t rows = 0;  // of all lines, in order of lanes
};

class LaneBlocks {
 public:
  // The rows must outlive this.
  explicit LaneBlocks(const LaneRows& rows);

  // Lowers the first column of every row of A' A.
  void widen(std::vector<int>& first) const;
  // y = A x, and x += scale A' y, y of these rows alone.
  void times(const std::vector<double>& x, double* y);
  void add_transposed(const double* y, double scale, std::vector<double>& x);
  // matrix += A' diag(weight) A.
  void add_squares(const double* weight, Skyline& matrix);

 private:
  const LaneRows& r_;
  std::vector<double> variables_, numbers_;  // what is computed in, with room for more lanes and a number more
};

}  // namespace wayproof
