#define WIDTH 4
#define NAMESPACE lanes_base
#include "checker/simd_checker.inc"
