#include "checker/checker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "checker/sample_order.hpp"
#include "math/aligned.hpp"
#include "model/gjk.hpp"

namespace wayproof {
namespace {

constexpr double turn = 6.283185307179586;
// Largest position [rad or m] of which single precision gives a verdict; for NaN it gives none.
constexpr double far_off = 1e6;
}  // namespace

// Mutable buffers of one thread's check.
struct Checker::Workspace {
  BatchModel model;
  int width;
  Aligned<float> coordinates, scratch;
  std::vector<int> pairs;
  std::vector<unsigned> lanes;
  std::vector<double> full;
  std::vector<Transform> X_WL;
  std::vector<Vec3> directions;  // last separating direction of each pair, in the frame of its first geometry
  std::vector<double> samples, displacement;
  std::vector<std::int64_t> numbers;
  std::vector<Verdict> found;
  int likely = -1;  // pair that blocked the last motion that was blocked, in the lanes' numbers

  explicit Workspace(const Checker& c)
      : model(c.batch_.view()),
        width(c.kernel_.width),
        coordinates(static_cast<std::size_t>(width) * model.num_coordinates),
        scratch(scratch_floats(model, width)),
        pairs(c.batch_.pair_of.size() + 1),
        lanes(c.batch_.pair_of.size() + 1),
        full(c.group_.state),
        X_WL(c.X_WL_),
        directions(c.scene_->pairs.size()),
        samples(static_cast<std::size_t>(width) * c.num_positions()),
        displacement(c.num_positions()),
        numbers(width),
        found(width) {}

  // Writes one configuration into a lane and returns its largest length coordinate [m]: infinite if the lanes can give
  // no verdict on it.
  double pack(const Checker& c, const double* q, int lane) {
    c.group_.embed(c.scene_->tree, q, full.data());
    double reach = 0;
    bool is_near = true;
    using Kind = BatchCoordinate::Kind;
    for (std::size_t i = 0; i < c.batch_.coordinates.size(); ++i) {
      const auto [position, kind] = c.batch_.coordinates[i];
      double x = full[position];
      is_near &= std::abs(x) < far_off;
      if (kind == Kind::angle && std::abs(x) > turn / 2) x -= turn * std::nearbyint(x / turn);
      if (kind == Kind::length) reach = std::max(reach, std::abs(x));
      if (kind == Kind::quaternion_w) scale = quaternion_scale(&full[position]);
      if (kind == Kind::quaternion_w || kind == Kind::quaternion_xyz) x *= scale;
      coordinates.data()[i * width + lane] = is_near ? static_cast<float>(x) : 0.0f;
    }
    return is_near ? reach : std::numeric_limits<double>::infinity();
  }

  // Copies a lane to all after it, which are computed with the others.
  void repeat_lane(int lane) {
    for (int i = 0; i < model.num_coordinates; ++i) {
      float* row = coordinates.data() + static_cast<std::size_t>(i) * width;
      std::fill(row + lane + 1, row + width, row[lane]);
    }
  }

 private:
  double scale = 1;

  static double quaternion_scale(const double* q) {
    return 1 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  }
};

// A workspace for one call: the idle one unless another call has it.
struct Checker::Lease {
  const Checker& checker;
  std::unique_ptr<Workspace> workspace;

