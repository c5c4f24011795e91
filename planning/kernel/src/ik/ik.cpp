#include "ik/ik.hpp"

#include "ik/ik_model.hpp"

namespace wayproof {

#define WAYPROOF_DECLARE(name)           \
  namespace name {                       \
  int64_t solve(const IkTask&, double*); \
  }
WAYPROOF_DECLARE(ik_base)
#if defined(__x86_64__)
WAYPROOF_DECLARE(ik_avx2)
WAYPROOF_DECLARE(ik_avx512)
#endif

namespace {

void write(const Transform& X, double* R, double* p) {
  for (int i = 0; i < 9; ++i) R[i] = X.R.m[i];
  for (int i = 0; i < 3; ++i) p[i] = X.p[i];
}

}  // namespace

IkStorage::IkStorage(const Chain& chain, std::span<const double> lower, std::span<const double> upper) : model{} {
  for (const ChainJoint& from : chain.joints) {
    IkJoint to{};
    to.kind = from.kind;
    write(from.X_BF, to.R, to.p);
    for (int k = 0; k < max_joint_positions; ++k) {
      to.source[k] = from.coordinates[k].source;
      to.multiplier[k] = from.coordinates[k].multiplier;
      to.offset[k] = from.coordinates[k].offset;
    }
    for (int k = 0; k < max_joint_velocities; ++k) {
      to.column[k] = from.rates[k].column;
      to.factor[k] = from.rates[k].factor;
    }
    joints.push_back(to);
  }
  for (const FlatCoordinate& c : chain.flat)
    flat.push_back({c.position, c.velocity, c.turns, lower[c.position], upper[c.position]});
  for (const QuaternionCoordinate& c : chain.quaternions) quaternions.push_back({c.position, c.velocity});
  write(chain.X_MT, model.R_MT, model.p_MT);
  model.num_joints = static_cast<int>(joints.size());
  model.num_flat = static_cast<int>(flat.size());
  model.num_quaternions = static_cast<int>(quaternions.size());
  model.num_positions = chain.num_positions;
  model.num_velocities = chain.num_velocities;
}

int ik_kernels(IkKernel* found, int most) {
  int count = 0;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (count < most && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    found[count++] = {"avx512", 8, ik_avx512::solve};
  if (count < most && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    found[count++] = {"avx2", 4, ik_avx2::solve};
#endif
  if (count < most) found[count++] = {"base", 2, ik_base::solve};
  return count;
}

}  // namespace wayproof
