// Near pairs: whether any pair of a scene, moved or not, is near at one configuration.
#pragma once

#include <span>

#include "model/scene.hpp"

namespace wayproof {

// Whether any pair may be nearer than `reach` at a full configuration: false only if none is.
bool has_near_pair(const Scene& scene, std::span<const double> full, double reach);

}  // namespace wayproof
