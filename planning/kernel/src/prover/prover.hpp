// Prover: proof that every pair of shapes keeps its distance throughout a motion, by conservative bisection.
//
// A pair's distance at a segment's centre, less a bound on the approach of the shapes within the segment, bounds it
// from below there. Where the bound is above the required distance the pair is proven; the remaining pairs are checked
// again on both halves, the segment of least bound first. Afterwards segments that may contain a smaller distance than
// the smallest one measured are halved until that is accurate. Distances are bounded from below by slabs and from above
// by points of both shapes, so every result is supported by both bounds.
#pragma once

#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "model/kinds.hpp"
#include "model/scene.hpp"
#include "prover/motion.hpp"
#include "prover/motion_bounds.hpp"

namespace wayproof {

// More segments end a proof as unproven.
inline constexpr int most_segments = 20000;

// The pair with the least value of some quantity.
struct ClosestApproach {
  double least = std::numeric_limits<double>::infinity();
  int pair = -1;
  double distance = std::numeric_limits<double>::infinity();
  double time = 0;
};

struct Proof {
  Outcome outcome = Outcome::proven;
  // The pair at which the proof stopped: too near, not proven far enough, or static.
  int pair = -1;
  double distance = 0, uncertainty = 0, time = 0;
  double until = 0;                   // the motion is proven from its beginning until then; of prove_in_order() alone
  ClosestApproach nearest, tightest;  // smallest distance measured, and smallest over the pair's margin
  double floor = std::numeric_limits<double>::infinity();  // no distance is smaller, if proven
  int segments = 0, looks = 0;
};

// Bounds of one pair on one segment: on its approach, and two on its distance.
struct PairBound {
  double approach, lower, along;
};

class Prover {
 public:
  // margins: required distance of each pair; `slack` less suffices.
  Prover(std::shared_ptr<const Scene> scene, Group group, Motion motion, std::vector<double> margins, double slack);
  Prover(const Prover&) = delete;

  // `interrupt` is called now and then and may throw. A prover is used by one call at a time.
  Proof prove(const std::function<void()>& interrupt);

  // The same verdict, by the segments in order of time, so that a refused motion is known to be proven until the first
  // instant that is not, to a resolution [s]. No distance is refined.
  Proof prove_in_order(const std::function<void()>& interrupt, double resolution);

  // Bounds of every pair on one segment; prove() uses the same.
  std::vector<PairBound> bounds(const Segment& segment);
  const Motion& motion() const { return motion_; }

 private:
  // An undecided pair on a segment: its last slab, and the bounds of its distance there.
  struct Open {
    int pair;
    bool aimed;
    Vec3 n;
    double bound;
  };
  struct Node {
    double floor;
    int number;
    Segment segment;
    std::vector<Open> open;
  };
  struct PairCheck {
    bool decided;
    bool unbounded;   // no segment is short enough
    double bound;     // on the segment, if decided or measured
    double distance;  // at the centre, if measured
  };

  bool later(const Node& a, const Node& b) const;
  void push(std::vector<Node>& heap, Node node) const;
  Node pop(std::vector<Node>& heap) const;
  bool is_short(const Segment& segment) const;
  void enter(const Segment& segment);
  PairCheck check_pair(Open& open, double required, double few, bool last_resort, double time);
  void count_work();
  void see(int pair, double distance, double time);
  void look(double time);
  bool find_static_violation();
  bool prove_node(Node node, std::vector<Node>& heap);
  bool prove_next(Node node, double resolution, std::vector<Node>& stack);
  void refuse(Outcome outcome, int pair, double distance, double uncertainty, double time);
  void refine_minimum();
  double target() const;
  void split(const Node& node, double floor, const std::vector<Open>& rest, std::vector<Node>& heap);

  std::shared_ptr<const Scene> scene_;
  Group group_;
  Motion motion_;
  std::vector<double> margins_;
  double slack_;
  MotionBounds bounds_;
  std::vector<MotionBounds::Relative> relatives_;
  std::vector<double> required_;
  std::vector<int> moved_;
  std::vector<Vec3> hints_;  // last slab of every pair
  JointDeviation deviation_;
  std::vector<Node> leaves_;  // segments that are proven, but whose distances are not yet accurate
  Proof proof_;
  int number_ = 0;
  int work_ = 0;
  const std::function<void()>* interrupt_ = nullptr;
  std::atomic<bool> is_busy_ = false;
};

}  // namespace wayproof
