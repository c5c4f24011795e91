// fastest_chain: the dynamic program of planning/retime/jerk/speed_dp.py, which says what a segment is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace wayproof {

struct SpeedGrid {
  std::size_t blocks = 0, levels = 0;
  std::vector<double> positions;    // path parameter at the nodes
  std::vector<double> peaks;        // M_n over limits between two nodes, [6][intervals][blocks]
  std::vector<double> speeds;       // candidates at every node, [nodes][levels]
  std::vector<double> jerk_shares;  // of the remaining jerk for the second term
  std::size_t most_intervals = 0;   // of one segment

  std::size_t nodes() const { return positions.size(); }
};

// Segments in order.
struct SpeedChain {
  std::vector<std::int64_t> begin, end;  // nodes
  std::vector<double> before, after;     // speeds at both
  std::vector<double> bounds;            // V, A and J in between, [segments][3]
};

// The fastest chain from the first to the last node, from the first level to the first; empty if there is none.
SpeedChain fastest_chain(const SpeedGrid& grid);

}  // namespace wayproof
