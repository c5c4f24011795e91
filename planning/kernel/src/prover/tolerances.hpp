// Tolerances and limits that all proofs share.
#pragma once

namespace wayproof {

// Bounds are rounded by less than this [m].
inline constexpr double rounding = 1e-9;
// Segments shorter than this [s] are not halved: what they leave undecided is unproven.
inline constexpr double shortest = 1e-7;
// Pairs that may come nearer than this within a segment are not measured in it [m].
inline constexpr double wide = 0.25;
// Accuracy of a distance in a segment, as a share of its change there.
inline constexpr double coarse = 0.02;
// Number of pair checks between two calls of `interrupt`.
inline constexpr int interrupt_every = 256;

}  // namespace wayproof
