#include "series/torque_series.hpp"

#include <algorithm>
#include <cstddef>

#include "math/aligned.hpp"

namespace wayproof {

namespace series_base {
extern const SeriesKernel kernel;
}
#if defined(__x86_64__)
namespace series_avx2 {
extern const SeriesKernel kernel;
}
namespace series_avx512 {
extern const SeriesKernel kernel;
}
#endif

int series_kernels(SeriesKernel* found, int most) {
  int count = 0;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (count < most && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    found[count++] = series_avx512::kernel;
  if (count < most && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    found[count++] = series_avx2::kernel;
#endif
  if (count < most) found[count++] = series_base::kernel;
  return count;
}

TorqueSeries::TorqueSeries(int num_positions, int num_velocities, const Vec3& gravity)
    : chain_{nullptr, 0, num_positions, num_velocities, {gravity.x, gravity.y, gravity.z}, 2} {}

void TorqueSeries::of(std::span<const SeriesSegment> segments, int terms, int order, const SeriesKernel& kernel,
                      double* taylor, double* errors) const {
  SeriesChain chain = chain_;
  chain.links = links_.data(), chain.num_links = num_links(), chain.order = order;
  const std::size_t width = static_cast<std::size_t>(kernel.width), nv = static_cast<std::size_t>(num_velocities());
  Aligned<double> work(static_cast<std::size_t>(kernel.work_size(chain, terms)));
  std::vector<double> found(width * torque_terms * nv), missed(width * nv);
  std::vector<SeriesSegment> lanes(width);
  for (std::size_t first = 0; first < segments.size(); first += width) {
    const std::size_t count = std::min(width, segments.size() - first);
    // Lanes without a segment of their own repeat the last one.
    for (std::size_t lane = 0; lane < width; ++lane) lanes[lane] = segments[first + std::min(lane, count - 1)];
    kernel.torques(chain, lanes.data(), terms, work.data(), found.data(), missed.data());
    std::copy_n(found.data(), count * torque_terms * nv, taylor + first * torque_terms * nv);
    std::copy_n(missed.data(), count * nv, errors + first * nv);
  }
}

}  // namespace wayproof
