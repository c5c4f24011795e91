#define WIDTH 2
#define NAMESPACE ik_base
#include "ik/ik_simd.inc"
