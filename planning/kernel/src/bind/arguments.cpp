#include "bind/arguments.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace wayproof {

void refuse(const std::string& message) { throw std::invalid_argument(message); }

namespace {

std::string text(double number) {
  std::string digits(32, '\0');
  digits.resize(static_cast<std::size_t>(std::snprintf(digits.data(), digits.size(), "%g", number)));
  return digits;
}

template <typename Array>
std::string shape_of(const Array& array) {
  std::string shape = "(";
  for (std::size_t i = 0; i < array.ndim(); ++i) shape += (i ? ", " : "") + std::to_string(array.shape(i));
  return shape + (array.ndim() == 1 ? ",)" : ")");
}

template <typename Array>
[[noreturn]] void refuse_shape(const Array& array, const std::string& right, const char* name) {
  refuse(std::string(name) + " has shape " + shape_of(array) + ", not " + right);
}

void require_whole(std::span<const int> of_group, std::size_t from, int first, int count, const char* name) {
  for (int k = 0; k < count; ++k) {
    const std::size_t i = from + static_cast<std::size_t>(k);
    if (i < of_group.size() && of_group[i] == first + k) continue;
    const std::string found = i < of_group.size() ? std::to_string(of_group[i]) : "missing";
    refuse("a group has whole joints: " + std::string(name) + "[" + std::to_string(i) + "] is " + found + ", not " +
           std::to_string(first + k));
  }
}

void require_whole_joints(const Tree& tree, std::span<const int> positions, std::span<const int> velocities) {
  std::vector<char> taken(tree.links.size(), 0);
  std::size_t q = 0, v = 0;
  while (q < positions.size()) {
    const auto link = std::find_if(tree.links.begin(), tree.links.end(), [&](const Link& l) {
      return l.kind != JointKind::fixed && l.position == positions[q];
    });
    const std::string here = "positions[" + std::to_string(q) + "], " + std::to_string(positions[q]) + ",";
    if (link == tree.links.end()) refuse(here + " is not the first position of a joint");
    char& is_taken = taken[static_cast<std::size_t>(link - tree.links.begin())];
    if (is_taken) refuse(here + " is in the group already");
    is_taken = 1;
    require_whole(positions, q, link->position, num_positions(link->kind), "positions");
    require_whole(velocities, v, link->velocity, num_velocities(link->kind), "velocities");
    q += static_cast<std::size_t>(num_positions(link->kind));
    v += static_cast<std::size_t>(num_velocities(link->kind));
  }
  if (v != velocities.size())
    refuse("velocities has " + std::to_string(velocities.size()) + " numbers, not " + std::to_string(v) +
           " as the group's joints");
}

}  // namespace

std::span<const double> row(const Doubles& array, const char* name) {
  if (array.ndim() != 1) refuse_shape(array, "(n,)", name);
  return {array.data(), array.size()};
}

std::span<const double> row(const Doubles& array, std::size_t count, const char* name) {
  if (array.ndim() != 1 || array.size() != count) refuse_shape(array, "(" + std::to_string(count) + ",)", name);
  return {array.data(), count};
}

std::span<const std::int64_t> row(const Integers& array, const char* name) {
  if (array.ndim() != 1) refuse_shape(array, "(n,)", name);
  return {array.data(), array.size()};
}

Table table(const Doubles& array, std::size_t columns, const char* name) {
  if (array.ndim() != 2 || array.shape(1) != columns) refuse_shape(array, "(n, " + std::to_string(columns) + ")", name);
  return {array.data(), array.shape(0), columns};
}

Table table(const Doubles& array, std::size_t rows, std::size_t columns, const char* name) {
  if (array.ndim() != 2 || array.shape(0) != rows || array.shape(1) != columns)
    refuse_shape(array, "(" + std::to_string(rows) + ", " + std::to_string(columns) + ")", name);
  return {array.data(), rows, columns};
}

std::span<const double> finite(std::span<const double> numbers, const char* name) {
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!std::isfinite(numbers[i]))
      refuse(std::string(name) + " has " + text(numbers[i]) + " at " + std::to_string(i) + ", not a finite number");
  return numbers;
}

