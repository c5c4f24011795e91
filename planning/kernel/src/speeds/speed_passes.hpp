// TOPP-RA's two passes over the cells of a path; planning/retime/toppra/toppra_passes.py describes them, and has toppra
// itself solve the programs. The numbers are the same.
#pragma once

#include <span>
#include <vector>

namespace wayproof {

// The greatest x = (ds/dt)^2 at the edges of cells, from rest to rest, with a u + b x <= 1 on every cell,
// [cells][rows], and caps on x at the edges. Empty if toppra would find none.
std::vector<double> squared_speeds(std::span<const double> edges, std::span<const double> a, std::span<const double> b,
                                   std::span<const double> caps);

}  // namespace wayproof
