#define WIDTH 8
#define NAMESPACE lanes_avx2
#include "checker/simd_checker.inc"
