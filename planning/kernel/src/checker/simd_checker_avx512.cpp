#define WIDTH 16
#define NAMESPACE lanes_avx512
#include "checker/simd_checker.inc"