double finite(double number, const char* name) {
  if (!std::isfinite(number)) refuse(std::string(name) + " is " + text(number) + ", not a finite number");
  return number;
}

std::span<const double> ordered(std::span<const double> numbers, const char* name) {
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (std::isnan(numbers[i])) refuse(std::string(name) + " has no number at " + std::to_string(i));
  return numbers;
}

double positive(double number, const char* name) {
  if (!(number > 0) || !std::isfinite(number))
    refuse(std::string(name) + " is " + text(number) + ", not a positive number");
  return number;
}

int index(std::int64_t value, std::size_t count, const char* name) {
  if (value >= 0 && static_cast<std::uint64_t>(value) < count) return static_cast<int>(value);
  const std::string right = count ? "from 0 to " + std::to_string(count - 1) : "of none";
  throw std::out_of_range(std::string(name) + " is " + std::to_string(value) + ", not an index " + right);
}

std::vector<int> indices(std::span<const std::int64_t> values, std::size_t count, const char* name) {
  std::vector<int> found;
  found.reserve(values.size());
  for (const std::int64_t value : values) found.push_back(index(value, count, name));
  return found;
}

void require_starts(std::span<const std::int64_t> starts, std::size_t rows, std::size_t entries) {
  if (starts.size() != rows + 1)
    refuse("starts has " + std::to_string(starts.size()) + " numbers, not " + std::to_string(rows + 1) +
           ": one more than there are rows");
  if (!(starts.front() == 0 && starts.back() == static_cast<std::int64_t>(entries) &&
        std::is_sorted(starts.begin(), starts.end())))
    refuse("starts do not rise from 0 to the number of entries, " + std::to_string(entries));
}

BallRows balls_of(const Balls& given, std::size_t num_variables) {
  const auto& [starts, columns, values, centers] = given;
  const auto begins = row(starts, "ball_starts"), of = row(columns, "ball_columns");
  if (begins.empty()) refuse("ball_starts is empty");
  const std::size_t count = begins.size() - 1;
  require_starts(begins, count, of.size());
  indices(of, num_variables, "ball_columns");
  const auto numbers = finite(row(values, 3 * of.size(), "ball_values"), "ball_values");
  const auto middles = finite(row(centers, 3 * count, "ball_centers"), "ball_centers");
  return {{begins.begin(), begins.end()},
          {of.begin(), of.end()},
          {numbers.begin(), numbers.end()},
          {middles.begin(), middles.end()}};
}

int link_or_world(std::int64_t value, const Scene& scene, const char* name) {
  return value == -1 ? -1 : index(value, scene.tree.links.size(), name);
}

Vec3 vec(const Doubles& array, const char* name) {
  const auto x = finite(row(array, 3, name), name);
  return {x[0], x[1], x[2]};
}

Transform transform(std::span<const double> numbers) {
  Transform t;
  std::copy_n(numbers.begin(), 9, t.R.m.begin());
  t.p = {numbers[9], numbers[10], numbers[11]};
  return t;
}

Transform transform(const Doubles& array, const char* name) { return transform(finite(row(array, 12, name), name)); }

Group group(const Scene& scene, const Integers& positions, const Integers& velocities, const Doubles& state) {
  const Tree& tree = scene.tree;
  const auto nq = static_cast<std::size_t>(tree.num_positions), nv = static_cast<std::size_t>(tree.num_velocities);
  const auto full = finite(row(state, nq, "state"), "state");
  auto at_q = indices(row(positions, "positions"), nq, "positions");
  auto at_v = indices(row(velocities, "velocities"), nv, "velocities");
  require_whole_joints(tree, at_q, at_v);
  return Group(tree, std::move(at_q), std::move(at_v), std::vector<double>(full.begin(), full.end()));
}

std::shared_ptr<const Scene> immutable(const std::shared_ptr<Scene>& scene) {
  scene->is_immutable = true;
  return scene;
}

}  // namespace wayproof
