#include "prover/prover.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/gjk.hpp"
#include "model/overlap.hpp"
#include "prover/tolerances.hpp"
#include "prover/turn.hpp"

namespace wayproof {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
// Number of instants at which a refused motion is measured for its worst collision.
constexpr int instants = 33;

}  // namespace

Prover::Prover(std::shared_ptr<const Scene> scene, Group group, Motion motion, std::vector<double> margins,
               double slack)
    : scene_(std::move(scene)),
      group_(std::move(group)),
      motion_(std::move(motion)),
      margins_(std::move(margins)),
      slack_(slack),
      bounds_(*scene_, group_, motion_) {
  for (std::size_t i = 0; i < scene_->pairs.size(); ++i) {
    relatives_.push_back(bounds_.relative(scene_->pairs[i]));
    if (relatives_.back().moves) moved_.push_back(static_cast<int>(i));
    // No margin means no contact, without slack.
    required_.push_back(margins_[i] > 0 ? std::max(margins_[i] - slack_, 0.0) : margins_[i]);
  }
  hints_.resize(scene_->pairs.size());
}

Proof Prover::prove(const std::function<void()>& interrupt) {
  const Turn turn(is_busy_);
  proof_ = {};
  leaves_.clear();
  number_ = work_ = 0;
  interrupt_ = &interrupt;
  if (!find_static_violation() && !moved_.empty()) {
    look(0);
    look(motion_.duration());
    std::vector<Node> heap;
    Node root{-inf, 0, motion_.whole(), {}};
    for (int pair : moved_) root.open.push_back({pair, dot(hints_[pair], hints_[pair]) > 0, hints_[pair], -inf});
    heap.push_back(std::move(root));
    bool proven = true;
    while (proven && !heap.empty()) proven = prove_node(pop(heap), heap);
    if (proven) refine_minimum();
    if (proof_.outcome == Outcome::too_near)
      for (int i = 0; i < instants; ++i) look(motion_.duration() * i / (instants - 1));
  }
  proof_.segments = number_ + 1;
  interrupt_ = nullptr;
  return proof_;
}

// Pairs without relative motion are checked once; contact is permitted to them if they have no margin.
bool Prover::find_static_violation() {
  std::vector<double> q(group_.positions.size());
  motion_.positions(0, q.data());
  bounds_.place(q.data());
  double worst = 0;
  for (std::size_t i = 0; i < scene_->pairs.size(); ++i) {
    if (relatives_[i].moves) continue;
    const Pair& pair = scene_->pairs[i];
    const Shape &a = scene_->geometries[pair.a].shape, &b = scene_->geometries[pair.b].shape;
    const double required = margins_[i] - slack_;
    const Separation found = separation(a, bounds_.pose(pair.a), b, bounds_.pose(pair.b), required, -inf, {});
    if (found.lower - required < worst) {
      worst = found.lower - required;
      // Of two half spaces both are minus infinity, and their difference is no number.
      refuse(Outcome::static_pair, static_cast<int>(i), found.upper, std::max(0.0, found.upper - found.lower), 0);
    }
  }
  return proof_.outcome == Outcome::static_pair;
}

void Prover::refuse(Outcome outcome, int pair, double distance, double uncertainty, double time) {
  proof_.outcome = outcome;
  proof_.pair = pair;
  proof_.distance = distance, proof_.uncertainty = uncertainty, proof_.time = time;
}

// The least bound first; numbers break ties, so that every run is the same.
bool Prover::later(const Node& a, const Node& b) const {
  return a.floor != b.floor ? a.floor > b.floor : a.number > b.number;
}

void Prover::push(std::vector<Node>& heap, Node node) const {
  heap.push_back(std::move(node));
  std::push_heap(heap.begin(), heap.end(), [this](const Node& a, const Node& b) { return later(a, b); });
}

Prover::Node Prover::pop(std::vector<Node>& heap) const {
  std::pop_heap(heap.begin(), heap.end(), [this](const Node& a, const Node& b) { return later(a, b); });
  Node node = std::move(heap.back());
  heap.pop_back();
  return node;
}

bool Prover::is_short(const Segment& segment) const {
  return segment.is_part() && segment.end - segment.begin < shortest;
}

void Prover::enter(const Segment& segment) {
  motion_.enter(segment, deviation_);
  bounds_.enter(deviation_);
  ++proof_.looks;
}

void Prover::count_work() {
  if (++work_ % interrupt_every == 0) (*interrupt_)();
}

void Prover::see(int pair, double distance, double time) {
  const auto note = [&](ClosestApproach& sighting, double what) {
    if (what < sighting.least) sighting = {what, pair, distance, time};
  };
  if (distance <= rounding) {
    const Pair& both = scene_->pairs[pair];
    const double depth = overlap(scene_->geometries[both.a].shape, bounds_.pose(both.a),
                                 scene_->geometries[both.b].shape, bounds_.pose(both.b))
                             .width;
    distance = std::min(distance, depth);
  }
  note(proof_.nearest, distance);
  note(proof_.tightest, distance - margins_[pair]);
}

