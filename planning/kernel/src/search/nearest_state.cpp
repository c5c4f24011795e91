#include "search/nearest_state.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "math/multiversion.hpp"

namespace wayproof {
namespace {

constexpr int bucket_size = 32;

// Squares of the distances of a bucket's configurations, each added in the order of the coordinates.
WAYPROOF_MULTIVERSION
void squares_of(const double* columns, int size, int capacity, const double* q, double* squares) {
  for (int k = 0; k < capacity; ++k) squares[k] = 0;
  for (int v = 0; v < size; ++v)
    for (int k = 0; k < capacity; ++k) {
      const double d = columns[v * capacity + k] - q[v];
      squares[k] += d * d;
    }
}

}  // namespace

int NearestState::make_bucket(int capacity) {
  Node node;
  node.capacity = capacity;
  node.columns.assign(static_cast<std::size_t>(size_) * capacity, 0.0);
  nodes_.push_back(std::move(node));
  boxes_.insert(boxes_.end(), size_, std::numeric_limits<double>::infinity());
  boxes_.insert(boxes_.end(), size_, -std::numeric_limits<double>::infinity());
  return static_cast<int>(nodes_.size()) - 1;
}

void NearestState::put(int index, const double* q, int number) {
  Node& node = nodes_[index];
  const int k = static_cast<int>(node.numbers.size());
  for (int v = 0; v < size_; ++v) node.columns[static_cast<std::size_t>(v) * node.capacity + k] = q[v];
  node.numbers.push_back(number);
  double* box = &boxes_[static_cast<std::size_t>(2 * index) * size_];
  for (int v = 0; v < size_; ++v) box[v] = std::min(box[v], q[v]), box[size_ + v] = std::max(box[size_ + v], q[v]);
}

// A full bucket becomes two, split at the median of its widest coordinate; one of equal configurations grows.
void NearestState::divide(int index) {
  const Node full = nodes_[index];
  const double* box = &boxes_[static_cast<std::size_t>(2 * index) * size_];
  int axis = 0;
  for (int v = 1; v < size_; ++v)
    if (box[size_ + v] - box[v] > box[size_ + axis] - box[axis]) axis = v;
  const bool is_point = !(box[size_ + axis] > box[axis]);
  const double* column = &full.columns[static_cast<std::size_t>(axis) * full.capacity];
  std::vector<double> sorted(column, column + full.numbers.size());
  std::sort(sorted.begin(), sorted.end());
  // Smaller coordinates than the split go below it; the greatest is never below, the least always.
  const double split = *std::upper_bound(sorted.begin(), sorted.end() - 1, sorted[(sorted.size() - 1) / 2]);
  std::vector<double> q(size_);
  const auto state = [&](std::size_t k) {
    for (int v = 0; v < size_; ++v) q[v] = full.columns[static_cast<std::size_t>(v) * full.capacity + k];
    return q.data();
  };
  if (is_point) {
    Node& node = nodes_[index];
    node.capacity = 2 * full.capacity;
    node.columns.assign(static_cast<std::size_t>(size_) * node.capacity, 0.0);
    node.numbers.clear();
    for (std::size_t k = 0; k < full.numbers.size(); ++k) put(index, state(k), full.numbers[k]);
    return;
  }
  const int low = make_bucket(full.capacity), high = make_bucket(full.capacity);
  nodes_[index] = Node{axis, split, low, {}, {}, 0};
  for (std::size_t k = 0; k < full.numbers.size(); ++k) {
    const double* at = state(k);
    put(at[axis] < split ? low : high, at, full.numbers[k]);
  }
}

void NearestState::add(std::span<const double> q) {
  if (nodes_.empty()) make_bucket(bucket_size);
  int index = 0;
  for (;;) {
    Node& node = nodes_[index];
    if (node.axis < 0 && static_cast<int>(node.numbers.size()) < node.capacity) break;
    if (node.axis < 0) {
      divide(index);
      continue;
    }
    double* box = &boxes_[static_cast<std::size_t>(2 * index) * size_];
    for (int v = 0; v < size_; ++v) box[v] = std::min(box[v], q[v]), box[size_ + v] = std::max(box[size_ + v], q[v]);
    index = node.children + (q[node.axis] < node.split ? 0 : 1);
  }
  put(index, q.data(), count_++);
}

// Rounded as the squares of distances are, so it is never above that of a configuration in the box.
double NearestState::square_to_box(int index, const double* q) const {
  const double* box = &boxes_[static_cast<std::size_t>(2 * index) * size_];
  double square = 0;
  for (int v = 0; v < size_; ++v) {
    const double d = std::max({box[v] - q[v], q[v] - box[size_ + v], 0.0});
    square += d * d;
  }
  return square;
}

void NearestState::search(int index, const double* q, Best& best) const {
  const Node& node = nodes_[index];
  if (node.axis >= 0) {
    const double squares[2] = {square_to_box(node.children, q), square_to_box(node.children + 1, q)};
    const int first = squares[1] < squares[0];
    for (const int side : {first, 1 - first})
      if (squares[side] <= best.square) search(node.children + side, q, best);
    return;
  }
  double buffer[bucket_size];
  std::vector<double> more;
  double* squares = buffer;
  if (node.capacity > bucket_size) more.resize(node.capacity), squares = more.data();
  squares_of(node.columns.data(), size_, node.capacity, q, squares);
  for (std::size_t k = 0; k < node.numbers.size(); ++k)
    if (squares[k] < best.square || (squares[k] == best.square && node.numbers[k] < best.number))
      best = {squares[k], node.numbers[k]};
}

int NearestState::nearest(std::span<const double> q) const {
  Best best{std::numeric_limits<double>::infinity(), count_};
  search(0, q.data(), best);
  return best.number;
}

}  // namespace wayproof