  explicit Lease(const Checker& c) : checker(c) {
    {
      const std::lock_guard lock(c.idle_mutex_);
      workspace = std::move(c.idle_);
    }
    if (!workspace) workspace = std::make_unique<Workspace>(c);
  }
  ~Lease() {
    const std::lock_guard lock(checker.idle_mutex_);
    checker.idle_ = std::move(workspace);
  }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
};

Checker::~Checker() = default;

Checker::Checker(std::shared_ptr<const Scene> scene, Group group, std::vector<PairThreshold> thresholds,
                 BatchKernel kernel)
    : scene_(std::move(scene)),
      group_(std::move(group)),
      thresholds_(std::move(thresholds)),
      kernel_(kernel),
      X_WL_(scene_->tree.links.size()) {
  scene_->tree.place(group_.state.data(), X_WL_.data());
  batch_ = BatchModelStorage(*scene_, group_, thresholds_, X_WL_);
  std::vector<char> is_checked(scene_->pairs.size(), 0);
  for (int pair : batch_.pair_of) is_checked[pair] = 1;
  for (std::size_t i = 0; i < is_checked.size(); ++i) {
    if (is_checked[i]) continue;
    const int pair = static_cast<int>(i);
    Vec3 direction;
    if (scene_->moves_half_space(group_, scene_->pairs[i]))
      exact_.push_back(pair);
    else if (check_pair(pair, X_WL_.data(), direction) != Verdict::free)
      undecided_static_.push_back(pair);
  }
}

Verdict Checker::check_pair(int index, const Transform* X_WL, Vec3& direction) const {
  const Pair pair = scene_->pairs[index];
  const PairThreshold threshold = thresholds_[index];
  const Geometry &a = scene_->geometries[pair.a], &b = scene_->geometries[pair.b];
  const Transform X_WA = scene_->pose(pair.a, X_WL), X_WB = scene_->pose(pair.b, X_WL);
  // Neighbours are always near, and nearly always the same plane separates them.
  if (dot(direction, direction) > 0 &&
      slab(a.shape, X_WA, b.shape, X_WB, X_WA.R * direction) >= threshold.margin + exact_slack)
    return Verdict::free;
  const Separation found =
      separation(a.shape, X_WA, b.shape, X_WB, threshold.margin + exact_slack, threshold.touching - exact_slack, {});
  if (found.lower > 0) direction = transposed_times(X_WA.R, found.direction);
  if (found.lower >= threshold.margin + exact_slack) return Verdict::free;
  return found.upper <= threshold.touching - exact_slack ? Verdict::colliding : Verdict::unsure;
}

// Decides one lane by exact distances of its undecided pairs, and of those that the lanes do not check.
Verdict Checker::check_exactly(const double* q, unsigned lane, const BatchVerdict& v, Workspace& w) const {
  group_.embed(scene_->tree, q, w.full.data());
  group_.place(scene_->tree, w.full.data(), w.X_WL.data());
  Verdict all = Verdict::free;
  const auto collides = [&](int pair) {
    const Verdict one = check_pair(pair, w.X_WL.data(), w.directions[pair]);
    if (one != Verdict::free) all = one;
    return one == Verdict::colliding;
  };
  for (int k = 0; k < v.num_unsure; ++k)
    if ((v.lanes[k] & lane) && collides(batch_.pair_of[v.pairs[k]])) return all;
  for (int pair : exact_)
    if (collides(pair)) return all;
  return all;
}

bool Checker::check_block(const double* qs, int count, Verdict* verdicts, Workspace& w, bool any_hit_decides) const {
  const int nq = num_positions();
  double reach = 0;
  unsigned active = 0;
  for (int lane = 0; lane < count; ++lane) {
    const double far = w.pack(*this, qs + nq * lane, lane);
    if (!std::isfinite(far)) continue;
    reach = std::max(reach, far);
    active |= 1u << lane;
  }
  w.repeat_lane(count - 1);
  BatchVerdict v{0, 0, w.pairs.data(), w.lanes.data(), any_hit_decides, w.likely};
  kernel_.check(w.model, w.coordinates.data(), active, static_cast<float>(batch_.slack_per_metre * reach),
                w.scratch.data(), v);
  if (any_hit_decides) w.likely = v.likely;
  if (any_hit_decides && v.hit) return true;
  unsigned unsure = 0;
  for (int k = 0; k < v.num_unsure; ++k) unsure |= v.lanes[k];
  for (int lane = 0; lane < count; ++lane) {
    const unsigned bit = 1u << lane;
    verdicts[lane] = !(active & bit)                     ? Verdict::unsure
                     : v.hit & bit                       ? Verdict::colliding
                     : (unsure & bit) || !exact_.empty() ? check_exactly(qs + nq * lane, bit, v, w)
                                                         : Verdict::free;
    if (any_hit_decides && verdicts[lane] == Verdict::colliding) return true;
    if (verdicts[lane] == Verdict::free && !undecided_static_.empty()) verdicts[lane] = Verdict::unsure;
  }
  return false;
}

void Checker::check(std::span<const double> qs, std::span<Verdict> verdicts) const {
  const Lease lease(*this);
  Workspace& w = *lease.workspace;
  const auto nq = static_cast<std::size_t>(num_positions()), width = static_cast<std::size_t>(w.width);
  for (std::size_t i = 0; i < verdicts.size(); i += width)
    check_block(qs.data() + nq * i, static_cast<int>(std::min(width, verdicts.size() - i)), &verdicts[i], w, false);
}

Verdict Checker::check_motion(const Motion& motion, std::int64_t number, std::vector<Unsure>& unsure,
                              Workspace& w) const {
  const int nq = num_positions();
  const std::size_t before = unsure.size();
  SampleOrder order(motion.n);
  bool origin_left = motion.from_origin;
  for (;;) {
    int size = 0;
    while (size < w.width && order.next(w.numbers[size])) {
      ++size;
      if (origin_left && size < w.width) w.numbers[size++] = 0, origin_left = false;
    }
    if (!size) break;
    for (int k = 0; k < size; ++k) {
      const double fraction = static_cast<double>(w.numbers[k]) / static_cast<double>(motion.n);
      for (int i = 0; i < nq; ++i) w.samples[k * nq + i] = motion.origin[i] + fraction * motion.displacement[i];
    }
    if (check_block(w.samples.data(), size, w.found.data(), w, true)) {
      unsure.resize(before);
      return Verdict::colliding;
    }
    for (int k = 0; k < size; ++k)
      if (w.found[k] == Verdict::unsure) unsure.push_back({number, w.numbers[k], motion.n});
  }
  return unsure.size() > before ? Verdict::unsure : Verdict::free;
}

void Checker::check_motions(std::span<const double> origins, std::span<const double> displacements, double resolution,
                            std::span<Verdict> verdicts, std::vector<Unsure>& unsure) const {
  const Lease lease(*this);
  const int nq = num_positions();
  for (std::size_t j = 0; j < verdicts.size(); ++j) {
    const std::size_t at = j * static_cast<std::size_t>(nq);
    const double* displacement = displacements.data() + at;
    const Motion motion{origins.data() + at, displacement, num_samples(displacement, nq, resolution), false};
    verdicts[j] = check_motion(motion, static_cast<std::int64_t>(j), unsure, *lease.workspace);
  }
}

std::int64_t Checker::check_edges(std::span<const double> from, std::span<const double> to, double resolution,
                                  std::int64_t most, std::span<Verdict> verdicts, std::vector<Unsure>& unsure) const {
  const int nq = num_positions();
  std::vector<double> displacements(from.size());
  for (std::size_t k = 0; k < from.size(); ++k) displacements[k] = to[k] - from[k];
  std::int64_t total = 0;
  for (std::size_t j = 0; j < verdicts.size(); ++j)
    total += num_samples(&displacements[j * static_cast<std::size_t>(nq)], nq, resolution);
  if (total <= most) check_motions(from, displacements, resolution, verdicts, unsure);
  return total;
}

FirstEdge Checker::first_edge(std::span<const double> from, std::span<const double> to, std::size_t count,
                              double resolution, std::int64_t most) const {
  const Lease lease(*this);
  const auto nq = static_cast<std::size_t>(num_positions());
  std::vector<double> displacement(nq);
  std::vector<Unsure> unsure;
  std::int64_t total = 0;
  for (std::size_t j = 0; j < count; ++j) {
    const double* begin = &from[from.size() > nq ? j * nq : 0];
    const double* end = &to[to.size() > nq ? j * nq : 0];
    for (std::size_t i = 0; i < nq; ++i) displacement[i] = end[i] - begin[i];
    const std::int64_t n = num_samples(displacement.data(), num_positions(), resolution);
    if (n > most) return {j, Verdict::unsure, total};
    const Verdict verdict = check_motion({begin, displacement.data(), n, false}, 0, unsure, *lease.workspace);
    if (verdict == Verdict::unsure) return {j, verdict, total};
    total += n;
    if (verdict == Verdict::free) return {j, verdict, total};
  }
  return {count, Verdict::colliding, total};
}

Verdict Checker::check_edge(std::span<const double> from, std::span<const double> to, double resolution,
                            std::int64_t& n) const {
  const Lease lease(*this);
  const int nq = num_positions();
  double* displacement = lease.workspace->displacement.data();
  for (int i = 0; i < nq; ++i) displacement[i] = to[i] - from[i];
  n = num_samples(displacement, nq, resolution);
  std::vector<Unsure> unsure;
  return check_motion({from.data(), displacement, n, true}, 0, unsure, *lease.workspace);
}

}  // namespace wayproof
