#define WIDTH 2
#define NAMESPACE series_base
#define KERNEL_NAME "base"
#include "series/series_simd.inc"
