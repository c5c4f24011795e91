// The Python module planning.kernel._native.
#include <nanobind/nanobind.h>

#include "bind.hpp"

NB_MODULE(_native, m) {
  m.doc() = "Native collision bounds and kinematics; see planning/kernel.";
  wayproof::bind_scene(m);
  wayproof::bind_checker(m);
  wayproof::bind_ik(m);
  wayproof::bind_prover(m);
}
