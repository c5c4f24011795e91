// Order of checking the samples 1 .. n of a motion: the far end, then the middle, the quarters and so on (van der
// Corput's sequence in base 2), which meets a collision of width w after about 1 / w samples.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace wayproof {

// The number of samples of a motion: the least whose steps are at most `resolution` long. The same number as
// planning/domain/curves/motion_samples.py has, operation by operation.
inline std::int64_t num_samples(const double* displacement, int nq, double resolution) {
  // More samples would take years, and their number is to fit into an integer.
  constexpr double far_off = 1e6, most_samples = 1e15;
  double square = 0;
  for (int i = 0; i < nq; ++i) square += displacement[i] * displacement[i];
  if (!(square < far_off * far_off)) throw std::invalid_argument("a motion is finite and not too long");
  const double count = std::max(std::ceil(std::sqrt(square) / resolution - 1e-9), 1.0);
  if (!(count < most_samples)) throw std::invalid_argument("the resolution is too fine for so long a motion");
  return static_cast<std::int64_t>(count);
}

class SampleOrder {
 public:
  explicit SampleOrder(std::int64_t n) : n_(n) {
    while ((std::int64_t{1} << bits_) < n) ++bits_;
  }

  // Sets the next number; false after the last one.
  bool next(std::int64_t& number) {
    if (position_ == 0) return position_ = 1, number = n_, n_ > 0;
    for (; position_ < (std::int64_t{1} << bits_); ++position_) {
      std::int64_t mirrored = 0;
      for (int k = 0; k < bits_; ++k) mirrored |= (position_ >> k & 1) << (bits_ - 1 - k);
      if (mirrored < n_) return ++position_, number = mirrored, true;
    }
    return false;
  }

 private:
  std::int64_t n_, position_ = 0;
  int bits_ = 0;
};

}  // namespace wayproof
