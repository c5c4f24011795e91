#include "qp/pairs.hpp"

#include <algorithm>

#include "math/multiversion.hpp"

namespace wayproof {
namespace {

// Sums and minima run in this many lanes, in the same order for every instruction set.
constexpr std::size_t lanes = 8;
constexpr double no_end = 1e300;

double sum_of(const double* sums) {
  return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

WAYPROOF_MULTIVERSION
double product_of(const double* s, const double* z, std::size_t count) {
  double sums[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    for (std::size_t l = 0; l < lanes; ++l) sums[l] += s[i + l] * z[i + l];
  for (; i < count; ++i) sums[0] += s[i] * z[i];
  return sum_of(sums);
}

WAYPROOF_MULTIVERSION
double moved_product(const double* s, const double* z, const double* ds, const double* dz, std::size_t count,
                     double primal, double dual) {
  double sums[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    for (std::size_t l = 0; l < lanes; ++l) sums[l] += (s[i + l] + primal * ds[i + l]) * (z[i + l] + dual * dz[i + l]);
  for (; i < count; ++i) sums[0] += (s[i] + primal * ds[i]) * (z[i] + dual * dz[i]);
  return sum_of(sums);
}

// The least -x / dx of those with dx < 0. Most are longer than one found before, which a product tells without a
// division.
WAYPROOF_MULTIVERSION
double reach(const double* x, const double* dx, std::size_t count) {
  double least = no_end;
  const auto shorten = [&](std::size_t i) {
    if (dx[i] < 0) least = std::min(least, -x[i] / dx[i]);
  };
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    int shorter = 0;
    for (std::size_t l = 0; l < lanes; ++l) shorter |= x[i + l] + least * dx[i + l] < 0;
    if (!shorter) continue;
    for (std::size_t l = 0; l < lanes; ++l) shorten(i + l);
  }
  for (; i < count; ++i) shorten(i);
  return least;
}

WAYPROOF_MULTIVERSION
void move_both(double* s, double* z, const double* ds, const double* dz, std::size_t count, double primal,
               double dual) {
  for (std::size_t i = 0; i < count; ++i) s[i] += primal * ds[i], z[i] += dual * dz[i];
}

WAYPROOF_MULTIVERSION
void row_weights(const double* w, const double* y, const double* e, const double* rest, std::size_t count,
                 double* weight) {
  for (std::size_t k = 0; k < count; ++k) weight[k] = 1 / (w[k] / y[k] + e[k] / rest[k]);
}

WAYPROOF_MULTIVERSION
void target(const double* s, const double* z, const double* ds, const double* dz, std::size_t count, double mu,
            double share, double* wanted) {
  for (std::size_t k = 0; k < count; ++k) wanted[k] = mu - s[k] * z[k] - share * (ds[k] * dz[k]);
}

WAYPROOF_MULTIVERSION
void row_needs(const double* residual, const double* t_over, const double* y, const double* t_under, const double* rest,
               const double* weight, std::size_t count, double* need, double* pull) {
  for (std::size_t k = 0; k < count; ++k) {
    // a dx + de - dw = -r, dw = (t_over - w dy) / y, de = (t_under + e dy) / (price - y).
    need[k] = -residual[k] + t_over[k] / y[k] - t_under[k] / rest[k];
    pull[k] = weight[k] * need[k];
  }
}

// Of one of both slacks: z changes by `sign` dy.
WAYPROOF_MULTIVERSION
void row_steps(const double* s, const double* z, const double* wanted, const double* weight, const double* need,
               const double* along, std::size_t count, double sign, double* ds, double* dz) {
  for (std::size_t k = 0; k < count; ++k) {
    const double change = sign * (weight[k] * (need[k] - along[k]));
    dz[k] = change;
    ds[k] = (wanted[k] - s[k] * change) / z[k];
  }
}

}  // namespace

double ComplementaryPairs::product() const { return product_of(s.data(), z.data(), size()); }

double ComplementaryPairs::product_after(double primal, double dual) const {
  return moved_product(s.data(), z.data(), ds.data(), dz.data(), size(), primal, dual);
}

double ComplementaryPairs::reach_of_s() const { return reach(s.data(), ds.data(), size()); }

double ComplementaryPairs::reach_of_z() const { return reach(z.data(), dz.data(), size()); }

void ComplementaryPairs::move(double primal, double dual) {
  move_both(s.data(), z.data(), ds.data(), dz.data(), size(), primal, dual);
}

void RowPairs::weights(double* weight) const {
  row_weights(over.s.data(), over.z.data(), under.s.data(), under.z.data(), over.size(), weight);
}

void RowPairs::targets(double mu, bool corrects, double* of_over, double* of_under) const {
  const double share = corrects ? 1 : 0;
  target(over.s.data(), over.z.data(), over.ds.data(), over.dz.data(), over.size(), mu, share, of_over);
  target(under.s.data(), under.z.data(), under.ds.data(), under.dz.data(), under.size(), mu, share, of_under);
}

void RowPairs::needs(const double* residual, const double* of_over, const double* of_under, const double* weight,
                     double* need, double* pull) const {
  row_needs(residual, of_over, over.z.data(), of_under, under.z.data(), weight, over.size(), need, pull);
}

void RowPairs::steps(const double* of_over, const double* of_under, const double* weight, const double* need,
                     const double* along) {
  const std::size_t count = over.size();
  row_steps(over.s.data(), over.z.data(), of_over, weight, need, along, count, 1, over.ds.data(), over.dz.data());
  row_steps(under.s.data(), under.z.data(), of_under, weight, need, along, count, -1, under.ds.data(), under.dz.data());
}

}  // namespace wayproof
