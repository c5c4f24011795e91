#define WIDTH 16
#define NAMESPACE batch_avx512
#include "checker/simd_checker.inc"
