#include "prover/beside_prover.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "model/gjk.hpp"
#include "model/overlap.hpp"
#include "prover/tolerances.hpp"
#include "prover/turn.hpp"

namespace wayproof {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
// More nodes end a proof as unproven.
constexpr int most_nodes = 100'000;

template <typename T>
void join(const std::vector<T>& a, const std::vector<T>& b, std::vector<T>& out) {
  out = a;
  out.insert(out.end(), b.begin(), b.end());
}

// A motion of both groups that never moves.
Motion still(const Tree& tree, const Group& group) {
  std::vector<double> q;
  q.reserve(group.positions.size());
  for (const int position : group.positions) q.push_back(group.state[position]);
  return {tree, group, {0, 0}, q, std::vector<double>(group.velocities.size(), 0.0), 1};
}

bool is_short(const Segment& segment) { return segment.is_part() && segment.end - segment.begin < shortest; }

}  // namespace

BesideProver::BesideProver(std::shared_ptr<const Scene> scene, Group group, std::array<Motion, 2> motions,
                           std::vector<double> margins, double slack)
    : scene_(std::move(scene)),
      group_(std::move(group)),
      motions_(std::move(motions)),
      still_(still(scene_->tree, group_)),
      margins_(std::move(margins)),
      bounds_(*scene_, group_, still_) {
  const int columns = motions_[0].num_velocities(), all = still_.num_velocities();
  second_position_ = motions_[0].num_positions();
  if (columns + motions_[1].num_velocities() != all)
    throw std::invalid_argument("the group is not that of both motions");
  carrier_of_a_.assign(scene_->pairs.size(), 0);
  for (std::size_t i = 0; i < scene_->pairs.size(); ++i) {
    const Pair& pair = scene_->pairs[i];
    // No margin means no contact, without slack.
    required_.push_back(margins_[i] > 0 ? std::max(margins_[i] - slack, 0.0) : margins_[i]);
    relatives_.push_back(bounds_.relative(pair));
    const auto [a, b, moves] = relatives_.back();
    const bool first_a = bounds_.depends(pair.a, a, 0, columns), first_b = bounds_.depends(pair.b, b, 0, columns);
    const bool second_a = bounds_.depends(pair.a, a, columns, all), second_b = bounds_.depends(pair.b, b, columns, all);
    if (!(first_a || first_b) || !(second_a || second_b)) continue;
    if ((first_a && second_a) || (first_b && second_b)) throw std::invalid_argument("both motions move one shape");
    carrier_of_a_[i] = second_a ? 1 : 0;
    shared_.push_back(static_cast<int>(i));
  }
}

BesideProof BesideProver::prove(const std::function<void()>& interrupt) {
  const Turn turn(is_busy_);
  proof_ = {};
  proof_.pairs = static_cast<int>(shared_.size());
  number_ = work_ = 0;
  interrupt_ = &interrupt;
  Node root{-inf, 0, {motions_[0].whole(), motions_[1].whole()}, {}};
  for (const int pair : shared_) root.open.push_back({pair, false, {}});
  for (const double t : {0.0, motions_[0].duration()})
    for (const double s : {0.0, motions_[1].duration()}) look(root, {t, s});
  std::vector<Node> heap;
  if (!root.open.empty()) heap.push_back(std::move(root));
  // The least bound first; numbers break ties, so that every run is the same.
  const auto later = [](const Node& x, const Node& y) {
    return x.floor != y.floor ? x.floor > y.floor : x.number > y.number;
  };
  bool proven = true;
  while (proven && !heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), later);
    Node node = std::move(heap.back());
    heap.pop_back();
    const std::size_t before = heap.size();
    proven = prove_node(std::move(node), heap);
    for (std::size_t end = before + 1; end <= heap.size(); ++end)
      std::push_heap(heap.begin(), heap.begin() + static_cast<std::ptrdiff_t>(end), later);
  }
  proof_.segments = number_ + 1;
  interrupt_ = nullptr;
  return proof_;
}

void BesideProver::count_work() {
  if (++work_ % interrupt_every == 0) (*interrupt_)();
}

// Both segments, side by side: see beside_prover.hpp.
void BesideProver::enter(const Node& node) {
  for (int k = 0; k < 2; ++k) {
    motions_[k].enter(node.segments[k], parts_[k]);
    times_[k] = node.segments[k].time;
  }
  const auto& [x, y] = parts_;
  join(x.q, y.q, deviation_.q);
  join(x.residual, y.residual, deviation_.residual);
  join(x.block, y.block, deviation_.block);
  deviation_.rows.clear();
  const auto first = static_cast<std::ptrdiff_t>(x.residual.size()),
             second = static_cast<std::ptrdiff_t>(y.residual.size());
  for (int i = 0; i < x.num_rows; ++i)
    for (int j = 0; j < y.num_rows; ++j) {
      deviation_.rows.insert(deviation_.rows.end(), x.rows.begin() + i * first, x.rows.begin() + (i + 1) * first);
      deviation_.rows.insert(deviation_.rows.end(), y.rows.begin() + j * second, y.rows.begin() + (j + 1) * second);
    }
  deviation_.num_rows = x.num_rows * y.num_rows;
  bounds_.enter(deviation_);
}

