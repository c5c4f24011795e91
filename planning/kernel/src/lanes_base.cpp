#define WIDTH 4
#define NAMESPACE lanes_base
#include "lanes.inc"
