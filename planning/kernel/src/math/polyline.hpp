// Polyline: points in order, and its simplification to few of them.
#pragma once

#include <vector>

namespace wayproof {

// The square of a point's distance from the chord of two others, whose difference to it goes to `away`.
double distance_from_chord(const double* x, const double* a, const double* b, int size, double* away);

// Simplifies a polyline, [count][size], to few rows, such that every point of it is within a residual per coordinate of
// their polyline; the residual is added to the given one.
void simplify(const std::vector<double>& points, int count, int size, std::vector<double>& rows, double* residual,
              int most_rows = 6);

}  // namespace wayproof
