#define WIDTH 2
#define NAMESPACE ik_base
#include "ik_lanes.inc"
