#include "search/relax_path.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace wayproof {
namespace {

// One sweep over the inner waypoints, m of them; columns are the whole waypoint, then each coordinate.
class Sweep {
 public:
  Sweep(std::vector<double>& path, std::vector<double>& fractions, EdgeVerdicts& edges)
      : nq_(edges.nq),
        columns_(nq_ > 1 ? nq_ + 1 : 1),
        inner_(static_cast<int>(path.size()) / nq_ - 2),
        path_(path),
        fractions_(fractions),
        edges_(edges) {}

  int columns() const { return columns_; }

  // Whether any move was worth a check.
  bool run(const RelaxSettings& s) {
    propose();
    const double least = s.min_gain * path_length(path_, nq_);
    std::vector<int> rows, columns;
    std::vector<double> qs;
    for (int i = 0; i < inner_; ++i)
      for (int c = 0; c < columns_; ++c)
        if (gains_[at(i, c)] > least) {
          rows.push_back(i), columns.push_back(c);
          qs.insert(qs.end(), moved(i, c), moved(i, c) + nq_);
        }
    if (rows.empty()) return false;
    const std::vector<char> free = are_moves_free(rows, qs);
    std::vector<double> gains(gains_.size(), 0.0);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const std::size_t cell = at(rows[k], columns[k]);
      fractions_[cell] *= free[k] ? s.growth : s.shrinkage;
      if (free[k]) gains[cell] = gains_[cell];
    }
    for (int i = 0; i < inner_; ++i)
      for (int c = 0; c < columns_; ++c) {
        double& fraction = fractions_[at(i, c)];
        fraction = std::min(fraction, 1.0);
        if (c == 0) fraction = std::min(fraction, s.max_whole_fraction);
      }
    apply(gains);
    return true;
  }

 private:
  std::size_t at(int i, int c) const { return static_cast<std::size_t>(i) * columns_ + c; }
  const double* moved(int i, int c) const { return &qs_[at(i, c) * nq_]; }
  const double* step(int i, int c) const { return &steps_[at(i, c) * nq_]; }
  const double* point(int i) const { return &path_[static_cast<std::size_t>(i) * nq_]; }

  void propose() {
    const std::size_t cells = static_cast<std::size_t>(inner_) * columns_;
    steps_.assign(cells * nq_, 0.0), qs_.assign(cells * nq_, 0.0), gains_.assign(cells, 0.0);
    for (int i = 0; i < inner_; ++i) {
      const double *a = point(i), *v = point(i + 1), *b = point(i + 2);
      const double before = length(a, v, nq_), after = length(v, b, nq_);
      const double along = before / std::max(before + after, 1e-300);
      for (int c = 0; c < columns_; ++c) {
        double *d = &steps_[at(i, c) * nq_], *q = &qs_[at(i, c) * nq_];
        for (int j = 0; j < nq_; ++j) {
          const double to_chord = (a[j] + along * (b[j] - a[j])) - v[j];
          d[j] = (fractions_[at(i, c)] * (c == 0 || c == j + 1 ? 1.0 : 0.0)) * to_chord;
          q[j] = v[j] + d[j];
        }
        gains_[at(i, c)] = (before + after) - (length(a, q, nq_) + length(q, b, nq_));
      }
    }
  }

  // Whether the edges from each q to the neighbours of an inner waypoint are free.
  std::vector<char> are_moves_free(const std::vector<int>& rows, const std::vector<double>& qs) const {
    Edges edges;
    for (std::size_t k = 0; k < rows.size(); ++k) edges.add(point(rows[k]), &qs[k * nq_], nq_);
    for (std::size_t k = 0; k < rows.size(); ++k) edges.add(&qs[k * nq_], point(rows[k] + 2), nq_);
    std::vector<char> free = edges_.are_free(edges);
    for (std::size_t k = 0; k < rows.size(); ++k) free[k] = free[k] && free[rows.size() + k];
    free.resize(rows.size());
    return free;
  }

