// Near pairs: whether any pair of a scene, moved or not, is near at one configuration, and which geometries may be.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/scene.hpp"

namespace wayproof {

// Whether any pair may be nearer than `reach` at a full configuration: false only if none is.
bool has_near_pair(const Scene& scene, std::span<const double> full, double reach);

// Geometries from the number `first` on whose bounding ball is within `reach` of that of a geometry before them, with
// which they are a pair; in order, counted from `first`.
std::vector<std::int64_t> near_geometries(const Scene& scene, std::span<const double> full, int first, double reach);

}  // namespace wayproof
