// Lanes: eight numbers that are computed at once, in whatever registers the instruction set has.
//
// Sums of lanes are added in one order, so that all instruction sets agree. For functions that are compiled for several
// of them (math/multiversion.hpp).
#pragma once

#include <cmath>
#include <cstddef>

namespace wayproof {

inline constexpr std::size_t num_lanes = 8;

typedef double Lanes __attribute__((vector_size(num_lanes * sizeof(double)), aligned(sizeof(double)), may_alias));

// Eight numbers in sequence, at any address.
[[gnu::always_inline]] inline Lanes load(const double* from) { return *reinterpret_cast<const Lanes*>(from); }
[[gnu::always_inline]] inline void store(double* to, Lanes lanes) { *reinterpret_cast<Lanes*>(to) = lanes; }
[[gnu::always_inline]] inline void add_to(double* to, Lanes lanes) { *reinterpret_cast<Lanes*>(to) += lanes; }

// In every lane the smaller number, and the larger size: compilers make one instruction of such a loop, but not of a
// comparison of lanes.
[[gnu::always_inline]] inline Lanes smaller(Lanes a, Lanes b) {
  Lanes found;
  for (std::size_t i = 0; i < num_lanes; ++i) found[i] = b[i] < a[i] ? b[i] : a[i];
  return found;
}
[[gnu::always_inline]] inline Lanes larger_size(Lanes size, Lanes b) {
  Lanes found;
  for (std::size_t i = 0; i < num_lanes; ++i) found[i] = size[i] < std::abs(b[i]) ? std::abs(b[i]) : size[i];
  return found;
}

[[gnu::always_inline]] inline double smallest_of(Lanes a) {
  double found = a[0];
  for (std::size_t i = 1; i < num_lanes; ++i) found = a[i] < found ? a[i] : found;
  return found;
}
[[gnu::always_inline]] inline double largest_of(Lanes a) {
  double found = a[0];
  for (std::size_t i = 1; i < num_lanes; ++i) found = found < a[i] ? a[i] : found;
  return found;
}

[[gnu::always_inline]] inline double sum_of(Lanes a) {
  return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]));
}

}  // namespace wayproof
