// BoxVisits: the parts of a point's path that contain all of its visits to a box, as
// planning/retime/limits/zone_speed.py finds them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace wayproof {

struct BoxVisits {
  std::vector<std::int64_t> pieces;
  std::vector<double> low, high;  // of the path's parameter
};

// Bernstein coefficients of the point in the box's axes, relative to its centre, [pieces][terms][3]; `half`: half the
// size of the box. Parts that may be partly in the box are halved `halvings` times.
BoxVisits box_visits(std::span<const double> breaks, std::span<const double> points, std::size_t terms,
                     std::span<const double> half, int halvings);

}  // namespace wayproof