  // Makes the free moves with a gain: all together, or one waypoint at a time.
  void apply(const std::vector<double>& gains) {
    std::vector<int> rows;
    std::vector<double> together, single;
    for (int i = 0; i < inner_; ++i) {
      const double* own = &gains[at(i, 0)];
      const int best = static_cast<int>(std::max_element(own, own + columns_) - own);
      if (!(own[best] > 0)) continue;
      rows.push_back(i);
      single.insert(single.end(), moved(i, best), moved(i, best) + nq_);
      for (int j = 0; j < nq_; ++j) {
        const double whole = own[0] > 0 ? step(i, 0)[j] : 0.0;
        const double block = columns_ > 1 && own[j + 1] > 0 ? step(i, j + 1)[j] : 0.0;
        together.push_back(point(i + 1)[j] + (std::abs(whole) > std::abs(block) ? whole : block));
      }
    }
    if (rows.empty()) return;
    std::vector<double> next = path_;
    std::vector<char> changed(inner_ + 1, 0);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      std::copy_n(&together[k * nq_], nq_, &next[static_cast<std::size_t>(rows[k] + 1) * nq_]);
      changed[rows[k]] = changed[rows[k] + 1] = 1;
    }
    if (path_length(next, nq_) < path_length(path_, nq_)) {
      Edges edges;
      for (int i = 0; i <= inner_; ++i)
        if (changed[i])
          edges.add(&next[static_cast<std::size_t>(i) * nq_], &next[static_cast<std::size_t>(i + 1) * nq_], nq_);
      const std::vector<char> free = edges_.are_free(edges);
      if (std::all_of(free.begin(), free.end(), [](char f) { return f != 0; })) {
        path_ = std::move(next);
        return;
      }
    }
    apply_one_by_one(rows, together, single);
  }

  // Moves waypoints whose neighbours stay, those of largest gain first.
  void apply_one_by_one(const std::vector<int>& rows, std::vector<double>& qs, const std::vector<double>& single) {
    const std::vector<char> free = are_moves_free(rows, qs);
    std::vector<double> gains(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (!free[k]) std::copy_n(&single[k * nq_], nq_, &qs[k * nq_]);
      const double *a = point(rows[k]), *v = point(rows[k] + 1), *b = point(rows[k] + 2), *q = &qs[k * nq_];
      gains[k] = ((length(a, v, nq_) + length(v, b, nq_)) - length(a, q, nq_)) - length(q, b, nq_);
    }
    std::vector<int> order(rows.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int x, int y) { return gains[x] > gains[y]; });
    std::vector<char> is_moved(inner_ + 2, 0);
    for (int k : order) {
      const int here = rows[k] + 1;
      if (!(gains[k] > 0) || is_moved[here - 1] || is_moved[here] || is_moved[here + 1]) continue;
      std::copy_n(&qs[static_cast<std::size_t>(k) * nq_], nq_, &path_[static_cast<std::size_t>(here) * nq_]);
      is_moved[here] = 1;
    }
  }

  int nq_, columns_, inner_;
  std::vector<double>& path_;
  std::vector<double>& fractions_;  // of the way to the chord, [inner][columns]
  EdgeVerdicts& edges_;
  std::vector<double> steps_, qs_, gains_;
};

}  // namespace

std::vector<double> relax_path(std::span<const double> waypoints, const RelaxSettings& settings, EdgeVerdicts& edges,
                               const std::function<bool()>& is_over) {
  std::vector<double> path(waypoints.begin(), waypoints.end()), fractions;
  if (static_cast<int>(path.size()) < 3 * edges.nq) return path;
  Sweep sweep(path, fractions, edges);
  const std::size_t inner = path.size() / static_cast<std::size_t>(edges.nq) - 2;
  for (std::size_t i = 0; i < inner; ++i)
    for (int c = 0; c < sweep.columns(); ++c) fractions.push_back(c == 0 ? settings.first_whole_fraction : 1.0);
  for (int k = 0; k < settings.max_sweeps; ++k)
    if (is_over() || !sweep.run(settings)) break;
  return path;
}

}  // namespace wayproof
