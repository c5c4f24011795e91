// DistanceQuery: signed distances of the pairs that a group moves, and their gradients by its v.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "model/scene.hpp"

namespace wayproof {

// Near pairs, one after another.
struct DistanceRows {
  std::vector<std::int64_t> configuration, pair;
  std::vector<double> distance;  // signed
  std::vector<double> normal;    // [count][3], unit, in W, from the second shape to the first
  std::vector<double> gradient;  // [count][nv], of the distance with respect to the group's v
};

class DistanceQuery {
 public:
  // Pairs whose distance does not depend on the group are left out.
  DistanceQuery(std::shared_ptr<const Scene> scene, Group group);

  int num_positions() const { return static_cast<int>(group_.positions.size()); }
  int num_velocities() const { return static_cast<int>(group_.velocities.size()); }
  std::size_t num_pairs() const { return scene_->pairs.size(); }

  // Returns every pair that is nearer than its reach in one of [count][nq] configurations, in order of configurations,
  // then of pairs.
  DistanceRows within(std::span<const double> qs, std::size_t count, std::span<const double> reach) const;

 private:
  // Motion of a link by a coordinate of the group's v: about or along an axis.
  struct Rate {
    int link, column;
    double factor;
    bool turns, in_parent;  // whether the axis is given in F, and not in M
    Vec3 axis;
  };
  // A rate at one configuration, in W.
  struct Screw {
    Vec3 axis, p;
  };
  struct MovedPair {
    int pair;
    std::vector<int> of_a, of_b;  // rates that move only one of the two
    double bound;                 // on the radii of both
  };
  struct Workspace;

  std::vector<int> rates_of(int link) const;
  void look(const MovedPair& moved, double reach, Workspace& w, std::int64_t configuration, DistanceRows& rows) const;
  void slope(const MovedPair& moved, const Workspace& w, Vec3 n, Vec3 p_A, Vec3 p_B, double* gradient) const;

  std::shared_ptr<const Scene> scene_;
  Group group_;
  std::vector<Rate> rates_;
  std::vector<MovedPair> moved_;
  std::vector<Transform> X_WL_;  // at the group's state
};

}  // namespace wayproof
