#include "refine/active_distances.hpp"

#include <cmath>
#include <cstddef>

namespace wayproof {
namespace {

// Share of the largest change of a distance within the box that steps rarely exceed.
constexpr double likely_share = 0.25;

}  // namespace

std::vector<char> likely_rows(const StepBox& box, const DistanceMargins& margins) {
  const std::size_t nq = box.radii.size();
  std::vector<char> takes_part(margins.margin.size());
  for (std::size_t m = 0; m < margins.margin.size(); ++m) {
    double reach = 0;
    for (std::size_t j = 0; j < nq; ++j) reach += std::abs(margins.gradient[m * nq + j] * box.radii[j]);
    takes_part[m] = margins.margin[m] < likely_share * reach;
  }
  return takes_part;
}

bool add_broken(const CurveColumns& columns, const StepBox& box, const DistanceMargins& margins,
                const std::vector<double>& x, std::vector<char>& takes_part) {
  const std::size_t nq = box.radii.size();
  bool is_any = false;
  for (std::size_t m = 0; m < margins.margin.size(); ++m) {
    if (takes_part[m]) continue;
    const auto instant = static_cast<std::size_t>(margins.instant[m]);
    double margin = margins.margin[m];
    for (std::size_t k = 0; k < weights_per_instant; ++k) {
      const std::size_t point = static_cast<std::size_t>(margins.first_point[instant]) + k;
      const std::int64_t column = columns.points[point * nq];
      if (column < 0) continue;
      const double weight = margins.weights[instant * weights_per_instant + k];
      const double* moved = &x[static_cast<std::size_t>(column)];
      for (std::size_t j = 0; j < nq; ++j) margin += weight * margins.gradient[m * nq + j] * box.radii[j] * moved[j];
    }
    if (margin < 0) takes_part[m] = 1, is_any = true;
  }
  return is_any;
}

}  // namespace wayproof
