// Polyline: points in order, and the few of them that are near all others.
#pragma once

#include <vector>

namespace wayproof {

// The square of a point's distance from the chord of two others, whose difference to it goes to `away`.
double distance_from_chord(const double* x, const double* a, const double* b, int size, double* away);

// Keeps of a polyline, [count][size], the few rows that bring every point of it within a residual per
// coordinate of the polyline of those; the residual is added to what is there.
void simplify(const std::vector<double>& points, int count, int size, std::vector<double>& rows,
              double* residual, int most_rows = 6);

}  // namespace wayproof
