// The parts of the Python module, and what they return to it.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <vector>

namespace wayproof {

namespace nb = nanobind;

void bind_scene(nb::module_& m);
void bind_checker(nb::module_& m);
void bind_ik(nb::module_& m);
void bind_prover(nb::module_& m);
void bind_refine(nb::module_& m);
void bind_curve(nb::module_& m);
void bind_timing(nb::module_& m);
void bind_retime(nb::module_& m);
void bind_search(nb::module_& m);
void bind_shortcut(nb::module_& m);
void bind_dynamics(nb::module_& m);
void bind_torques(nb::module_& m);
void bind_loads(nb::module_& m);

// A new numpy array that owns a copy of `values`.
template <typename T, typename... Sizes>
auto array_of(const std::vector<T>& values, Sizes... sizes) {
  T* data = new T[values.size() + 1];
  for (std::size_t i = 0; i < values.size(); ++i) data[i] = values[i];
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  return nb::ndarray<nb::numpy, T>(data, {static_cast<std::size_t>(sizes)...}, owner);
}

}  // namespace wayproof
