#include "checker/near_pairs.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "model/gjk.hpp"

namespace wayproof {

bool has_near_pair(const Scene& scene, std::span<const double> full, double reach) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  std::vector<Transform> X_WL(scene.tree.links.size()), X_WG(scene.geometries.size());
  scene.tree.place(full.data(), X_WL.data());
  for (std::size_t g = 0; g < X_WG.size(); ++g) X_WG[g] = scene.pose(static_cast<int>(g), X_WL.data());
  return std::any_of(scene.pairs.begin(), scene.pairs.end(), [&](Pair pair) {
    const auto a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
    const Shape &of_a = scene.geometries[a].shape, &of_b = scene.geometries[b].shape;
    const double between = norm(X_WG[a] * of_a.center - X_WG[b] * of_b.center);
    if (between - of_a.radius - of_b.radius >= reach) return false;
    return separation(of_a, X_WG[a], of_b, X_WG[b], reach, -inf, {}).lower < reach;
  });
}

}  // namespace wayproof
