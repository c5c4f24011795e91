// TorqueSeries: a motion's joint torques along segments, as polynomials with bounds on their errors.
#pragma once

#include <span>
#include <vector>

#include "math/vec.hpp"
#include "series/series_kernel.hpp"

namespace wayproof {

class TorqueSeries {
 public:
  // Gravity in W.
  TorqueSeries(int num_positions, int num_velocities, const Vec3& gravity);

  int num_positions() const { return chain_.num_positions; }
  int num_velocities() const { return chain_.num_velocities; }
  int num_links() const { return static_cast<int>(links_.size()); }

  // Its parent is an earlier one or the world.
  void add_link(const MovingLink& link) { links_.push_back(link); }

  // Writes coefficients [n][torque_terms][nv] and bounds of errors [n][nv] of all segments; their pieces have `terms`
  // coefficients. `order` is that of the derivative in the inertial terms.
  void of(std::span<const SeriesSegment> segments, int terms, int order, const SeriesKernel& kernel, double* taylor,
          double* errors) const;

  // Writes positions, velocities and accelerations [n][3][3] of a point fixed in the last link, at the middles.
  void points(std::span<const SeriesSegment> segments, int terms, const Vec3& point, const SeriesKernel& kernel,
              double* found) const;

 private:
  SeriesChain chain_of(int order) const;

  SeriesChain chain_;
  std::vector<MovingLink> links_;
};

}  // namespace wayproof
