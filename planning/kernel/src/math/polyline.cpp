#include "math/polyline.hpp"

#include <algorithm>
#include <cmath>

namespace wayproof {
namespace {

// Another row is added while it brings points nearer than this share of the polyline's length.
constexpr double fine = 0.02;

}  // namespace

double distance_from_chord(const double* x, const double* a, const double* b, int size, double* away) {
  double along = 0, square = 0, total = 0;
  for (int v = 0; v < size; ++v) along += (x[v] - a[v]) * (b[v] - a[v]), square += (b[v] - a[v]) * (b[v] - a[v]);
  const double s = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0;
  for (int v = 0; v < size; ++v) away[v] = x[v] - (a[v] + s * (b[v] - a[v])), total += away[v] * away[v];
  return total;
}

// Ramer-Douglas-Peucker: the farthest point becomes a row.
void simplify(const std::vector<double>& points, int count, int size, std::vector<double>& rows, double* residual,
              int most_rows) {
  const auto point = [&](int i) { return &points[static_cast<std::size_t>(i) * size]; };
  struct Chord {
    int first, last, worst;
    double square;
  };
  std::vector<double> away(size);
  const auto chord = [&](int first, int last) {
    Chord c{first, last, -1, 0};
    for (int i = first + 1; i < last; ++i)
      if (const double square = distance_from_chord(point(i), point(first), point(last), size, away.data());
          square > c.square)
        c.square = square, c.worst = i;
    return c;
  };
  std::vector<Chord> chords{chord(0, count - 1)};
  double length = distance_from_chord(point(count - 1), point(0), point(0), size, away.data());
  while (static_cast<int>(chords.size()) + 1 < most_rows) {
    const auto worst = std::max_element(chords.begin(), chords.end(),
                                        [](const Chord& a, const Chord& b) { return a.square < b.square; });
    length = std::max(length, worst->square);
    if (worst->square <= fine * fine * length) break;
    const Chord c = *worst;
    *worst = chord(c.first, c.worst);
    chords.push_back(chord(c.worst, c.last));
  }
  rows.assign(point(0), point(0) + size);
  std::vector<double> added(size, 0.0);
  for (const Chord& c : chords) {
    rows.insert(rows.end(), point(c.last), point(c.last) + size);
    for (int i = c.first + 1; i < c.last; ++i) {
      distance_from_chord(point(i), point(c.first), point(c.last), size, away.data());
      for (int v = 0; v < size; ++v) added[v] = std::max(added[v], std::abs(away[v]));
    }
  }
  for (int v = 0; v < size; ++v) residual[v] += added[v];
}

}  // namespace wayproof
