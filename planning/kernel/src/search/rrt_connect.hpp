// RrtConnect: two trees of configurations grown toward each other (Kuffner and LaValle, ICRA 2000), step for step as
// OMPL grows them in a box of real numbers, so that the same seed gives the same path.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <vector>

#include "search/nearest_state.hpp"

namespace wayproof {

// Where the trees grow.
struct ConnectSpace {
  std::vector<double> lower, upper;  // bounds of the samples
  double range = 0;                  // greatest length of an edge
};

// Whether the edge between two configurations is free, both ends included.
using EdgeVerdict = std::function<bool(std::span<const double>, std::span<const double>)>;

class RrtConnect {
 public:
  // `goals` are rows of configurations, of which those that are many join their tree one by one.
  RrtConnect(ConnectSpace space, std::span<const double> start, std::span<const double> goals, std::uint32_t seed);

  // Grows both trees until they meet, or `is_over`, which is called before each sample, ends it.
  bool solve(const EdgeVerdict& is_free, const std::function<bool()>& is_over);

  // The path from the start to a goal, rows of configurations; empty before they met.
  std::vector<double> path() const;

  int num_vertices() const { return trees_[0].nearest.count() + trees_[1].nearest.count(); }
  // Edges within the trees; the one at which they meet adds a vertex to both.
  int num_edges() const { return num_vertices() - 1 - num_goals_used_; }
  // Least distance to a goal of where the start's tree was grown toward; infinite if it never was.
  double goal_distance() const { return goal_distance_; }

 private:
  enum class Growth { trapped, advanced, reached };
  struct Tree {
    NearestState nearest;
    std::vector<double> states;
    std::vector<int> parents;
  };

  std::span<const double> state(int tree, int vertex) const;
  void add(int tree, std::span<const double> q, int parent);
  void add_goals();
  void sample();
  Growth grow(int tree, const EdgeVerdict& is_free);
  bool step(const EdgeVerdict& is_free);
  void note_distance(std::span<const double> q);
  double uniform();

  std::size_t nq_;
  ConnectSpace space_;
  std::vector<double> goals_;
  int num_goals_used_ = 0;
  std::mt19937 generator_;
  Tree trees_[2];  // of the start, of the goals
  int turn_ = 0;
  std::vector<double> target_, toward_;  // what is grown toward, and how far an edge gets
  int added_ = -1;                       // vertex that was added last
  int meeting_[2] = {-1, -1};
  double goal_distance_;
};

}  // namespace wayproof
