#include "search/rrt_connect.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace wayproof {
namespace {

double distance(std::span<const double> a, std::span<const double> b) {
  double square = 0;
  for (std::size_t v = 0; v < a.size(); ++v) square += (a[v] - b[v]) * (a[v] - b[v]);
  return std::sqrt(square);
}

// Whether an edge would not move at all, by rounding.
bool are_equal(std::span<const double> a, std::span<const double> b) {
  constexpr double rounding = 2 * std::numeric_limits<double>::epsilon();
  for (std::size_t v = 0; v < a.size(); ++v)
    if (std::abs(a[v] - b[v]) > rounding) return false;
  return true;
}

}  // namespace

RrtConnect::RrtConnect(ConnectSpace space, std::span<const double> start, std::span<const double> goals,
                       std::uint32_t seed)
    : nq_(start.size()),
      space_(std::move(space)),
      goals_(goals.begin(), goals.end()),
      generator_(seed),
      trees_{{NearestState(static_cast<int>(start.size())), {}, {}},
             {NearestState(static_cast<int>(start.size())), {}, {}}},
      target_(start.size()),
      toward_(start.size()),
      goal_distance_(std::numeric_limits<double>::infinity()) {
  add(0, start, -1);
}

std::span<const double> RrtConnect::state(int tree, int vertex) const {
  return {trees_[tree].states.data() + nq_ * static_cast<std::size_t>(vertex), nq_};
}

void RrtConnect::add(int tree, std::span<const double> q, int parent) {
  Tree& t = trees_[tree];
  added_ = t.nearest.count();
  t.nearest.add(q);
  t.states.insert(t.states.end(), q.begin(), q.end());
  t.parents.push_back(parent);
}

// The next goal, while those in the tree are less than half as many as its vertices.
void RrtConnect::add_goals() {
  const int size = trees_[1].nearest.count();
  if ((size > 0 && num_goals_used_ >= size / 2) || nq_ * static_cast<std::size_t>(num_goals_used_) >= goals_.size())
    return;
  add(1, {goals_.data() + nq_ * static_cast<std::size_t>(num_goals_used_), nq_}, -1);
  ++num_goals_used_;
}

// A number of [0, 1) of 64 random bits, the lower half first.
double RrtConnect::uniform() {
  constexpr double half = 4294967296.0;
  const auto low = static_cast<double>(generator_());
  const auto high = static_cast<double>(generator_());
  return std::min((low + high * half) / (half * half), std::nextafter(1.0, 0.0));
}

void RrtConnect::sample() {
  for (std::size_t v = 0; v < nq_; ++v) target_[v] = (space_.upper[v] - space_.lower[v]) * uniform() + space_.lower[v];
}

// One edge from the nearest vertex toward the target. Edges are checked in the direction of the path.
RrtConnect::Growth RrtConnect::grow(int tree, const EdgeVerdict& is_free) {
  const int near = trees_[tree].nearest.nearest(target_);
  const std::span<const double> from = state(tree, near);
  const double away = distance(from, target_);
  const bool reaches = !(away > space_.range);
  if (!reaches) {
    const double fraction = space_.range / away;
    for (std::size_t v = 0; v < nq_; ++v) toward_[v] = from[v] + (target_[v] - from[v]) * fraction;
    if (are_equal(from, toward_)) return Growth::trapped;
  }
  const std::span<const double> to = reaches ? target_ : toward_;
  if (!(tree == 0 ? is_free(from, to) : is_free(to, from))) return Growth::trapped;
  add(tree, to, near);
  return reaches ? Growth::reached : Growth::advanced;
}

void RrtConnect::note_distance(std::span<const double> q) {
  for (std::size_t k = 0; k < goals_.size(); k += nq_)
    goal_distance_ = std::min(goal_distance_, distance(q, {goals_.data() + k, nq_}));
}

// One sample: a tree grows toward it, then the other one as far as it gets toward the new vertex.
bool RrtConnect::step(const EdgeVerdict& is_free) {
  const int tree = turn_, other = 1 - turn_;
  turn_ = other;
  add_goals();
  sample();
  const Growth first = grow(tree, is_free);
  if (first == Growth::trapped) return false;
  const int added = added_;
  if (first == Growth::advanced) target_ = toward_;
  Growth growth = grow(other, is_free);
  const int last_grown = growth == Growth::trapped ? tree : other;
  while (growth == Growth::advanced) growth = grow(other, is_free);
  if (growth == Growth::reached) {
    meeting_[tree] = added;
    meeting_[other] = added_;
    return true;
  }
  if (last_grown == 0) note_distance(state(0, added_));
  return false;
}

bool RrtConnect::solve(const EdgeVerdict& is_free, const std::function<bool()>& is_over) {
  while (!is_over())
    if (step(is_free)) return true;
  return false;
}

std::vector<double> RrtConnect::path() const {
  std::vector<double> rows;
  if (meeting_[0] < 0) return rows;
  int vertices[2] = {meeting_[0], meeting_[1]};
  // Both trees have the configuration at which they meet: the path has it once.
  const int skipped = trees_[0].parents[vertices[0]] >= 0 ? 0 : 1;
  vertices[skipped] = trees_[skipped].parents[vertices[skipped]];
  std::vector<int> forward;
  for (int k = vertices[0]; k >= 0; k = trees_[0].parents[k]) forward.push_back(k);
  std::reverse(forward.begin(), forward.end());
  const auto append = [&](std::span<const double> q) { rows.insert(rows.end(), q.begin(), q.end()); };
  for (int k : forward) append(state(0, k));
  for (int k = vertices[1]; k >= 0; k = trees_[1].parents[k]) append(state(1, k));
  return rows;
}

}  // namespace wayproof
