// Linear programs of a path's speeds, for u = d2s/dt2 and x = (ds/dt)^2 in one cell: by Seidel's incremental method (de
// Berg et al., "Computational Geometry", 2008, section 4.4), one row after another, with toppra's tolerances and sums,
// so that the numbers are toppra's (Pham and Pham, T-RO 2018).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace wayproof {

// a u + b x + c <= 0.
struct SpeedRow {
  double a, b, c;
};

class SpeedProgram {
 public:
  // Rows that are likely to be active are tried first: those that were at the last minimum.
  struct Active {
    int first = 0, second = 0;
  };

  struct Point {
    double u, x;
  };

  // The largest x and, by 1e-9 of it, the smallest u, with 0 <= x <= cap. None if there is no point.
  std::optional<Point> largest_speed(std::span<const SpeedRow> rows, double cap, Active& active);

  // The largest u at one x; none if there is none.
  static std::optional<double> largest_acceleration(std::span<const SpeedRow> rows, double x);

 private:
  struct HalfLine {
    double a, b;
  };
  // An end of what half lines a t + b <= 0 leave of a line.
  struct LineEnd {
    double t;
    int active;
  };

  static std::optional<LineEnd> end_of(std::span<const HalfLine> rows, double direction, double low, double high);
  void order(std::size_t count, const Active& active);
  // The best point on the line of the k-th row in order, with the rows before it; none if there is none.
  std::optional<LineEnd> best_on_line(std::span<const SpeedRow> rows, std::size_t k, double cap, Point& point);

  std::vector<int> order_;
  std::vector<HalfLine> half_lines_;
};

}  // namespace wayproof
