#include "checker/simd_checker.hpp"

namespace wayproof {

#define WAYPROOF_DECLARE(name)                                                                    \
  namespace name {                                                                                \
  void judge(const LaneModel&, const float*, unsigned, float, float*, LaneVerdict&);              \
  }
WAYPROOF_DECLARE(lanes_base)
#if defined(__x86_64__)
WAYPROOF_DECLARE(lanes_avx2)
WAYPROOF_DECLARE(lanes_avx512)
#endif

int lane_kernels(LaneKernel* found, int most) {
  int count = 0;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (count < most && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    found[count++] = {"avx512", 16, lanes_avx512::judge};
  if (count < most && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    found[count++] = {"avx2", 8, lanes_avx2::judge};
#endif
  if (count < most) found[count++] = {"base", 4, lanes_base::judge};
  return count;
}

LaneKernel best_lane_kernel() {
  LaneKernel best;
  lane_kernels(&best, 1);
  return best;
}

}  // namespace wayproof
