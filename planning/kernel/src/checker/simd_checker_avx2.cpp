#define WIDTH 8
#define NAMESPACE batch_avx2
#include "checker/simd_checker.inc"
