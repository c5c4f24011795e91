#include "model/tree.hpp"

#include <stdexcept>
#include <utility>

namespace wayproof {

int num_positions(JointKind kind) {
  switch (kind) {
    case JointKind::fixed: return 0;
    case JointKind::revolute:
    case JointKind::prismatic: return 1;
    case JointKind::planar: return 3;
    case JointKind::floating: return max_joint_positions;
  }
  throw std::logic_error("a joint of no known kind");
}

int num_velocities(JointKind kind) {
  switch (kind) {
    case JointKind::fixed: return 0;
    case JointKind::revolute:
    case JointKind::prismatic: return 1;
    case JointKind::planar: return 3;
    case JointKind::floating: return max_joint_velocities;
  }
  throw std::logic_error("a joint of no known kind");
}

Transform joint_transform(const Link& link, const double* full) {
  const double* q = full + link.position;
  switch (link.kind) {
    case JointKind::revolute: return {rotation_about(link.axis, q[0]), {}};
    case JointKind::prismatic: return {Mat3{}, q[0] * link.axis};
    case JointKind::planar: return {rotation_about({0, 0, 1}, q[2]), {q[0], q[1], 0}};
    case JointKind::floating: return {rotation_of_quaternion(q[0], q[1], q[2], q[3]), {q[4], q[5], q[6]}};
    case JointKind::fixed: return {};
  }
  throw std::logic_error("a joint of no known kind");
}

Group::Group(const Tree& tree, std::vector<int> positions_, std::vector<int> velocities_, std::vector<double> state_)
    : positions(std::move(positions_)), velocities(std::move(velocities_)), state(std::move(state_)) {
  std::vector<char> coordinate(tree.num_positions, 0);
  for (int i : positions) coordinate[i] = 1;
  follows.assign(tree.followers.size(), 0);
  // A follower may follow a later follower: as many rounds as there are followers suffice.
  for (std::size_t round = 0; round < tree.followers.size(); ++round)
    for (std::size_t k = 0; k < tree.followers.size(); ++k)
      if (coordinate[tree.followers[k].leader]) {
        coordinate[tree.followers[k].follower] = 1;
        follows[k] = 1;
      }
  tree.follow(state.data());
  moves.assign(tree.links.size(), 0);
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    const Link& link = tree.links[i];
    bool moved = link.parent >= 0 && moves[link.parent];
    for (int k = 0; k < num_positions(link.kind); ++k) moved |= coordinate[link.position + k] != 0;
    moves[i] = moved;
  }
}

}  // namespace wayproof
