// Prover: refinement of the smallest distance, once the motion is proven or refused.
#include <algorithm>
#include <cmath>
#include <utility>

#include "model/gjk.hpp"
#include "prover/prover.hpp"

namespace wayproof {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
// Accuracy of the smallest distance [m], the larger of these, and the limit of its cost.
constexpr double resolution = 1e-3;
constexpr double relative_resolution = 0.01;
constexpr int refinement_looks = 2000;

}  // namespace

// Lower bound of the smallest distance at which the smallest one measured is accurate enough.
double Prover::target() const {
  const double distance = proof_.nearest.distance;
  return distance - std::max(resolution, relative_resolution * distance);
}

// Halves the segments that may contain a smaller distance than the smallest one measured.
void Prover::refine_minimum() {
  std::make_heap(leaves_.begin(), leaves_.end(), [this](const Node& a, const Node& b) { return later(a, b); });
  const int last = proof_.looks + refinement_looks;
  while (!leaves_.empty()) {
    const double well = target();
    if (leaves_.front().floor >= well || is_short(leaves_.front().segment) || proof_.looks > last) break;
    Node node = pop(leaves_);
    enter(node.segment);
    std::vector<Open> rest;
    double floor = inf;
    for (Open& open : node.open) {
      if (open.bound < well) {
        const PairCheck found = check_pair(open, well, -inf, false, node.segment.time);
        open.bound = std::max(open.bound, found.bound);
        if (!found.decided) {
          rest.push_back(open);
          floor = std::min(floor, open.bound);
          continue;
        }
      }
      proof_.floor = std::min(proof_.floor, open.bound);
    }
    if (!rest.empty()) split(node, floor, rest, leaves_);
  }
  for (const Node& node : leaves_)
    for (const Open& open : node.open) proof_.floor = std::min(proof_.floor, open.bound);
}

// Measures all pairs at an instant for distances smaller than those measured before.
void Prover::look(double time) {
  std::vector<double> q(group_.positions.size());
  motion_.positions(time, q.data());
  bounds_.place(q.data());
  ++proof_.looks;
  std::vector<std::pair<double, int>> order;
  for (int i : moved_) {
    const Pair& pair = scene_->pairs[i];
    const Shape &a = scene_->geometries[pair.a].shape, &b = scene_->geometries[pair.b].shape;
    const double gap = norm(bounds_.center(pair.a) - bounds_.center(pair.b)) - a.radius - b.radius;
    order.emplace_back(std::isnan(gap) ? -inf : gap, i);  // sorting needs numbers
  }
  std::sort(order.begin(), order.end());
  for (const auto& [gap, i] : order) {
    const double known = std::max(proof_.nearest.least, proof_.tightest.least + margins_[i]);
    if (gap >= known) continue;
    count_work();
    const Pair& pair = scene_->pairs[i];
    const Separation found = separation(scene_->geometries[pair.a].shape, bounds_.pose(pair.a),
                                        scene_->geometries[pair.b].shape, bounds_.pose(pair.b), known, -inf, hints_[i]);
    hints_[i] = found.direction;
    if (found.lower < known) see(i, found.upper, time);
  }
}

}  // namespace wayproof
