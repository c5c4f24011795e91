// Turn: the one call that uses a prover.
#pragma once

#include <atomic>
#include <stdexcept>

namespace wayproof {

class Turn {
 public:
  explicit Turn(std::atomic<bool>& is_busy) : is_busy_(is_busy) {
    if (is_busy_.exchange(true)) throw std::logic_error("the prover is in use by another call");
  }
  ~Turn() { is_busy_ = false; }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  std::atomic<bool>& is_busy_;
};

}  // namespace wayproof
