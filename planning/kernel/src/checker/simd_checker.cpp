#include "checker/simd_checker.hpp"

namespace wayproof {

#define WAYPROOF_DECLARE(name)                                                         \
  namespace name {                                                                     \
  void check(const BatchModel&, const float*, unsigned, float, float*, BatchVerdict&); \
  }
WAYPROOF_DECLARE(batch_base)
#if defined(__x86_64__)
WAYPROOF_DECLARE(batch_avx2)
WAYPROOF_DECLARE(batch_avx512)
#endif

int batch_kernels(BatchKernel* found, int most) {
  int count = 0;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (count < most && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    found[count++] = {"avx512", 16, batch_avx512::check};
  if (count < most && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    found[count++] = {"avx2", 8, batch_avx2::check};
#endif
  if (count < most) found[count++] = {"base", 4, batch_base::check};
  return count;
}

}  // namespace wayproof
