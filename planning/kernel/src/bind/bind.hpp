// Helpers of all bindings of the Python module.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "math/vec.hpp"

namespace wayproof {

namespace nb = nanobind;

using Doubles = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Integers = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

void bind_kinds(nb::module_& m);
void bind_scene(nb::module_& m);
void bind_checker(nb::module_& m);
void bind_ik(nb::module_& m);
void bind_prover(nb::module_& m);
void bind_refine(nb::module_& m);

inline void require(bool claim, const char* message) {
  if (!claim) throw std::invalid_argument(message);
}

inline void require_shape(const Doubles& array, std::size_t rows, std::size_t columns, const char* name) {
  if (array.ndim() != 2 || array.shape(0) != rows || array.shape(1) != columns)
    throw std::invalid_argument(std::string(name) + " has the wrong shape");
}

inline Vec3 vec(const double* x) { return {x[0], x[1], x[2]}; }

// From a row of R (9, row-major) and p (3).
inline Transform transform(const double* x) {
  Transform t;
  for (int i = 0; i < 9; ++i) t.R.m[i] = x[i];
  t.p = vec(x + 9);
  return t;
}

// A new numpy array that owns a copy of `values`.
template <typename T, typename... Sizes>
auto array_of(const std::vector<T>& values, Sizes... sizes) {
  T* data = new T[values.size() + 1];
  for (std::size_t i = 0; i < values.size(); ++i) data[i] = values[i];
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  return nb::ndarray<nb::numpy, T>(data, {static_cast<std::size_t>(sizes)...}, owner);
}

}  // namespace wayproof