// Bounds a pair's distance on the entered segment until the bound is above `required`, or as good as possible. A
// distance of `few` or less is not refined further.
Prover::PairCheck Prover::check_pair(Open& open, double required, double few, bool last_resort, double time) {
  count_work();
  const Pair& pair = scene_->pairs[open.pair];
  const auto& relative = relatives_[open.pair];
  const Shape &a = scene_->geometries[pair.a].shape, &b = scene_->geometries[pair.b].shape;
  const bool flat_a = a.kind == ShapeKind::half_space, flat_b = b.kind == ShapeKind::half_space;
  if (flat_a && flat_b) {
    see(open.pair, -inf, time);
    return {false, false, -inf, -inf};
  }
  const double approach = bounds_.approach(pair, relative);
  if (!(approach < inf)) return {false, true, -inf, inf};
  const double wanted = approach + required + 2 * rounding;
  const double gap = norm(bounds_.center(pair.a) - bounds_.center(pair.b)) - a.radius - b.radius;
  if (gap >= wanted) return {true, false, gap - approach, inf};
  if (approach > wide && !last_resort && gap > -inf) return {false, false, gap - approach, inf};
  const Transform &X_WA = bounds_.pose(pair.a), &X_WB = bounds_.pose(pair.b);
  double lower = gap;
  if (open.aimed && !flat_a && !flat_b) {
    const double width = slab(a, X_WA, b, X_WB, open.n);
    lower = std::max(lower, width);
    if (lower >= wanted) return {true, false, lower - approach, inf};
    const double bound = bounds_.along(pair, relative, open.n, width, required + 2 * rounding);
    if (bound > -inf) return {true, false, bound, inf};
  }
  // A share of what the segment costs anyway is not worth looking for, unless it is news.
  const double known = std::max(proof_.nearest.least, proof_.tightest.least + margins_[open.pair]);
  const Vec3 guess = open.aimed ? open.n : Vec3{};
  Separation found = separation(a, X_WA, b, X_WB, wanted, few, guess, std::max(rounding, coarse * approach));
  if (found.lower < known && found.upper > few && found.upper - found.lower > rounding)
    found = separation(a, X_WA, b, X_WB, known, few, found.direction);
  open.aimed = true, open.n = found.direction;
  see(open.pair, found.upper, time);
  lower = std::max(lower, found.lower);
  if (found.upper <= few) return {false, false, lower - approach, found.upper};
  if (lower >= wanted) return {true, false, lower - approach, found.upper};
  const double bound = bounds_.along(pair, relative, open.n, found.lower, required + 2 * rounding);
  if (bound > -inf) return {true, false, bound, found.upper};
  return {false, false, lower - approach, found.upper};
}

// Decides pairs on a segment where possible, and pushes the undecided ones.
bool Prover::prove_node(Node node, std::vector<Node>& heap) {
  enter(node.segment);
  const bool exhausted = is_short(node.segment) || number_ > most_segments;
  const double well = target();
  std::vector<Open> rest, kept;
  double floor = inf, kept_floor = inf, least = inf;
  int worst = -1;
  PairCheck worst_found{};
  for (Open& open : node.open) {
    const double required = required_[open.pair];
    const PairCheck found = check_pair(open, required, required, exhausted, node.segment.time);
    // So near that rounding decides: no segment is short enough for a proof.
    if (found.distance <= required + rounding) {
      refuse(Outcome::too_near, open.pair, found.distance, 0, node.segment.time);
      return false;
    }
    open.bound = std::max(open.bound, found.bound);
    if (!found.decided) {
      rest.push_back(open);
      floor = std::min(floor, found.bound - required);
      if (worst < 0 || found.bound - required < least || found.unbounded)
        least = found.bound - required, worst = open.pair, worst_found = found;
    } else if (open.bound < well) {
      kept.push_back(open);
      kept_floor = std::min(kept_floor, open.bound);
    } else {
      proof_.floor = std::min(proof_.floor, open.bound);
    }
  }
  if (!kept.empty()) leaves_.push_back({kept_floor, node.number, node.segment, std::move(kept)});
  if (rest.empty()) return true;
  if (exhausted || worst_found.unbounded) {
    refuse(Outcome::unproven, worst, worst_found.distance, worst_found.distance - worst_found.bound, node.segment.time);
    return false;
  }
  split(node, std::max(floor, node.floor), rest, heap);
  return true;
}

void Prover::split(const Node& node, double floor, const std::vector<Open>& rest, std::vector<Node>& heap) {
  for (int which = 0; which < 2; ++which) push(heap, {floor, ++number_, motion_.half(node.segment, which), rest});
}

std::vector<PairBound> Prover::bounds(const Segment& segment) {
  const Turn turn(is_busy_);
  enter(segment);
  std::vector<PairBound> found;
  for (std::size_t i = 0; i < scene_->pairs.size(); ++i) {
    const Pair& pair = scene_->pairs[i];
    const double approach = bounds_.approach(pair, relatives_[i]);
    const Separation exact = separation(scene_->geometries[pair.a].shape, bounds_.pose(pair.a),
                                        scene_->geometries[pair.b].shape, bounds_.pose(pair.b), inf, -inf, {});
    double along = -inf;
    for (int k = 0; k <= 16 && along == -inf; ++k)
      along = bounds_.along(pair, relatives_[i], exact.direction, exact.lower, exact.lower - approach * k / 8);
    found.push_back({approach, exact.lower - approach, along});
  }
  return found;
}

}  // namespace wayproof
