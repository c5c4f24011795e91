// Motion: q(t) = base_i [+] delta_i(t), and its segments with bounds on the joints' deviation within each.
//
// A polynomial stays in the convex hull of its Bernstein coefficients, all coordinates at once (Farouki, "The Bernstein
// polynomial basis: a centennial retrospective", 2012, section 3). Points near a line need only its ends: the
// coefficients of a piece become a chord and a residual per coordinate, and the chords of a segment a polyline of few
// rows. So on a segment the displacement of the group's coordinates from its centre is always a convex combination of
// the rows, plus a residual. Where a piece does not end at the beginning of the next one, the residual of all its
// segments includes the gap between them.
#pragma once

#include <utility>
#include <vector>

#include "model/tree.hpp"

namespace wayproof {

// Velocity coordinates of one joint that rotate or translate it together. A ball rotates about any axis: its three are
// a rotation vector, whose displacements have only a bound on their norm, the block's deviation.
struct Block {
  int column, size;
  bool ball;
};

// Segment of a motion: whole pieces, or a part of one piece.
struct Segment {
  double begin = 0, end = 0, time = 0;  // the centre is taken at `time`
  int first = 0, last = 0;              // pieces; `last` is the one after the last
  std::vector<double> control;          // Bernstein coefficients of the tangent if there is one piece

  bool is_part() const { return last - first == 1; }
};

// Joint deviation: a segment's centre, and bounds on the displacement of the coordinates from it.
struct JointDeviation {
  std::vector<double> q;         // the group's q at the centre
  std::vector<double> rows;      // [num_rows][nv] displacements; zero in a ball's columns
  std::vector<double> residual;  // of each coordinate
  std::vector<double> block;     // largest norm of each block's displacement, balls included
  int num_rows = 0;
};

class Motion {
 public:
  // breaks [n + 1], bases [n][nq], coefficients [n][terms][nv]: power basis, lowest first.
  Motion(const Tree& tree, const Group& group, std::vector<double> breaks, std::vector<double> bases,
         std::vector<double> coefficients, int terms);

  int num_pieces() const { return static_cast<int>(breaks_.size()) - 1; }
  int num_positions() const { return nq_; }
  int num_velocities() const { return nv_; }
  double duration() const { return breaks_.back(); }
  const std::vector<Block>& blocks() const { return blocks_; }
  int block_of(int column) const { return block_of_[column]; }
  // (index in the group's q, in its v) of the coordinates that simply add: all but quaternions.
  const std::vector<std::pair<int, int>>& plain() const { return plain_; }

  Segment whole() const { return range(0, num_pieces()); }
  Segment half(const Segment& segment, int which) const;
  void enter(const Segment& segment, JointDeviation& deviation) const;
  void positions(double time, double* q) const;

 private:
  struct Ball {
    int position, column;
  };

  void add_coordinates(JointKind kind, int q, int v);
  void bound_loose();
  void bound_chords();
  Segment range(int first, int last) const;
  void plus(const double* base, const double* delta, double* q) const;
  void enter_part(const Segment& segment, JointDeviation& deviation) const;
  void enter_range(const Segment& segment, JointDeviation& deviation) const;
  void bound_blocks(const double* point, const double* residual, JointDeviation& deviation) const;
  double angle(const Ball& ball, const double* q1, const double* q0) const;

  int nq_, nv_, terms_;
  std::vector<double> breaks_, bases_, coefficients_, bernstein_;
  std::vector<double> middles_, centers_;  // of each piece: delta and q at its middle
  std::vector<double> points_;             // beginning of each piece, in v's coordinates; and the end of the last
  std::vector<double> residuals_;          // of each piece's chord, from its first point to the next piece's
  std::vector<double> loose_;              // error of each piece: by rounding, and the gap to the beginning of the next
  std::vector<double> ball_deviations_;    // of each piece and ball
  std::vector<std::pair<int, int>> plain_;
  std::vector<Ball> balls_;
  std::vector<Block> blocks_;
  std::vector<int> block_of_;
};

}  // namespace wayproof
