#include "path/box_visits.hpp"

#include <algorithm>
#include <cmath>

namespace wayproof {
namespace {

enum class Place { outside, inside, unsure };

class Search {
 public:
  Search(std::size_t terms, std::span<const double> half, BoxVisits& found)
      : terms_(terms), half_(half), found_(found) {}

  // `rest`: how many times the part may be halved.
  void visit(std::int64_t piece, double low, double high, const std::vector<double>& points, int rest) {
    const Place place = place_of(points);
    if (place == Place::outside) return;
    if (place == Place::inside || rest == 0) {
      found_.pieces.push_back(piece), found_.low.push_back(low), found_.high.push_back(high);
      return;
    }
    const double middle = (low + high) / 2;
    std::vector<double> before = points, after = points;
    // de Casteljau's halves.
    for (std::size_t round = 1; round < terms_; ++round)
      for (std::size_t k = terms_ - 1; k >= round; --k)
        for (std::size_t x = 0; x < 3; ++x) before[3 * k + x] = (before[3 * k + x] + before[3 * (k - 1) + x]) / 2;
    for (std::size_t round = 1; round < terms_; ++round)
      for (std::size_t k = 0; k + round < terms_; ++k)
        for (std::size_t x = 0; x < 3; ++x) after[3 * k + x] = (after[3 * k + x] + after[3 * (k + 1) + x]) / 2;
    visit(piece, low, middle, before, rest - 1);
    visit(piece, middle, high, after, rest - 1);
  }

 private:
  // If all coefficients are beyond a face, so is the path; if all are in the box, so is it.
  Place place_of(const std::vector<double>& points) const {
    bool inside = true;
    for (std::size_t x = 0; x < 3; ++x) {
      bool above = true, below = true;
      for (std::size_t k = 0; k < terms_; ++k) {
        const double value = points[3 * k + x];
        above = above && value > half_[x], below = below && value < -half_[x];
        inside = inside && std::abs(value) <= half_[x];
      }
      if (above || below) return Place::outside;
    }
    return inside ? Place::inside : Place::unsure;
  }

  std::size_t terms_;
  std::span<const double> half_;
  BoxVisits& found_;
};

}  // namespace

BoxVisits box_visits(std::span<const double> breaks, std::span<const double> points, std::size_t terms,
                     std::span<const double> half, int halvings) {
  BoxVisits found;
  Search search(terms, half, found);
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const auto piece = points.subspan(i * terms * 3, terms * 3);
    search.visit(static_cast<std::int64_t>(i), breaks[i], breaks[i + 1], {piece.begin(), piece.end()}, halvings);
  }
  return found;
}

}  // namespace wayproof
