// Batch model: the SIMD checker's tables of a scene and a group.
#pragma once

#include <vector>

#include "checker/simd_checker.hpp"
#include "model/scene.hpp"

namespace wayproof {

struct PairThreshold;

// Coordinate of a batch model: its index in the full q, and its conversion before it becomes a float.
struct BatchCoordinate {
  enum class Kind { angle, length, quaternion_w, quaternion_xyz };
  int position;
  Kind kind;
};

struct BatchModelStorage {
  std::vector<BatchLink> links;
  std::vector<BatchBody> bodies;
  std::vector<BatchSphere> outer, inner;
  std::vector<BatchObstacle> obstacles;
  std::vector<BatchPlane> planes;
  std::vector<BatchPair> obstacle_pairs, body_pairs;
  std::vector<BatchSphere> link_bounds;
  std::vector<BatchGroup> obstacle_groups, link_groups;
  std::vector<BatchCoordinate> coordinates;
  std::vector<int> pair_of;    // the scene's number of each pair, obstacle pairs first
  double slack_per_metre = 0;  // rounding grows with the size of the length coordinates

  BatchModelStorage() = default;
  // X_WL: all links at the group's state.
  BatchModelStorage(const Scene& scene, const Group& group, const std::vector<PairThreshold>& thresholds,
                    const std::vector<Transform>& X_WL);

  BatchModel view() const;
};

}  // namespace wayproof
