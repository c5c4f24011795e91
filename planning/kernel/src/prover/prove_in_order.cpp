// Prover: the proof in order of time, which tells the first instant that is not proven.
#include <limits>
#include <utility>

#include "prover/prover.hpp"
#include "prover/tolerances.hpp"
#include "prover/turn.hpp"

namespace wayproof {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

}  // namespace

Proof Prover::prove_in_order(const std::function<void()>& interrupt, double resolution) {
  const Turn turn(is_busy_);
  proof_ = {};
  number_ = work_ = 0;
  interrupt_ = &interrupt;
  if (!find_static_violation()) {
    Node root{-inf, 0, motion_.whole(), {}};
    for (int pair : moved_) root.open.push_back({pair, false, {}, -inf});
    std::vector<Node> stack;
    stack.push_back(std::move(root));
    bool proven = true;
    while (proven && !stack.empty()) {
      Node node = std::move(stack.back());
      stack.pop_back();
      proven = prove_next(std::move(node), resolution, stack);
    }
    if (proven) proof_.until = motion_.duration();
  }
  proof_.segments = number_ + 1;
  interrupt_ = nullptr;
  return proof_;
}

// All that comes before the node is proven. Pushes its halves, the earlier one last, if some pair is undecided.
bool Prover::prove_next(Node node, double resolution, std::vector<Node>& stack) {
  enter(node.segment);
  const bool exhausted = is_short(node.segment) || number_ > most_segments;
  std::vector<Open> rest;
  double least = inf;
  int worst = -1;
  PairCheck worst_found{};
  bool near = false;
  for (Open& open : node.open) {
    const double required = required_[open.pair];
    const PairCheck found = check_pair(open, required, required, exhausted, node.segment.time);
    if (found.decided) continue;
    rest.push_back(open);
    const double reserve = found.bound - required;
    const bool violates = found.distance <= required + rounding;
    if (worst < 0 || found.unbounded || (violates && !near) || (violates == near && reserve < least))
      least = reserve, worst = open.pair, worst_found = found;
    near |= violates;
  }
  if (rest.empty()) return true;
  const bool fine = node.segment.is_part() && node.segment.end - node.segment.begin < resolution;
  if (exhausted || worst_found.unbounded || (near && fine)) {
    const double uncertainty = near ? 0 : worst_found.distance - worst_found.bound;
    refuse(near ? Outcome::too_near : Outcome::unproven, worst, worst_found.distance, uncertainty, node.segment.time);
    proof_.until = node.segment.begin;
    return false;
  }
  for (int which = 1; which >= 0; --which) stack.push_back({least, ++number_, motion_.half(node.segment, which), rest});
  return true;
}

}  // namespace wayproof
