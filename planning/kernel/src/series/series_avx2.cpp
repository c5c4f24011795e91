#define WIDTH 4
#define NAMESPACE series_avx2
#define KERNEL_NAME "avx2"
#include "series/series_simd.inc"
