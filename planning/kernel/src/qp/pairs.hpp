// ComplementaryPairs: slacks s > 0 of an interior point method with their multipliers z > 0, and a step of both.
#pragma once

#include <cstddef>
#include <vector>

namespace wayproof {

struct ComplementaryPairs {
  std::vector<double> s, z, ds, dz;

  ComplementaryPairs(std::size_t count, double slack, double multiplier)
      : s(count, slack), z(count, multiplier), ds(count), dz(count) {}

  std::size_t size() const { return s.size(); }
  // Sums of s z, now and after steps of s and z.
  double product() const;
  double product_after(double primal, double dual) const;
  // The longest step after which s, or z, are not negative.
  double reach_of_s() const;
  double reach_of_z() const;
  void move(double primal, double dual);
};

// The two slacks of rows a . x + e - w = least: of w > 0 with the multiplier y, and of the shortfall e > 0.
struct RowPairs {
  ComplementaryPairs over, under;

  explicit RowPairs(std::size_t rows) : over(rows, 0, 0), under(rows, 0, 0) {}

  // The weights of rows in the normal equations, 1 / (w / y + e / (price - y)).
  void weights(double* weight) const;
  // What products are to change by, towards mu; less those of the steps themselves if it corrects.
  void targets(double mu, bool corrects, double* of_over, double* of_under) const;
  // Right sides of the rows: need = -r + t_over / y - t_under / (price - y), and weight * need.
  void needs(const double* residual, const double* of_over, const double* of_under, const double* weight, double* need,
             double* pull) const;
  // Steps of both, from the change of a . x along the step.
  void steps(const double* of_over, const double* of_under, const double* weight, const double* need,
             const double* along);
};

}  // namespace wayproof
