// Balls of a program as numpy arrays.
#pragma once

#include <tuple>

#include "bind/arguments.hpp"
#include "qp/ball_rows.hpp"

namespace wayproof {

// Starts and columns of every ball, values of its three components, one after another, and centers [3 balls].
using Balls = std::tuple<Integers, Integers, Doubles, Doubles>;

inline BallRows balls_of(const Balls& given, std::size_t num_variables) {
  const auto& [starts, columns, values, centers] = given;
  const auto begins = row(starts, "ball_starts"), of = row(columns, "ball_columns");
  if (begins.empty()) refuse("ball_starts is empty");
  const std::size_t count = begins.size() - 1;
  require_starts(begins, count, of.size());
  indices(of, num_variables, "ball_columns");
  const auto numbers = finite(row(values, 3 * of.size(), "ball_values"), "ball_values");
  const auto middles = finite(row(centers, 3 * count, "centers"), "centers");
  return {{begins.begin(), begins.end()},
          {of.begin(), of.end()},
          {numbers.begin(), numbers.end()},
          {middles.begin(), middles.end()}};
}

}  // namespace wayproof
