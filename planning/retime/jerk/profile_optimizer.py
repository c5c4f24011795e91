"""Profile optimizer: faster jerk-limited profiles by an interior-point method.

A profile passes fixed parameters of the path; the durations h_k of its phases are the variables. At
both ends of every phase and at two points within, the speed v, the acceleration a and the jerk j in
the path parameter make

    q' = r' v,   q'' = r' a + r'' v^2,   q''' = r' j + 3 r'' v a + r''' v^3

(the chain rule), which must stay within their limits. Newton's method with a logarithmic barrier
minimizes the sum of all h_k (Boyd and Vandenberghe, "Convex optimization", chapter 11; the problem
is not convex, and the curvature of the limits is left out). The path's derivatives are those where
a round begins: in the second one the points have hardly moved. Between them limits are not imposed:
the peaks there are bounded afterwards, and the whole profile is slowed by the excess.

The native kernel does the same, with the accelerations between phases as further variables, which
makes the system of a Newton step banded (`planning/kernel/src/timing`).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline, derivative
from planning.domain.request.deadline import NO_DEADLINE, Deadline
from planning.domain.robot.joints import JointLimits
from planning.kernel.native import native
from planning.retime.block_peaks import block_peaks
from planning.retime.compose import compose
from planning.retime.jerk.timing_spline import TimingSpline
from planning.retime.limit_utilization import RATES
from planning.retime.profile import SpeedProfile
from planning.retime.smooth_pieces import evaluate_polynomials

# Largest number of pieces of a path: with more a step would take too long.
_MAX_PIECES = 64
# Number of phases of equal duration; those that begin at breaks of the path are added.
_NUM_PHASES = 48
# Shortest phase relative to the others; shorter ones are left out, except at breaks.
_MIN_PHASE_SHARE = 0.4
# Points of every phase at which limits are imposed, as shares of its duration.
_POINTS = np.linspace(0.0, 1.0, 4)
# Of every round the number of steps, the largest utilization of limits where it begins, and the
# barrier's weight there, relative to a phase's duration.
_ROUNDS = (8, 0.97, 0.1), (4, 0.995, 5e-4)
# The factor of the weight per step.
_BARRIER_FACTOR = 0.5
# Largest relative change of a phase's duration in a step, approximately.
_MAX_STEP = 0.3
_ARMIJO_FACTOR, _MIN_STEP_LENGTH = 0.01, 1e-3


def can_optimize(smooth_piece: JointSpline, limits: JointLimits) -> bool:
    """Return whether a path's profiles can be optimized.

    With floating joints, blocks of several coordinates, or many pieces, they cannot.
    """
    is_scalar = smooth_piece.manifold.is_flat and all(len(block) == 1 for block in limits.blocks)
    return is_scalar and smooth_piece.num_pieces <= _MAX_PIECES


def optimize_profile(
    smooth_piece: JointSpline,
    profile: SpeedProfile,
    limits: JointLimits,
    deadline: Deadline = NO_DEADLINE,
    *,
    use_kernel: bool = True,
) -> SpeedProfile:
    """Return a faster profile within the limits, or the given one.

    Args:
        smooth_piece: Smooth piece of the path to which the profile belongs.
        profile: Profile from rest to rest.
        limits: Limits of velocity, acceleration and jerk.
        deadline: Time limit.
        use_kernel: Whether to use the native kernel where there is one.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    if not can_optimize(smooth_piece, limits):
        return profile
    h, parameters = _phases(smooth_piece, profile)
    module: Any = native() if use_kernel else None
    if module is not None:
        deadline.check("retime")
        return _optimized_by_kernel(module, smooth_piece, profile, limits, (h, parameters))
    best = _scaled_to_limits(smooth_piece, profile, limits)
    for round_ in _ROUNDS:
        spline = TimingSpline.through(h, parameters)
        if not spline.is_increasing:
            break
        problem = _ProfileProblem.of(smooth_piece, spline, parameters, limits)
        h = _optimize_durations(problem, h, round_, deadline)
        spline = TimingSpline.through(h, parameters)
        scaled = _scaled_to_limits(smooth_piece, spline.profile, limits)
        if scaled.duration < best.duration:
            best = scaled
    return best


def _optimized_by_kernel(
    module: Any,
    smooth_piece: JointSpline,
    profile: SpeedProfile,
    limits: JointLimits,
    phases: tuple[Array, Array],
) -> SpeedProfile:
    """Return what the native kernel makes of a profile, scaled to its limits."""
    columns = [block[0] for block in limits.blocks]
    path = smooth_piece.breaks, np.ascontiguousarray(smooth_piece.coefficients[:, :, columns])
    initial = profile.s, profile.v, profile.a, profile.j, profile.h
    bounds = np.stack([getattr(limits, rate) for rate in RATES])
    return SpeedProfile(*module.optimize_profile(path, initial, phases, bounds))


