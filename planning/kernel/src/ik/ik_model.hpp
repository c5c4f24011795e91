// IkModel: the solver's tables of a chain and its limits.
#pragma once

#include <span>
#include <vector>

#include "ik/ik.hpp"
#include "model/kinematics.hpp"

namespace wayproof {

struct IkStorage {
  std::vector<IkJoint> joints;
  std::vector<IkFlat> flat;
  std::vector<IkQuaternion> quaternions;
  IkModel model;

  // Limits per position, infinite where there are none.
  IkStorage(const Chain& chain, std::span<const double> lower, std::span<const double> upper);

  IkModel view() const {
    IkModel m = model;
    m.joints = joints.data();
    m.flat = flat.data();
    m.quaternions = quaternions.data();
    return m;
  }
};

}  // namespace wayproof
