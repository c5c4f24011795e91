// BesideProver: proof that two motions keep their pairs apart whatever the timing, at any two instants of both.
//
// A node is a segment of the first motion and one of the second. The two times are independent, so on a node the
// displacement of all coordinates from both centres is in the product of the two sets that `Motion` bounds: rows of the
// first beside rows of the second, every combination of them (a product of convex hulls is the hull of the products of
// their points), residuals and deviations of either side by side. On that product the bounds of `MotionBounds`, of
// first and second order, hold as they do for the motion of one group. A node that they do not decide is halved in the
// motion with the larger share in the approach of its worst pair. A pair counts if its relative pose depends on both
// motions; the others are the matter of the proofs of one motion alone.
#pragma once

#include <array>
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

// A pair at an instant of either motion.
struct Encounter {
  double reserve = std::numeric_limits<double>::infinity();  // distance over the pair's margin
  int pair = -1;
  double distance = std::numeric_limits<double>::infinity();  // at both instants: an upper bound, if positive
  std::array<double, 2> times{};
};

struct BesideProof {
  Outcome outcome = Outcome::proven;
  // The pair at which the proof stopped; if proven, the pair of least reserve of those measured.
  Encounter worst;
  int pairs = 0, segments = 0;
};

class BesideProver {
 public:
  // group: the joints of the first motion, then those of the second. margins: required distance of each pair, of which
  // `slack` less suffices.
  BesideProver(std::shared_ptr<const Scene> scene, Group group, std::array<Motion, 2> motions,
               std::vector<double> margins, double slack);
  BesideProver(const BesideProver&) = delete;

  // `interrupt` is called now and then and may throw. A prover is used by one call at a time.
  BesideProof prove(const std::function<void()>& interrupt);

 private:
  // An undecided pair on a node, and its last slab.
  struct Open {
    int pair;
    bool aimed;
    Vec3 n;
  };
  struct Node {
    double floor;
    int number;
    std::array<Segment, 2> segments;
    std::vector<Open> open;
  };
  struct PairCheck {
    bool decided;
    double bound;     // lower bound on the distance within the node
    double distance;  // at both centres, if measured
  };

  void enter(const Node& node);
  PairCheck check_pair(Open& open, bool last_resort);
  void look(Node& root, const std::array<double, 2>& times);
  bool prove_node(Node node, std::vector<Node>& heap);
  std::array<Node, 2> halves(const Node& node, int pair, double floor, const std::vector<Open>& open);
  void note(int pair, double distance, const std::array<double, 2>& times);
  void measure(int pair, const std::array<double, 2>& times);
  void count_work();

  std::shared_ptr<const Scene> scene_;
  Group group_;
  std::array<Motion, 2> motions_;
  Motion still_;  // of both groups, for the order of their coordinates
  std::vector<double> margins_, required_;
  MotionBounds bounds_;
  std::vector<MotionBounds::Relative> relatives_;
  std::vector<int> shared_;        // pairs that depend on both motions
  std::vector<int> carrier_of_a_;  // of each of them: the motion that carries its first shape
  int second_position_ = 0;        // of the second motion's q in the group's
  std::array<JointDeviation, 2> parts_;
  JointDeviation deviation_;
  std::array<double, 2> times_{};
  BesideProof proof_;
  int number_ = 0, work_ = 0;
  const std::function<void()>* interrupt_ = nullptr;
  std::atomic<bool> is_busy_ = false;
};

}  // namespace wayproof
