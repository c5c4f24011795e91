// From a scene and a group to the lane kernel's tables.
#pragma once

#include <vector>

#include "checker/simd_checker.hpp"
#include "model/scene.hpp"

namespace wayproof {

struct Demand;

// One coordinate of a lane model: where it is in the full q, and what is done to it before it
// becomes a float.
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
  double slack_per_metre = 0;  // rounding grows with how far a length coordinate reaches

  LaneModelStorage() = default;
  // X_WL: all links at the group's state.
  LaneModelStorage(const Scene& scene, const Group& group, const std::vector<Demand>& demands,
                   const std::vector<Transform>& X_WL);

  LaneModel view() const;
};

}  // namespace wayproof
