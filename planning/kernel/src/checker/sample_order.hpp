// Order of checking the samples 1 .. n of a motion: the far end, then the middle, the quarters and so on (van der
// Corput's sequence in base 2), which meets a collision of width w after about 1 / w samples.
#pragma once

#include <cstdint>

namespace wayproof {

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
