// Aligned: an array of numbers for vector instructions, 64-aligned.
#pragma once

#include <algorithm>
#include <cstddef>
#include <new>

namespace wayproof {

template <typename T>
class Aligned {
 public:
  explicit Aligned(std::size_t count)
      : data_(static_cast<T*>(::operator new[](std::max<std::size_t>(count, 1) * sizeof(T), alignment))) {}
  ~Aligned() { ::operator delete[](data_, alignment); }
  Aligned(const Aligned&) = delete;
  Aligned& operator=(const Aligned&) = delete;

  T* data() { return data_; }

 private:
  static constexpr std::align_val_t alignment{64};
  T* data_;
};

}  // namespace wayproof
