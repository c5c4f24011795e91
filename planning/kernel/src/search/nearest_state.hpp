// NearestState: the nearest of a growing set of configurations, exactly, by a tree of boxes.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace wayproof {

class NearestState {
 public:
  explicit NearestState(int size) : size_(size) {}

  // Adds a configuration; its number is how many there were before.
  void add(std::span<const double> q);

  // The number of the configuration of least Euclidean distance, of several the first; there must be one.
  int nearest(std::span<const double> q) const;

  int count() const { return count_; }

 private:
  // A box around the configurations below it: two more nodes, or a bucket of configurations.
  struct Node {
    int axis = -1;  // of the split; -1 for a bucket
    double split = 0;
    int children = -1;            // the first of two, one after the other
    std::vector<double> columns;  // of a bucket: [size][capacity]
    std::vector<int> numbers;
    int capacity = 0;
  };
  struct Best {
    double square;
    int number;
  };

  int make_bucket(int capacity);
  void put(int node, const double* q, int number);
  void divide(int node);
  double square_to_box(int node, const double* q) const;
  void search(int node, const double* q, Best& best) const;

  int size_, count_ = 0;
  std::vector<Node> nodes_;
  std::vector<double> boxes_;  // lower and upper corner of every node, [node][2][size]
};

}  // namespace wayproof
