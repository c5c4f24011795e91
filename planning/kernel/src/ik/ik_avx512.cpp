#define WIDTH 8
#define NAMESPACE ik_avx512
#include "ik/ik_simd.inc"
