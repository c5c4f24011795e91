// Distinct solutions: which configurations are no duplicates of ones before them. As planning/goals/ranking.py has it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace wayproof {

// Two rows of the same target are duplicates if all their coordinates differ by at most `tolerance`, periodic ones up
// to whole turns; a chain of duplicates is one cluster. Returns whether each row is the first of its cluster.
std::vector<bool> first_of_clusters(std::span<const double> rows, std::span<const std::int64_t> targets,
                                    const std::vector<bool>& is_periodic, double tolerance);

}  // namespace wayproof
