#include "prover/motion.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "math/polyline.hpp"

namespace wayproof {
namespace {

double binomial(int n, int k) {
  double c = 1;
  for (int i = 1; i <= k; ++i) c = c * (n - k + i) / i;
  return c;
}

// Splits the coefficients of a curve at its middle (de Casteljau); `right` may be `whole`.
void split(const double* whole, int terms, int nv, double* left, double* right) {
  std::copy(whole, whole + terms * nv, right);
  for (int i = 0; i < terms; ++i) {
    std::copy(right, right + nv, left + i * nv);
    for (int j = 0; j + 1 < terms - i; ++j)
      for (int v = 0; v < nv; ++v) right[j * nv + v] = 0.5 * (right[j * nv + v] + right[(j + 1) * nv + v]);
  }
}

// Differences below this count as zero [rad or m]: the prover's margin for rounding [m] is larger than that times any
// lever arm.
constexpr double negligible = 1e-12;

// Rounding error of Bernstein coefficients and values of a polynomial: derived in
// planning/certify/intervals/rounding.py. `size` is the sum of |c_k| w^k, `largest` the largest coefficient.
double rounding_of(int terms, double size, double largest) {
  constexpr double unit = 1.1102230246251565e-16;
  return (terms + 1) * unit * (5 * size + 65 * largest);
}

double norm_of(const double* x, int size) {
  double square = 0;
  for (int i = 0; i < size; ++i) square += x[i] * x[i];
  return std::sqrt(square);
}

}  // namespace

Motion::Motion(const Tree& tree, const Group& group, std::vector<double> breaks, std::vector<double> bases,
               std::vector<double> coefficients, int terms)
    : nq_(static_cast<int>(group.positions.size())),
      nv_(static_cast<int>(group.velocities.size())),
      terms_(terms),
      breaks_(std::move(breaks)),
      bases_(std::move(bases)),
      coefficients_(std::move(coefficients)) {
  int v = 0;
  for (int q = 0; q < nq_;) {
    const Link* link = nullptr;
    for (const Link& l : tree.links)
      if (l.kind != JointKind::fixed && l.position == group.positions[q]) link = &l;
    if (!link) throw std::invalid_argument("a group has whole joints");
    if (v + wayproof::num_velocities(link->kind) > nv_ || q + wayproof::num_positions(link->kind) > nq_)
      throw std::invalid_argument("a group's positions and velocities differ");
    add_coordinates(link->kind, q, v);
    q += wayproof::num_positions(link->kind), v += wayproof::num_velocities(link->kind);
  }
  if (v != nv_) throw std::invalid_argument("a group's positions and velocities differ");
  block_of_.assign(nv_, 0);
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    for (int i = 0; i < blocks_[b].size; ++i) block_of_[blocks_[b].column + i] = static_cast<int>(b);

  const int n = num_pieces(), size = terms_ * nv_;
  bernstein_.assign(static_cast<std::size_t>(n) * size, 0);
  middles_.resize(static_cast<std::size_t>(n) * nv_);
  centers_.resize(static_cast<std::size_t>(n) * nq_);
  std::vector<double> left(size), right(size), weights(terms_ * terms_);
  for (int i = 0; i < terms_; ++i)
    for (int k = 0; k <= i; ++k) weights[i * terms_ + k] = binomial(i, k) / binomial(terms_ - 1, k);
  for (int p = 0; p < n; ++p) {
    const double width = breaks_[p + 1] - breaks_[p];
    double* b = &bernstein_[static_cast<std::size_t>(p) * size];
    double power = 1;
    for (int k = 0; k < terms_; ++k, power *= width)
      for (int i = k; i < terms_; ++i) {
        const double weight = weights[i * terms_ + k] * power;
        for (int c = 0; c < nv_; ++c)
          b[i * nv_ + c] += weight * coefficients_[static_cast<std::size_t>(p) * size + k * nv_ + c];
      }
    split(b, terms_, nv_, left.data(), right.data());
    double* middle = &middles_[static_cast<std::size_t>(p) * nv_];
    std::copy(right.begin(), right.begin() + nv_, middle);
    plus(&bases_[static_cast<std::size_t>(p) * nq_], middle, &centers_[static_cast<std::size_t>(p) * nq_]);
    for (const Ball& ball : balls_) {
      double deviation = 0;
      for (int i = 0; i < terms_; ++i) {
        const double* c = b + i * nv_ + ball.column;
        const double away[3] = {c[0] - middle[ball.column], c[1] - middle[ball.column + 1],
                                c[2] - middle[ball.column + 2]};
        deviation = std::max(deviation, norm_of(away, 3));
      }
      ball_deviations_.push_back(deviation);
    }
  }
  bound_loose();
  bound_chords();
}

// Of a joint whose coordinates begin at q and v of the group's.
void Motion::add_coordinates(JointKind kind, int q, int v) {
  const auto add_plain = [&](int from_q, int from_v, int count) {
    for (int i = 0; i < count; ++i) plain_.push_back({q + from_q + i, v + from_v + i});
  };
  switch (kind) {
    case JointKind::fixed: break;
    case JointKind::revolute:
    case JointKind::prismatic:
      add_plain(0, 0, 1);
      blocks_.push_back({v, 1, false});
      break;
    case JointKind::planar:
      add_plain(0, 0, 3);
      blocks_.push_back({v, 2, false});
      blocks_.push_back({v + 2, 1, false});
      break;
    case JointKind::floating:
      balls_.push_back({q, v});
      add_plain(4, 3, 3);
      blocks_.push_back({v, 3, true});
      blocks_.push_back({v + 3, 3, false});
      break;
  }
}

void Motion::bound_loose() {
  const int n = num_pieces();
  const double *b = bernstein_.data(), *c = coefficients_.data();
  std::vector<double> end(nq_), begin(nq_);
  loose_.assign(static_cast<std::size_t>(n) * nv_, 0);
  for (int p = 0; p < n; ++p, b += terms_ * nv_, c += terms_ * nv_) {
    const double *base = &bases_[static_cast<std::size_t>(p) * nq_], width = breaks_[p + 1] - breaks_[p];
    double* loose = &loose_[static_cast<std::size_t>(p) * nv_];
    for (int v = 0; v < nv_; ++v) {
      double size = 0, largest = 0, power = 1;
      for (int k = 0; k < terms_; ++k, power *= width) {
        size += std::abs(c[k * nv_ + v]) * power;
        largest = std::max(largest, std::abs(b[k * nv_ + v]));
      }
      loose[v] = rounding_of(terms_, size, largest);
    }
    if (p + 1 < n) {
      plus(base, b + (terms_ - 1) * nv_, end.data());
      plus(base + nq_, b + terms_ * nv_, begin.data());
      for (auto [q, v] : plain_) loose[v] += std::abs(begin[q] - end[q]);
      for (const Ball& ball : balls_) loose[ball.column] += angle(ball, begin.data(), end.data());
    }
    for (int v = 0; v < nv_; ++v)
      if (loose[v] < negligible) loose[v] = 0;
    for (std::size_t k = 0; k < balls_.size(); ++k)
      ball_deviations_[p * balls_.size() + k] += norm_of(loose + balls_[k].column, 3);
  }
}

// Points and residuals of a ball, whose coordinates begin anew with every piece, are zero.
void Motion::bound_chords() {
  const int n = num_pieces();
  points_.assign(static_cast<std::size_t>(n + 1) * nv_, 0);
  residuals_.assign(static_cast<std::size_t>(n) * nv_, 0);
  std::vector<double> control(terms_ * nv_, 0.0), away(nv_);
  const double* last = &control[(terms_ - 1) * nv_];
  for (int p = 0; p < n; ++p) {
    const double *b = &bernstein_[static_cast<std::size_t>(p) * terms_ * nv_],
                 *base = &bases_[static_cast<std::size_t>(p) * nq_];
    double *point = &points_[static_cast<std::size_t>(p) * nv_],
           *residual = &residuals_[static_cast<std::size_t>(p) * nv_];
    for (int i = 0; i < terms_; ++i)
      for (auto [q, v] : plain_) control[i * nv_ + v] = base[q] + b[i * nv_ + v];
    for (int v = 0; v < nv_; ++v) point[v] = control[v], point[v + nv_] = last[v];
    for (int i = 1; i + 1 < terms_; ++i) {
      distance_from_chord(&control[i * nv_], control.data(), last, nv_, away.data());
      for (int v = 0; v < nv_; ++v) residual[v] = std::max(residual[v], std::abs(away[v]));
    }
    // The chord ends at the beginning of the next piece.
    for (auto [q, v] : plain_) residual[v] += loose_[static_cast<std::size_t>(p) * nv_ + v];
  }
}

void Motion::plus(const double* base, const double* delta, double* q) const {
  for (auto [i, v] : plain_) q[i] = base[i] + delta[v];
  for (const Ball& ball : balls_) {
    const double *a = base + ball.position, *phi = delta + ball.column;
    const double angle = norm_of(phi, 3), half = angle / 2;
    const double s = angle > 1e-8 ? std::sin(half) / angle : 0.5, c = std::cos(half);
    const double x = s * phi[0], y = s * phi[1], z = s * phi[2];
    double* r = q + ball.position;
    r[0] = a[0] * c - a[1] * x - a[2] * y - a[3] * z;
    r[1] = a[0] * x + a[1] * c + a[2] * z - a[3] * y;
    r[2] = a[0] * y - a[1] * z + a[2] * c + a[3] * x;
    r[3] = a[0] * z + a[1] * y - a[2] * x + a[3] * c;
  }
}

Segment Motion::range(int first, int last) const {
  Segment s;
  const int middle = (first + last) / 2;
  s.begin = breaks_[first], s.end = breaks_[last], s.time = 0.5 * (breaks_[middle] + breaks_[middle + 1]);
  s.first = first, s.last = last;
  if (last - first == 1) {
    const auto at = bernstein_.begin() + static_cast<std::ptrdiff_t>(first) * terms_ * nv_;
    s.control.assign(at, at + terms_ * nv_);
  }
  return s;
}

Segment Motion::half(const Segment& segment, int which) const {
  if (!segment.is_part()) {
    const int middle = (segment.first + segment.last) / 2;
    return which ? range(middle, segment.last) : range(segment.first, middle);
  }
  Segment s;
  const double middle = 0.5 * (segment.begin + segment.end);
  s.begin = which ? middle : segment.begin, s.end = which ? segment.end : middle;
  s.time = 0.5 * (s.begin + s.end);
  s.first = segment.first, s.last = segment.last;
  std::vector<double> other(segment.control.size());
  s.control.resize(segment.control.size());
  split(segment.control.data(), terms_, nv_, which ? other.data() : s.control.data(),
        which ? s.control.data() : other.data());
  return s;
}

void Motion::enter(const Segment& segment, JointDeviation& out) const {
  out.q.resize(nq_);
  const double* loose = &loose_[static_cast<std::size_t>(segment.first) * nv_];
  out.residual.assign(nv_, 0);
  if (segment.is_part()) out.residual.assign(loose, loose + nv_);
  out.block.assign(blocks_.size(), 0);
  segment.is_part() ? enter_part(segment, out) : enter_range(segment, out);
  out.num_rows = static_cast<int>(out.rows.size()) / nv_;
}

void Motion::enter_part(const Segment& segment, JointDeviation& out) const {
  const int size = terms_ * nv_;
  std::vector<double> left(size), middle(size);
  split(segment.control.data(), terms_, nv_, left.data(), middle.data());
  plus(&bases_[static_cast<std::size_t>(segment.first) * nq_], middle.data(), out.q.data());
  for (int i = 0; i < terms_; ++i)
    for (int v = 0; v < nv_; ++v) left[i * nv_ + v] = segment.control[i * nv_ + v] - middle[v];
  for (int i = 0; i < terms_; ++i) bound_blocks(&left[i * nv_], out.residual.data(), out);
  for (const Ball& ball : balls_)
    for (int i = 0; i < terms_; ++i) std::fill_n(&left[i * nv_ + ball.column], 3, 0.0);
  simplify(left, terms_, nv_, out.rows, out.residual.data());
}

void Motion::enter_range(const Segment& segment, JointDeviation& out) const {
  const int first = segment.first, count = segment.last - segment.first;
  const int middle = (segment.first + segment.last) / 2;
  const double* center = &centers_[static_cast<std::size_t>(middle) * nq_];
  std::copy(center, center + nq_, out.q.data());
  std::vector<double> points(points_.begin() + first * nv_, points_.begin() + (segment.last + 1) * nv_);
  for (auto [q, v] : plain_)
    for (int i = 0; i <= count; ++i) points[i * nv_ + v] -= center[q];
  for (int i = 0; i < count; ++i) {
    const double* residual = &residuals_[static_cast<std::size_t>(first + i) * nv_];
    bound_blocks(&points[i * nv_], residual, out);
    bound_blocks(&points[(i + 1) * nv_], residual, out);
    for (int v = 0; v < nv_; ++v) out.residual[v] = std::max(out.residual[v], residual[v]);
  }
  simplify(points, count + 1, nv_, out.rows, out.residual.data());
  // A floating joint turns by no more than its tangent moves: exp is 1-Lipschitz from R^3 to SO(3).
  for (std::size_t k = 0; k < balls_.size(); ++k)
    for (int p = first; p < segment.last; ++p) {
      double& deviation = out.block[block_of_[balls_[k].column]];
      deviation = std::max(deviation, angle(balls_[k], &centers_[static_cast<std::size_t>(p) * nq_], center) +
                                          ball_deviations_[p * balls_.size() + k]);
    }
}

void Motion::bound_blocks(const double* point, const double* residual, JointDeviation& out) const {
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const auto [column, size, ball] = blocks_[b];
    const double bound = size == 1 ? std::abs(point[column]) + residual[column]
                                   : norm_of(point + column, size) + norm_of(residual + column, size);
    out.block[b] = std::max(out.block[b], bound);
  }
}

