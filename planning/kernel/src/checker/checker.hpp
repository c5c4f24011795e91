// Checker: collision verdicts on configurations and motions of one group, with margins per pair.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "checker/batch_model.hpp"
#include "checker/simd_checker.hpp"
#include "model/kinds.hpp"
#include "model/scene.hpp"

namespace wayproof {

// Distance thresholds of a pair: its distance must be at least `margin`. A pair is certainly in collision if it is
// nearer than `touching`, which is the margin, or 0 where the exact checker is known to overstate positive distances.
struct PairThreshold {
  double margin, touching;
};

// Distance from the threshold below which an exact distance gives no verdict [m]: the exact checker's own tolerance.
constexpr double exact_slack = 1e-5;

// The first edge of some that does not collide: its index, their number if there is none, and its verdict, which is
// unsure as well if it has too many samples to be checked at once; and how many samples it and those before it have,
// without one that is unsure.
struct FirstEdge {
  std::size_t index;
  Verdict verdict;
  std::int64_t num_samples;
};

// Undecided samples of a motion, by number i of n.
struct Unsure {
  std::int64_t motion, i, n;
};

class Checker {
 public:
  Checker(std::shared_ptr<const Scene> scene, Group group, std::vector<PairThreshold> thresholds, BatchKernel kernel);
  ~Checker();

  int num_positions() const { return static_cast<int>(group_.positions.size()); }

  // Checks configurations, [count][nq], a verdict for each.
  void check(std::span<const double> qs, std::span<Verdict> verdicts) const;

  // Checks motions origin + (i / n) displacement, i = 1 .. n, n the least number whose steps are at most `resolution`
  // long: free or colliding; unsure if only some samples are, which are then appended to `unsure`. [count][nq] each.
  // For joints whose q and v are the same.
  void check_motions(std::span<const double> origins, std::span<const double> displacements, double resolution,
                     std::span<Verdict> verdicts, std::vector<Unsure>& unsure) const;

  // Checks edges between rows of configurations, the ends `to` included, as check_motions does; returns how many
  // samples they have. Checks none if those are more than `most`.
  std::int64_t check_edges(std::span<const double> from, std::span<const double> to, double resolution,
                           std::int64_t most, std::span<Verdict> verdicts, std::vector<Unsure>& unsure) const;

  // Returns the first of `count` such edges that does not collide. `from` or `to` may have one row, for all edges. One
  // of more than `most` samples is left unsure.
  FirstEdge first_edge(std::span<const double> from, std::span<const double> to, std::size_t count, double resolution,
                       std::int64_t most) const;

  // Checks one motion between two configurations, both ends included; sets its number of samples.
  Verdict check_edge(std::span<const double> from, std::span<const double> to, double resolution,
                     std::int64_t& n) const;

  // Static pairs, checked once since the group does not move them, that are not certainly free: with any of them no
  // configuration is called free.
  const std::vector<int>& undecided_static_pairs() const { return undecided_static_; }

  const BatchKernel& kernel() const { return kernel_; }

 private:
  struct Workspace;
  struct Lease;
  struct Motion {
    const double *origin, *displacement;
    std::int64_t n;
    bool from_origin;  // whether the origin is a sample too
  };

  // Appends undecided samples as those of motion `number`.
  Verdict check_motion(const Motion& motion, std::int64_t number, std::vector<Unsure>& unsure, Workspace& w) const;

  // Checks at most as many configurations as there are lanes. Returns early, with verdicts missing, if one of them
  // collides and that decides.
  bool check_block(const double* qs, int count, Verdict* verdicts, Workspace& w, bool any_hit_decides) const;
  Verdict check_exactly(const double* q, unsigned lane, const BatchVerdict& v, Workspace& w) const;
  // `direction` is a guess of the separating direction, then the one found.
  Verdict check_pair(int pair, const Transform* X_WL, Vec3& direction) const;

  std::shared_ptr<const Scene> scene_;
  Group group_;
  std::vector<PairThreshold> thresholds_;
  BatchKernel kernel_;
  BatchModelStorage batch_;
  std::vector<Transform> X_WL_;  // at the group's state
  std::vector<int> undecided_static_;
  std::vector<int> exact_;  // with half spaces that the group moves: the lanes have half spaces only as obstacles
  mutable std::mutex idle_mutex_;
  mutable std::unique_ptr<Workspace> idle_;  // of the last call, for the next one
};

}  // namespace wayproof
