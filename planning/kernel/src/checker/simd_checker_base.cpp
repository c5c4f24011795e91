#define WIDTH 4
#define NAMESPACE batch_base
#include "checker/simd_checker.inc"
