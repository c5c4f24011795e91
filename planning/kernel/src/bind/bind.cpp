// The Python module planning.kernel._native.
#include <nanobind/nanobind.h>

#include "bind/bind.hpp"

NB_MODULE(_native, m) {
  nanobind::set_leak_warnings(false);  // leak warnings about its globals at the end of a process are of no use
  m.doc() = "Native collision bounds and kinematics; see planning/kernel.";
  wayproof::bind_kinds(m);
  wayproof::bind_scene(m);
  wayproof::bind_checker(m);
  wayproof::bind_ik(m);
  wayproof::bind_prover(m);
  wayproof::bind_refine(m);
  wayproof::bind_curve(m);
  wayproof::bind_timing(m);
  wayproof::bind_retime(m);
  wayproof::bind_search(m);
  wayproof::bind_shortcut(m);
  wayproof::bind_dynamics(m);
  wayproof::bind_torques(m);
  wayproof::bind_loads(m);
}
