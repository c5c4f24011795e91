// Batch model: the SIMD checker's tables of a scene and a group.
#pragma once

#include <vector>

#include "checker/simd_checker.hpp"
#include "model/scene.hpp"

namespace wayproof {

struct Demand;

// Coordinate of a batch model: its index in the full q, and its conversion before it becomes a float.
struct LaneCoordinate {
  enum class Kind { angle, length, quaternion_w, quaternion_xyz };
  int position;
  Kind kind;
};

struct LaneModelStorage {
  std::vector<LaneLink> links;
  std::vector<LaneBody> bodies;
  std::vector<LaneSphere> outer, inner;
  std::vector<LaneObstacle> obstacles;
  std::vector<LanePlane> planes;
  std::vector<LanePair> obstacle_pairs, body_pairs;
  std::vector<LaneSphere> link_bounds;
  std::vector<LaneGroup> obstacle_groups, link_groups;
  std::vector<LaneCoordinate> coordinates;
  std::vector<int> pair_of;  // the scene's number of each pair, obstacle pairs first
  double slack_per_metre = 0;  // rounding grows with the size of the length coordinates

  LaneModelStorage() = default;
  // X_WL: all links at the group's state.
  LaneModelStorage(const Scene& scene, const Group& group, const std::vector<Demand>& demands,
                   const std::vector<Transform>& X_WL);

  LaneModel view() const;
};

}  // namespace wayproof
