#include "timing/speed_profile.hpp"

#include <algorithm>

namespace wayproof {

std::size_t PolynomialPath::locate(double s) const {
  const auto after = std::upper_bound(breaks.begin(), breaks.end(), s) - breaks.begin();
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - 1, 0, static_cast<std::ptrdiff_t>(pieces()) - 1));
}

}  // namespace wayproof
