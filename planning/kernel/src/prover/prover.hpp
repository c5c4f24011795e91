// Prover: that every pair of shapes keeps its distance throughout a motion, by conservative bisection.
//
// A pair's distance at a segment's centre, less how much nearer the shapes can come within the segment,
// bounds it from below there. Where the bound is above what is required the pair is proven; pairs that are
// left are looked at again on both halves, the most suspicious segment first. Afterwards segments that may
// hide a smaller distance than was seen are halved until the smallest one is known well. Distances are
// bounded from below by slabs and from above by points of both shapes, so nothing here is believed that was
// not computed both ways.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "prover/motion.hpp"
#include "prover/motion_bounds.hpp"
#include "model/scene.hpp"

namespace wayproof {

enum class Outcome { proven = 0, too_near = 1, unproven = 2, fixed = 3 };

// The pair that had the least of something.
struct Sighting {
  double least = std::numeric_limits<double>::infinity();
  int pair = -1;
  double distance = std::numeric_limits<double>::infinity();
  double time = 0;
};

struct Proof {
  Outcome outcome = Outcome::proven;
  // Of the pair at which the proof stopped: too near, not shown to be far enough, or moved by nothing.
  int pair = -1;
  double distance = 0, uncertainty = 0, time = 0;
  Sighting nearest, tightest;  // smallest distance seen, and smallest over the pair's margin
  double floor = std::numeric_limits<double>::infinity();  // no distance is smaller, if proven
  int segments = 0, looks = 0;
};

// What is proven of one pair on one segment: how much nearer it can come, and two bounds on its distance.
struct PairBound {
  double approach, lower, along;
};

class Prover {
 public:
  // margins: what is demanded of each pair; `slack` less is enough.
  Prover(std::shared_ptr<const Scene> scene, Group group, Motion motion, std::vector<double> margins,
         double slack);
  Prover(const Prover&) = delete;

  // `interrupt` is called now and then and may throw.
  Proof prove(const std::function<void()>& interrupt);

  // What can be proven of every pair on one segment; prove() uses the same.
  std::vector<PairBound> bounds(const Segment& segment);
  const Motion& motion() const { return motion_; }

 private:
  // A pair that is open on a segment: where the slab was last, and what is known of its distance there.
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
  struct Judged {
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
  Judged judge(Open& open, double required, double few, bool last_resort, double time);
  void count_work();
  void see(int pair, double distance, double time);
  void look(double time);
  bool find_fixed_violation();
  bool prove_node(Node node, std::vector<Node>& heap);
  void refuse(Outcome outcome, int pair, double distance, double uncertainty, double time);
  void tighten();
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
  std::vector<Vec3> hints_;  // of every pair, where its slab was at the last look
  Strays strays_;
  std::vector<Node> leaves_;  // what is proven, but not known well
  Proof proof_;
  int number_ = 0;
  int work_ = 0;
  const std::function<void()>* interrupt_ = nullptr;
};

}  // namespace wayproof
