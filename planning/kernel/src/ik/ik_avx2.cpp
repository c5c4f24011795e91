#define WIDTH 4
#define NAMESPACE ik_avx2
#include "ik/ik_simd.inc"
