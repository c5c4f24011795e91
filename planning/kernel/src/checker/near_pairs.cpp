#include "checker/near_pairs.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "model/gjk.hpp"

namespace wayproof {
namespace {

std::vector<Transform> poses_at(const Scene& scene, std::span<const double> full) {
  std::vector<Transform> X_WL(scene.tree.links.size()), X_WG(scene.geometries.size());
  scene.tree.place(full.data(), X_WL.data());
  for (std::size_t g = 0; g < X_WG.size(); ++g) X_WG[g] = scene.pose(static_cast<int>(g), X_WL.data());
  return X_WG;
}

}  // namespace

bool has_near_pair(const Scene& scene, std::span<const double> full, double reach) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  const std::vector<Transform> X_WG = poses_at(scene, full);
  return std::any_of(scene.pairs.begin(), scene.pairs.end(), [&](Pair pair) {
    const auto a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
    const Shape &of_a = scene.geometries[a].shape, &of_b = scene.geometries[b].shape;
    const double between = norm(X_WG[a] * of_a.center - X_WG[b] * of_b.center);
    if (between - of_a.radius - of_b.radius >= reach) return false;
    return separation(of_a, X_WG[a], of_b, X_WG[b], reach, -inf, {}).lower < reach;
  });
}

std::vector<std::int64_t> near_geometries(const Scene& scene, std::span<const double> full, int first, double reach) {
  const std::vector<Transform> X_WG = poses_at(scene, full);
  std::vector<Vec3> centers;
  centers.reserve(X_WG.size());
  for (std::size_t g = 0; g < X_WG.size(); ++g) centers.push_back(X_WG[g] * scene.geometries[g].shape.center);
  std::vector<char> is_near(X_WG.size(), 0);
  for (const Pair pair : scene.pairs) {
    const auto a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
    if (pair.b < first || pair.a >= first || is_near[b]) continue;
    const Vec3 between = centers[a] - centers[b];
    const double apart = scene.geometries[a].shape.radius + scene.geometries[b].shape.radius + reach;
    is_near[b] = apart >= 0 && dot(between, between) <= apart * apart;
  }
  std::vector<std::int64_t> found;
  for (std::size_t g = static_cast<std::size_t>(first); g < is_near.size(); ++g)
    if (is_near[g]) found.push_back(static_cast<std::int64_t>(g) - first);
  return found;
}

}  // namespace wayproof
