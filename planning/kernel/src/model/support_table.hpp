// SupportTable: the farthest vertex of a polytope along a direction, for polytopes of many vertices.
//
// Directions are divided into the cells of a cube map, and every cell has those vertices that may be the farthest along
// one of its directions: a vertex is left out if another one is farther along all four corners of the cell, and so, a
// direction being a positive sum of these, along all of the cell. What is left out is nearer by more than rounding: the
// answer is that of comparing all vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.hpp"

namespace wayproof {

class SupportTable {
 public:
  // At least one vertex.
  explicit SupportTable(const std::vector<Vec3>& vertices);

  // The vertex that lies farthest along n.
  Vec3 farthest(Vec3 n) const;

 private:
  // The vertices of cells in batches of eight, the last one repeated: eight x, eight y, eight z.
  struct Batches {
    std::uint32_t begin = 0, count = 0;
  };

  void divide(const std::vector<Vec3>& vertices, std::size_t face, std::size_t row, std::size_t column,
              std::size_t width, double margin);

  std::vector<Batches> cells_;  // [face][row][column]
  std::vector<double> numbers_;
};

}  // namespace wayproof
