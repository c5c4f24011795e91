// GJK: lower and upper bound on the signed distance of two convex shapes (Gilbert, Johnson, Keerthi).
//
// The distance of A and B is that of the origin from the set of all a - b. Every step takes the
// point v of a simplex in that set nearest to the origin: |v| is an upper bound. The point w of the
// set that lies farthest along -v gives the slab v . w / |v|, a lower bound, and joins the simplex
// ("A fast procedure for computing the distance between complex objects in three-dimensional
// space", 1988; van den Bergen 1999 for the two bounds). It works on the cores; balls are taken
// off. Both bounds hold at every step, so an early end costs sharpness, never truth.
#pragma once

#include "model/shape.hpp"

namespace wayproof {

struct Separation {
  double lower;    // a slab this wide separates the shapes; negative if there is none
  double upper;    // two points of the shapes are this near; negative if the shapes certainly overlap so deeply
  Vec3 direction;  // unit normal of the slab, from B to A
};

// Bounds the distance of A and B until the lower bound reaches `enough`, the upper one falls below `few`, or both agree
// within `close`. `guess` points from B to A, or is zero.
Separation separation(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB, double enough,
                      double few, Vec3 guess, double close = 1e-10);

// Points of the cores of A and B, in A and in B, whose differences are the simplex at the end of a search. Where A and
// B have moved a little they are nearly those of the next one, which ends after a step or two if it begins with them.
struct Features {
  Vec3 on_a[3], on_b[3];
  int size = 0;
  Vec3 direction;  // of the slab; zero before the first search
};

struct ClosestPoints {
  Separation separation;
  // A point on the line through the nearest points of A and B, balls aside; undefined if the shapes overlap, or if the
  // search ended early.
  Vec3 p_W;
};

// The same up to a distance of `enough`, with the nearest points. Begins with the features of an earlier search, if
// there are any, and replaces them by its own.
ClosestPoints closest_points(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB,
                             double enough, Features& features);

// The slab between A and B across a unit vector n, from B to A: a lower bound on their distance.
double slab(const Shape& a, const Transform& X_WA, const Shape& b, const Transform& X_WB, Vec3 n);

}  // namespace wayproof
