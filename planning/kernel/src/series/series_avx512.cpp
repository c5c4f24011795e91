#define WIDTH 8
#define NAMESPACE series_avx512
#define KERNEL_NAME "avx512"
#include "series/series_simd.inc"