// Bounds a pair's distance on the entered node until the bound is above its margin, or as good as possible.
BesideProver::PairCheck BesideProver::check_pair(Open& open, bool last_resort) {
  count_work();
  const Pair& pair = scene_->pairs[open.pair];
  const auto& relative = relatives_[open.pair];
  const double required = required_[open.pair];
  const Shape &a = scene_->geometries[pair.a].shape, &b = scene_->geometries[pair.b].shape;
  const bool flat_a = a.kind == ShapeKind::half_space, flat_b = b.kind == ShapeKind::half_space;
  if (flat_a && flat_b) return {false, -inf, -inf};
  const double approach = bounds_.approach(pair, relative);
  const double wanted = approach + required + 2 * rounding;
  const double gap = norm(bounds_.center(pair.a) - bounds_.center(pair.b)) - a.radius - b.radius;
  if (gap >= wanted) return {true, gap - approach, inf};
  if (approach > wide && !last_resort && gap > -inf) return {false, gap - approach, inf};
  const Transform &X_WA = bounds_.pose(pair.a), &X_WB = bounds_.pose(pair.b);
  double lower = gap;
  if (open.aimed && !flat_a && !flat_b) {
    const double width = slab(a, X_WA, b, X_WB, open.n);
    lower = std::max(lower, width);
    if (lower >= wanted) return {true, lower - approach, inf};
    const double bound = bounds_.along(pair, relative, open.n, width, required + 2 * rounding);
    if (bound > -inf) return {true, bound, inf};
  }
  const Vec3 guess = open.aimed ? open.n : Vec3{};
  const Separation found = separation(a, X_WA, b, X_WB, wanted, required, guess, std::max(rounding, coarse * approach));
  open.aimed = true, open.n = found.direction;
  note(open.pair, found.upper, times_);
  lower = std::max(lower, found.lower);
  if (found.upper <= required) return {false, lower - approach, found.upper};
  if (lower >= wanted) return {true, lower - approach, found.upper};
  const double bound = bounds_.along(pair, relative, open.n, found.lower, required + 2 * rounding);
  if (bound > -inf) return {true, bound, found.upper};
  return {false, lower - approach, found.upper};
}

void BesideProver::note(int pair, double distance, const std::array<double, 2>& times) {
  const double reserve = distance - margins_[pair];
  if (reserve < proof_.worst.reserve) proof_.worst = {reserve, pair, distance, times};
}

// Measures the pairs at an instant of either motion as far as they are nearer than those measured before, and keeps
// the slabs for the proof.
void BesideProver::look(Node& root, const std::array<double, 2>& times) {
  std::vector<double> q(group_.positions.size());
  motions_[0].positions(times[0], q.data());
  motions_[1].positions(times[1], q.data() + second_position_);
  bounds_.place(q.data());
  for (Open& open : root.open) {
    const Pair& pair = scene_->pairs[open.pair];
    const Shape &a = scene_->geometries[pair.a].shape, &b = scene_->geometries[pair.b].shape;
    const double known = proof_.worst.reserve + margins_[open.pair];
    const double gap = norm(bounds_.center(pair.a) - bounds_.center(pair.b)) - a.radius - b.radius;
    if (gap >= known) continue;
    count_work();
    const Separation found = separation(a, bounds_.pose(pair.a), b, bounds_.pose(pair.b), known, -inf, open.n);
    open.aimed = true, open.n = found.direction;
    note(open.pair, found.upper, times);
  }
}

// The signed distance of a pair at an instant of either motion, for reports.
void BesideProver::measure(int pair, const std::array<double, 2>& times) {
  const Pair& both = scene_->pairs[pair];
  const Shape &a = scene_->geometries[both.a].shape, &b = scene_->geometries[both.b].shape;
  const Transform &X_WA = bounds_.pose(both.a), &X_WB = bounds_.pose(both.b);
  const bool flat = a.kind == ShapeKind::half_space && b.kind == ShapeKind::half_space;
  double distance = flat ? -inf : separation(a, X_WA, b, X_WB, inf, -inf, {}).upper;
  if (!flat && distance <= rounding) distance = std::min(distance, overlap(a, X_WA, b, X_WB).width);
  proof_.worst = {distance - margins_[pair], pair, distance, times};
}

// Halves the motion with the larger share in the approach of a pair, unless its segment is short.
std::array<BesideProver::Node, 2> BesideProver::halves(const Node& node, int pair, double floor,
                                                       const std::vector<Open>& open) {
  const auto [by_a, by_b] = bounds_.shares(scene_->pairs[pair], relatives_[pair]);
  int which = (by_a >= by_b) == (carrier_of_a_[pair] == 0) ? 0 : 1;
  if (is_short(node.segments[which])) which = 1 - which;
  std::array<Node, 2> both;
  for (int k = 0; k < 2; ++k) {
    both[k] = {floor, ++number_, node.segments, open};
    both[k].segments[which] = motions_[which].half(node.segments[which], k);
  }
  return both;
}

// Decides pairs on a node where possible, and adds nodes for the others.
bool BesideProver::prove_node(Node node, std::vector<Node>& heap) {
  enter(node);
  const bool exhausted = (is_short(node.segments[0]) && is_short(node.segments[1])) || number_ > most_nodes;
  std::vector<Open> rest;
  double least = inf;
  int worst = -1;
  for (Open& open : node.open) {
    const double required = required_[open.pair];
    const PairCheck found = check_pair(open, exhausted);
    // So near that rounding decides: no segments are short enough for a proof.
    if (found.distance <= required + rounding) {
      measure(open.pair, times_);
      proof_.outcome = Outcome::too_near;
      return false;
    }
    if (found.decided) continue;
    rest.push_back(open);
    if (worst < 0 || found.bound - required < least) least = found.bound - required, worst = open.pair;
  }
  if (rest.empty()) return true;
  if (!exhausted) {
    for (Node& half : halves(node, worst, std::max(least, node.floor), rest)) heap.push_back(std::move(half));
    return true;
  }
  measure(worst, times_);
  proof_.outcome = Outcome::unproven;
  return false;
}

}  // namespace wayproof