@dataclass(frozen=True)
class _ProfileProblem:
    """The optimization problem of one profile.

    Attributes:
        parameters: Path parameters between phases, shape (n + 1,).
        geometry: r', r'' and r''' at the points of phases, shape (3, points, n, nv).
        bounds: Limits of velocity, acceleration and jerk, shape (3, nv).
    """

    parameters: Array
    geometry: Array
    bounds: Array

    @classmethod
    def of(
        cls, smooth_piece: JointSpline, spline: TimingSpline, parameters: Array, limits: JointLimits
    ) -> "_ProfileProblem":
        """Build from a smooth piece, a spline that passes parameters on it, and limits."""
        pieces, _ = smooth_piece.locate((parameters[:-1] + parameters[1:]) / 2)
        columns = [block[0] for block in limits.blocks]
        t = _POINTS[:, None] * spline.h
        s = spline.s[:-1] + t * (spline.v[:-1] + t * (spline.a[:-1] / 2 + t * spline.j / 6))
        slopes = [derivative(smooth_piece.coefficients, order)[pieces] for order in (1, 2, 3)]
        geometry = [
            [evaluate_polynomials(slope, x)[:, columns] for x in s - smooth_piece.breaks[pieces]]
            for slope in slopes
        ]
        bounds = np.stack([getattr(limits, rate) for rate in RATES])
        return cls(parameters, np.array(geometry), bounds)

    def utilizations(self, spline: TimingSpline) -> list[Array]:
        """Return rates over limits at the points of phases, each shape (points, n, nv)."""
        r1, r2, r3 = self.geometry
        v, a = _states(spline)
        j = spline.j[:, None]
        rates = r1 * v, r1 * a + r2 * v**2, r1 * j + 3 * r2 * v * a + r3 * v**3
        return [rate / bound for rate, bound in zip(rates, self.bounds, strict=True)]

    def gradients(self, spline: TimingSpline) -> list[Array]:
        """Return derivatives of `utilizations` by v, a and j, each shape (points, n, nv, 3)."""
        r1, r2, r3 = self.geometry
        v, a = _states(spline)
        zero = np.zeros_like(r1)
        by_state = (
            (r1, zero, zero),
            (2 * r2 * v, r1, zero),
            (3 * r2 * a + 3 * r3 * v**2, 3 * r2 * v, r1),
        )
        return [
            np.stack(rows, axis=-1) / bound[:, None]
            for rows, bound in zip(by_state, self.bounds, strict=True)
        ]

    def cost(self, h: Array, weight: float) -> float:
        """Return the duration plus the barrier of all phases, infinite beyond limits."""
        spline = TimingSpline.through(h, self.parameters)
        utilizations = self.utilizations(spline)
        if (
            not spline.is_increasing
            or max(float(np.abs(utilization).max()) for utilization in utilizations) >= 1
        ):
            return np.inf
        return float(h.sum() - weight * sum(np.log1p(-use * use).sum() for use in utilizations))


def _states(spline: TimingSpline) -> tuple[Array, Array]:
    """Return v and a at the points of phases, each shape (points, n, 1)."""
    t = _POINTS[:, None] * spline.h
    v = spline.v[:-1] + t * (spline.a[:-1] + t * spline.j / 2)
    return v[..., None], (spline.a[:-1] + t * spline.j)[..., None]


def _state_derivatives(spline: TimingSpline) -> Array:
    """Return derivatives of v, a, j at the points of phases by log h, (points, n, 3, n)."""
    begin, end = spline.derivatives()
    f, h, k = _POINTS[:, None, None], spline.h[:, None], np.arange(len(spline.h))
    # v(t) = v_0 + h (f - f^2 / 2) a_0 + h f^2 / 2 a_1 where t = f h.
    by_begin, by_end = h * (f - f**2 / 2), h * f**2 / 2
    v = begin[:, 0] + by_begin * begin[:, 1] + by_end * end[:, 1]
    v[:, k, k] += by_begin[..., 0] * spline.a[:-1] + by_end[..., 0] * spline.a[1:]
    a = begin[:, 1] + f * (end[:, 1] - begin[:, 1])
    return np.stack([v, a, np.broadcast_to(begin[:, 2], a.shape)], axis=2)


