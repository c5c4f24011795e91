// Penetration depth of two convex shapes, for reports only: no verdict depends on it.
#pragma once

#include "model/shape.hpp"

namespace wayproof {

struct Overlap {
  double width;  // of the slab: negative if the shapes overlap
  Vec3 n;        // its unit normal, from B to A
};

// The widest (least negative) slab of a local search: the signed distance of shapes that overlap is that of the best
// slab, so it is this or a little more.
Overlap overlap(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB);

}  // namespace wayproof
