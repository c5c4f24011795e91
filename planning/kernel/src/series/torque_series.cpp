#include "series/torque_series.hpp"

#include <algorithm>
#include <cstddef>

#include "math/aligned.hpp"

namespace wayproof {
namespace {

// Calls `run` with `width` segments, the first's index, and the number that are not repeated: lanes without a segment
// of their own repeat the last one.
template <typename Run>
void for_lanes(std::span<const SeriesSegment> segments, std::size_t width, Run run) {
  std::vector<SeriesSegment> lanes(width);
  for (std::size_t first = 0; first < segments.size(); first += width) {
    const std::size_t count = std::min(width, segments.size() - first);
    for (std::size_t lane = 0; lane < width; ++lane) lanes[lane] = segments[first + std::min(lane, count - 1)];
    run(lanes.data(), first, count);
  }
}

}  // namespace

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
  const SeriesChain chain = chain_of(order);
  const std::size_t width = static_cast<std::size_t>(kernel.width), nv = static_cast<std::size_t>(num_velocities());
  Aligned<double> work(static_cast<std::size_t>(kernel.work_size(chain, terms)));
  std::vector<double> found(width * torque_terms * nv), missed(width * nv);
  for_lanes(segments, width, [&](const SeriesSegment* lanes, std::size_t first, std::size_t count) {
    kernel.torques(chain, lanes, terms, work.data(), found.data(), missed.data());
    std::copy_n(found.data(), count * torque_terms * nv, taylor + first * torque_terms * nv);
    std::copy_n(missed.data(), count * nv, errors + first * nv);
  });
}

void TorqueSeries::points(std::span<const SeriesSegment> segments, int terms, const Vec3& point,
                          const SeriesKernel& kernel, double* found) const {
  constexpr std::size_t size = 3 * point_terms;
  const SeriesChain chain = chain_of(2);
  const double at[3] = {point.x, point.y, point.z};
  const std::size_t width = static_cast<std::size_t>(kernel.width);
  Aligned<double> work(static_cast<std::size_t>(kernel.work_size(chain, terms)));
  std::vector<double> states(width * size);
  for_lanes(segments, width, [&](const SeriesSegment* lanes, std::size_t first, std::size_t count) {
    kernel.points(chain, lanes, terms, at, work.data(), states.data());
    std::copy_n(states.data(), count * size, found + first * size);
  });
}

SeriesChain TorqueSeries::chain_of(int order) const {
  SeriesChain chain = chain_;
  chain.links = links_.data(), chain.num_links = num_links(), chain.order = order;
  return chain;
}

}  // namespace wayproof
