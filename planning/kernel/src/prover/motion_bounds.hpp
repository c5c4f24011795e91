// MotionBounds: bounds on the approach of two shapes while the group deviates from a configuration.
//
// First order, for any direction of motion (Schwarzer, Saha, Latombe, "Adaptive dynamic collision checking
// for single and multiple articulated robots", IEEE T-RO 21:3, 2005, with lever arms at the present
// configuration): let joint k turn by at most s_k and y be a point of a shape, in the joint's child frame
// within m_{k+1} of where it was. Then R(t) y(t) - R y = R(t) (y(t) - y) + (R(t) - R) y, so in the parent
// frame it is within m_k = m_{k+1} + 2 sin(s_k / 2) rho_k, rho_k being the largest distance of the shape's
// points from the axis. A joint that slides adds its deviation. Summing from the tip to the common ancestor
// bounds the approach. In the frame of a half space that turns, the other shape alone moves, by the same joints
// run backwards, so that its lever arms count and not those of the half space, which have no end. Of a shape that
// is a core with a ball about every point of it, the core's points are
// meant, here and below: to turn a ball moves nothing.
//
// Second order, along one direction n (unit, from B to A, fixed in the common ancestor): a point x of A has
// n . x(theta + d) = n . x + sum_k d_k n . J_k(x) + r with J_k = w_k x (x - o_k) or the sliding axis, and
// |r| <= 1/2 sum_jk |d_j| |d_k| |H_jk|, where H_jk, the derivative of J_k by an earlier joint j (or by
// itself), is J_k turned: of norm |J_k| if j turns, else zero. On the way J_k is at most rho_k + m_{k+1}
// long. The linear part is smallest at one of the rows of which d is a convex combination, and there it is a
// support function of A's core along n + sum_k d_k (n x w_k); what the residuals of d add is bounded by the
// bounding sphere.
#pragma once

#include <utility>
#include <vector>

#include "model/scene.hpp"
#include "prover/motion.hpp"

namespace wayproof {

// One degree of freedom on the chain from the world to a link, or a ball.
struct Axis {
  int link;
  bool turns;
  bool ball;      // rotates about any axis through its origin
  int direction;  // -1: the link's own axis, else a column of its frame
  int column;     // of the group's v
  double scale;   // displacement over that of the column
  int block;      // whose deviation bounds it; -1 if the axis before it counts that already
};

class MotionBounds {
 public:
  // The parts of the chains of both shapes of a pair with relative motion: from these axes on.
  struct Relative {
    int a = 0, b = 0;
    bool moves = false;
  };

  MotionBounds(const Scene& scene, const Group& group, const Motion& motion);

  Relative relative(const Pair& pair) const;

  // Sets the group's q; bounds need the deviations too.
  void place(const double* q);
  void enter(const JointDeviation& deviation);

  const Transform& pose(int geometry);
  Vec3 center(int geometry);
  // Bound on the approach of the shapes of a pair: the sum of the shares of the joints that carry a and b.
  double approach(const Pair& pair, const Relative& relative);
  std::pair<double, double> shares(const Pair& pair, const Relative& relative);
  // Whether a geometry's chain has an axis from `from` on that moves with the group's columns from `first` to `last`.
  bool depends(int geometry, int from, int first, int last) const;
  // A lower bound, not below `enough` if it is finite, on the distance of a pair throughout: -inf if so large a bound
  // cannot be proven along n, from B to A. `width` is the slab across n at the centre.
  double along(const Pair& pair, const Relative& relative, Vec3 n, double width, double enough);

 private:
  struct Placed {
    int pose_stamp = 0, reach_stamp = 0;
    Transform X_WG;
    Vec3 center;
  };
  struct Linear {
    Vec3 turn;    // n x w_k
    double rate;  // of the direction's coordinate with the axis, at the world's origin
  };

  const std::vector<int>& chain(int geometry) const;
  // Bound on the motion of any point of a shape against the frame before the axis `from` of its chain.
  double reach(int geometry, int from);
  // The same against a carrier, of the axes from `from` on of the carrier's chain.
  double swing(int carrier, int from, int geometry);
  double remainder(int geometry, int from);
  double lowest(int geometry, Vec3 n);
  double residual(int geometry, int from, const std::vector<Linear>& linear) const;
  double lowest_at(int geometry, int from, const std::vector<Linear>& linear, Vec3 n, const double* d, double sign);
  void linearise(const std::vector<int>& chain, int from, Vec3 n, std::vector<Linear>& out) const;

  const Scene& scene_;
  const Group& group_;
  const Motion& motion_;
  std::vector<Axis> axes_;
  std::vector<std::vector<int>> chains_;  // axes of each link, from the root on
  std::vector<int> none_;
  std::vector<double> full_;
  std::vector<Transform> X_WL_;
  int width_ = 1;  // axes of the longest chain, and one
  int stamp_ = 0;
  const JointDeviation* deviation_ = nullptr;
  std::vector<Vec3> directions_, origins_;  // of axes, in W
  std::vector<double> sigmas_, chords_;
  std::vector<Placed> placed_;
  std::vector<double> reaches_;  // [geometry][width_]: sums from an axis to the tip
  std::vector<double> arms_;     // [geometry][width_]: bound on |J_k| on the way
  std::vector<Linear> linear_a_, linear_b_;
};

}  // namespace wayproof