// |a - b| = 2 sin(angle / 4) of unit quaternions, for the nearer of b and -b: well conditioned.
double Motion::angle(const Ball& ball, const double* q1, const double* q0) const {
  double minus[4], plus[4];
  for (int i = 0; i < 4; ++i) {
    minus[i] = q1[ball.position + i] - q0[ball.position + i];
    plus[i] = q1[ball.position + i] + q0[ball.position + i];
  }
  return 4 * std::asin(std::min(std::min(norm_of(minus, 4), norm_of(plus, 4)) / 2, 1.0));
}

void Motion::positions(double time, double* q) const {
  const auto after = std::upper_bound(breaks_.begin(), breaks_.end(), time) - breaks_.begin();
  const int p = std::clamp(static_cast<int>(after) - 1, 0, num_pieces() - 1);
  const double x = time - breaks_[p];
  const double* c = &coefficients_[static_cast<std::size_t>(p) * terms_ * nv_];
  std::vector<double> delta(nv_, 0.0);
  for (int k = terms_ - 1; k >= 0; --k)
    for (int v = 0; v < nv_; ++v) delta[v] = delta[v] * x + c[k * nv_ + v];
  plus(&bases_[static_cast<std::size_t>(p) * nq_], delta.data(), q);
}

}  // namespace wayproof