def _optimize_durations(
    problem: _ProfileProblem, h: Array, round_: tuple[int, float, float], deadline: Deadline
) -> Array:
    """Return durations of a faster timing spline, from those of one that increases."""
    num_steps, utilization, relative_weight = round_
    initial = TimingSpline.through(h, problem.parameters)
    max_utilization = max(
        float(np.abs(use).max()) ** (1 / order)
        for order, use in enumerate(problem.utilizations(initial), start=1)
    )
    h = h * max_utilization / utilization
    weight = relative_weight * h.sum() / len(h)
    for _ in range(num_steps):
        deadline.check("retime")
        step, slope = _newton_step(problem, h, weight)
        h = _line_search(problem, h, weight, step, slope)
        weight *= _BARRIER_FACTOR
    return h


def _line_search(
    problem: _ProfileProblem, h: Array, weight: float, step: Array, slope: float
) -> Array:
    """Return durations after a backtracking line search along a step."""
    initial_cost, step_length = problem.cost(h, weight), 1.0
    while step_length > _MIN_STEP_LENGTH:
        trial = h * np.exp(step_length * step)
        if problem.cost(trial, weight) <= initial_cost + _ARMIJO_FACTOR * step_length * slope:
            return trial
        step_length /= 2
    return h


def _newton_step(problem: _ProfileProblem, h: Array, weight: float) -> tuple[Array, float]:
    """Return a Newton step of log h, and the slope of the cost along it."""
    spline = TimingSpline.through(h, problem.parameters)
    jacobian = _state_derivatives(spline)
    count, points = len(h), len(_POINTS)
    gradient, hessian = np.zeros((points, count, 3)), np.zeros((points, count, 3, 3))
    for utilization, by in zip(
        problem.utilizations(spline), problem.gradients(spline), strict=True
    ):
        above, below = 1 / (1 - utilization), 1 / (1 + utilization)
        gradient += np.einsum("enj,enjk->enk", above - below, by)
        hessian += np.einsum("enj,enjk,enjl->enkl", above**2 + below**2, by, by)
    flat_jacobian = jacobian.reshape(-1, count)
    curved = np.einsum("enkl,enlm->enkm", hessian, jacobian).reshape(-1, count)
    slopes = h + weight * (gradient.ravel() @ flat_jacobian)
    step = np.linalg.solve(weight * (flat_jacobian.T @ curved) + np.diag(h), -slopes)
    step *= _MAX_STEP / max(float(np.abs(step).max()), _MAX_STEP)
    return step, float(slopes @ step)


def _phases(smooth_piece: JointSpline, profile: SpeedProfile) -> tuple[Array, Array]:
    """Return durations of phases and the parameters between them, breaks of the path included."""
    cut = profile.split_at(smooth_piece.breaks[1:-1])
    begins = np.concatenate([[0.0], np.cumsum(cut.h)])
    break_times = begins[np.abs(cut.s[:, None] - smooth_piece.breaks[1:-1]).argmin(axis=0)]
    even_times = np.linspace(0.0, begins[-1], _NUM_PHASES + 1)[1:-1]
    distances = np.abs(even_times[:, None] - break_times).min(axis=1, initial=np.inf)
    inner = np.sort(
        np.concatenate([even_times[distances > _MIN_PHASE_SHARE * even_times[0]], break_times])
    )
    # The first and the last inner parameter are free, for the rests at the ends: they are no
    # breaks.
    ends = inner[0] / 2, (inner[-1] + begins[-1]) / 2
    times = np.concatenate([[0.0, ends[0]], inner, [ends[1], begins[-1]]])
    phase = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(cut.h) - 1)
    t = times - begins[phase]
    s = cut.s[phase] + t * (cut.v[phase] + t * (cut.a[phase] / 2 + t * cut.j[phase] / 6))
    s[np.searchsorted(times, break_times)] = smooth_piece.breaks[1:-1]
    s[0], s[-1] = smooth_piece.breaks[0], smooth_piece.breaks[-1]
    return np.diff(times), s


def _scaled_to_limits(
    smooth_piece: JointSpline, profile: SpeedProfile, limits: JointLimits
) -> SpeedProfile:
    """Return the profile scaled to its limits."""
    motion = compose(smooth_piece, profile)
    factor = max(
        float((block_peaks(motion, limits, order) / getattr(limits, rate)).max()) ** (1 / order)
        for order, rate in enumerate(RATES, start=1)
    )
    return SpeedProfile(
        profile.s,
        profile.v / factor,
        profile.a / factor**2,
        profile.j / factor**3,
        profile.h * factor,
    )
