// Corners: breaks of a path at which a derivative jumps, as planning/retime/smooth_pieces.py finds them.
#pragma once

#include <cstddef>
#include <vector>

#include "timing/speed_profile.hpp"

namespace wayproof {

// Pieces, from the second on, at whose beginning one of the first `smoothness` derivatives jumps.
std::vector<std::size_t> corners(const PolynomialPath& path, std::size_t smoothness);

}  // namespace wayproof
