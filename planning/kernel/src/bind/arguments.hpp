// Arguments: what every binding asks of its arguments before the kernel, which checks no bounds itself, uses them.
//
// An index out of range raises IndexError, anything else that is wrong ValueError. Both name the argument, what is
// wrong and what is right.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "bind/bind.hpp"
#include "math/vec.hpp"
#include "model/scene.hpp"
#include "qp/ball_rows.hpp"

namespace wayproof {

using Doubles = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Integers = nb::ndarray<const std::int64_t, nb::c_contig, nb::device::cpu>;

// Most positions or velocities of a scene.
inline constexpr int max_coordinates = 1'000'000;

// Rows of an array with two dimensions.
struct Table {
  const double* data;
  std::size_t rows, columns;

  const double* row(std::size_t i) const { return data + i * columns; }
  std::span<const double> all() const { return {data, rows * columns}; }
};

// Raises ValueError.
[[noreturn]] void refuse(const std::string& message);

inline void require(bool claim, const char* message) {
  if (!claim) refuse(message);
}

// An array with one dimension, of any length or of a given one.
std::span<const double> row(const Doubles& array, const char* name);
std::span<const double> row(const Doubles& array, std::size_t count, const char* name);
std::span<const std::int64_t> row(const Integers& array, const char* name);

// An array with two dimensions, of any number of rows or of a given one.
Table table(const Doubles& array, std::size_t columns, const char* name);
Table table(const Doubles& array, std::size_t rows, std::size_t columns, const char* name);

// The same numbers, none of them infinite or NaN: comparisons with NaN would take anything for free.
std::span<const double> finite(std::span<const double> numbers, const char* name);
double finite(double number, const char* name);
// None of them NaN.
std::span<const double> ordered(std::span<const double> numbers, const char* name);
// Positive and finite.
double positive(double number, const char* name);

// An index from 0 to count - 1.
int index(std::int64_t value, std::size_t count, const char* name);
std::vector<int> indices(std::span<const std::int64_t> values, std::size_t count, const char* name);
// Starts of compressed sparse rows: from 0 on, none before the one before it, to the number of entries.
void require_starts(std::span<const std::int64_t> starts, std::size_t rows, std::size_t entries);
// Starts and columns of every ball of a program, values of its three components, one after another, and centers.
using Balls = std::tuple<Integers, Integers, Doubles, Doubles>;
BallRows balls_of(const Balls& given, std::size_t num_variables);
// An index of the scene's links, or -1 for the world.
int link_or_world(std::int64_t value, const Scene& scene, const char* name);

Vec3 vec(const Doubles& array, const char* name);
// From a row of R (9, row-major) and p (3).
Transform transform(std::span<const double> numbers);
Transform transform(const Doubles& array, const char* name);

// Whole joints of a scene's tree: the positions and the velocities of each, one joint after another.
Group group(const Scene& scene, const Integers& positions, const Integers& velocities, const Doubles& state);

// A scene that is about to be shared with an object that expects it to stay as it is.
std::shared_ptr<const Scene> immutable(const std::shared_ptr<Scene>& scene);

// The kernel of a name, or the best one if it is empty; `list` writes the kernels that this machine can run.
template <typename Kernel>
Kernel kernel_named(const std::string& name, int (*list)(Kernel*, int)) {
  Kernel all[4];
  const int count = list(all, 4);
  std::string names;
  for (int i = 0; i < count; ++i) {
    if (name.empty() || name == all[i].name) return all[i];
    names += std::string(i ? ", " : "") + all[i].name;
  }
  refuse("no kernel " + name + " runs on this machine, but " + names);
}

}  // namespace wayproof
