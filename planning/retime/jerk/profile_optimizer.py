"""Profile optimizer: faster jerk-limited profiles by an interior-point method.

A profile passes fixed parameters of the path; the durations h_k of its phases are the variables. At
both ends of every phase the speed v, the acceleration a and the jerk j in the path parameter make

    q' = r' v,   q'' = r' a + r'' v^2,   q''' = r' j + 3 r'' v a + r''' v^3

(the chain rule), which must stay within their limits. Newton's method with a logarithmic barrier
minimizes the sum of all h_k (Boyd and Vandenberghe, "Convex optimization", chapter 11; the problem
is not convex, and the curvature of the limits is left out). Limits are not imposed inside phases:
the peaks there are bounded afterwards, and the whole profile is slowed by the excess.
"""

from dataclasses import dataclass

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline, derivative
from planning.domain.request.deadline import UNHURRIED, Deadline
from planning.domain.robot.joints import JointLimits
from planning.retime.bounds import block_peaks
from planning.retime.compose import compose
from planning.retime.jerk.timing_spline import TimingSpline
from planning.retime.limit_utilization import RATES
from planning.retime.profile import SpeedProfile
from planning.retime.smooth_pieces import evaluated

# Largest number of pieces of a path: with more a step would take too long.
_MOST_PIECES = 64
# Number of phases of equal duration; those that begin at breaks of the path are added.
_NUM_PHASES = 48
# Shortest phase relative to the others; shorter ones are left out, except at breaks.
_NEAR = 0.4
_ROUNDS, _STEPS = 3, 8
# Largest utilization of limits at the beginning of a round.
_ROOM = 0.97
# The barrier's weight relative to a phase's duration, and its factor per step.
_BARRIER, _FALL = 0.1, 0.5
# Largest relative change of a phase's duration in a step, approximately.
_LONGEST_STEP = 0.3
_SUFFICIENT, _SHORTEST_STEP = 0.01, 1e-3
# Largest factor by which a limit exceeded within a phase is tightened for the next round, and the
# smallest utilization at its ends that the factor is computed with.
_TIGHTEST, _LITTLE_USED = 2.0, 0.3


def optimize_profile(
    stretch: JointSpline,
    profile: SpeedProfile,
    limits: JointLimits,
    deadline: Deadline = UNHURRIED,
) -> SpeedProfile:
    """Return a faster profile within the limits, or the given one.

    With floating joints, blocks of several coordinates, or many pieces, it is the given one.

    Args:
        stretch: Smooth piece of the path to which the profile belongs.
        profile: From rest to rest.
        limits: Limits of velocity, acceleration and jerk.
        deadline: Time limit.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    is_plain = stretch.manifold.is_flat and all(len(block) == 1 for block in limits.blocks)
    if not is_plain or stretch.num_pieces > _MOST_PIECES:
        return profile
    best, _ = _within(stretch, profile, limits)
    h, places = _phases(stretch, profile)
    task = _Task.of(stretch, places, limits)
    for _ in range(_ROUNDS):
        at = _descended(task, h, deadline)
        if at is None:
            break
        made, peaks = _within(stretch, at.profile, limits)
        if made.duration < best.duration:
            best = made
        h = made.h
        slower = made.duration / at.h.sum()
        ends = [np.abs(use).max(axis=(0, 2)) for use in task.untightened(at)]
        used = np.stack([use / slower**k for k, use in enumerate(ends, start=1)])
        task = task.tightened(np.clip(peaks / np.maximum(used, _LITTLE_USED), 1.0, _TIGHTEST))
    return best


@dataclass(frozen=True)
class _Task:
    """The optimization problem of one profile.

    Attributes:
        places: Path parameters between phases, shape (n + 1,).
        geometry: r', r'' and r''' at both ends of phases, shape (3, 2, n, nv).
        bounds: Limits of velocity, acceleration and jerk, shape (3, nv).
        excess: Divisors of the limits on each phase, shape (3, n).
    """

    places: Array
    geometry: Array
    bounds: Array
    excess: Array

    @classmethod
    def of(cls, stretch: JointSpline, places: Array, limits: JointLimits) -> "_Task":
        """Build from a smooth piece, path parameters on it and limits."""
        pieces, _ = stretch.locate((places[:-1] + places[1:]) / 2)
        columns = [block[0] for block in limits.blocks]
        local = [places[:-1] - stretch.breaks[pieces], places[1:] - stretch.breaks[pieces]]
        slopes = [derivative(stretch.coefficients, order)[pieces] for order in (1, 2, 3)]
        geometry = [[evaluated(slope, x)[:, columns] for x in local] for slope in slopes]
        bounds = np.stack([getattr(limits, rate) for rate in RATES])
        return cls(places, np.array(geometry), bounds, np.ones((3, len(pieces))))

    def tightened(self, excess: Array) -> "_Task":
        """Return the task with other divisors of the limits."""
        return _Task(self.places, self.geometry, self.bounds, excess)

    def untightened(self, at: TimingSpline) -> list[Array]:
        """Return rates over limits at both ends of phases, each shape (2, n, nv)."""
        r1, r2, r3 = self.geometry
        v, a = (np.stack([x[:-1], x[1:]])[..., None] for x in (at.v, at.a))
        j = at.j[:, None]
        rates = r1 * v, r1 * a + r2 * v**2, r1 * j + 3 * r2 * v * a + r3 * v**3
        return [rate / bound for rate, bound in zip(rates, self.bounds, strict=True)]

    def uses(self, at: TimingSpline) -> list[Array]:
        """Return rates over tightened limits at both ends of phases, each shape (2, n, nv)."""
        uses = self.untightened(at)
        return [use * more[:, None] for use, more in zip(uses, self.excess, strict=True)]

    def gradients(self, at: TimingSpline) -> list[Array]:
        """Return the derivatives of `uses` by v, a and j, each shape (2, n, nv, 3)."""
        r1, r2, r3 = self.geometry
        v, a = (np.stack([x[:-1], x[1:]])[..., None] for x in (at.v, at.a))
        zero = np.zeros_like(r1)
        by = (
            (r1, zero, zero),
            (2 * r2 * v, r1, zero),
            (3 * r2 * a + 3 * r3 * v**2, 3 * r2 * v, r1),
        )
        scales = self.excess[:, :, None] / self.bounds[:, None, :]
        return [
            np.stack(rows, axis=-1) * scale[..., None]
            for rows, scale in zip(by, scales, strict=True)
        ]

    def cost(self, h: Array, weight: float) -> float:
        """Return the duration plus the barrier of all phases, infinite beyond limits."""
        at = TimingSpline.through(h, self.places)
        uses = self.uses(at)
        if not at.goes_on or max(float(np.abs(use).max()) for use in uses) >= 1:
            return np.inf
        return float(h.sum() - weight * sum(np.log1p(-use * use).sum() for use in uses))


def _descended(task: _Task, h: Array, deadline: Deadline) -> TimingSpline | None:
    """Return a faster timing spline than the one with durations h; None if that one stops."""
    begin = TimingSpline.through(h, task.places)
    if not begin.goes_on:
        return None
    most = max(
        float(np.abs(use).max()) ** (1 / order)
        for order, use in enumerate(task.uses(begin), start=1)
    )
    h = h * most / _ROOM
    weight = _BARRIER * h.sum() / len(h)
    for _ in range(_STEPS):
        deadline.check("retime")
        step, slope = _newton(task, h, weight)
        h = _stepped(task, h, weight, step, slope)
        weight *= _FALL
    return TimingSpline.through(h, task.places)


def _stepped(task: _Task, h: Array, weight: float, step: Array, slope: float) -> Array:
    """Return durations after a backtracking line search along a step."""
    before, share = task.cost(h, weight), 1.0
    while share > _SHORTEST_STEP:
        tried = h * np.exp(share * step)
        if task.cost(tried, weight) <= before + _SUFFICIENT * share * slope:
            return tried
        share /= 2
    return h


def _newton(task: _Task, h: Array, weight: float) -> tuple[Array, float]:
    """Return a Newton step of log h, and the slope of the cost along it."""
    at = TimingSpline.through(h, task.places)
    moves = at.derivatives()
    count = len(h)
    gradient, hessian = np.zeros((2, count, 3)), np.zeros((2, count, 3, 3))
    for use, by in zip(task.uses(at), task.gradients(at), strict=True):
        above, below = 1 / (1 - use), 1 / (1 + use)
        gradient += np.einsum("enj,enjk->enk", above - below, by)
        hessian += np.einsum("enj,enjk,enjl->enkl", above**2 + below**2, by, by)
    flat = moves.reshape(-1, count)
    curved = np.einsum("enkl,enlm->enkm", hessian, moves).reshape(-1, count)
    slopes = h + weight * (gradient.ravel() @ flat)
    step = np.linalg.solve(weight * (flat.T @ curved) + np.diag(h), -slopes)
    step *= _LONGEST_STEP / max(float(np.abs(step).max()), _LONGEST_STEP)
    return step, float(slopes @ step)


def _phases(stretch: JointSpline, profile: SpeedProfile) -> tuple[Array, Array]:
    """Return durations of phases and the parameters between them, breaks of the path included."""
    cut = profile.split_at(stretch.breaks[1:-1])
    begins = np.concatenate([[0.0], np.cumsum(cut.h)])
    fixed = begins[np.abs(cut.s[:, None] - stretch.breaks[1:-1]).argmin(axis=0)]
    even = np.linspace(0.0, begins[-1], _NUM_PHASES + 1)[1:-1]
    away = np.abs(even[:, None] - fixed).min(axis=1, initial=np.inf)
    inner = np.sort(np.concatenate([even[away > _NEAR * even[0]], fixed]))
    # The first and the last inner parameter are free, for the rests at the ends: they are no
    # breaks.
    ends = inner[0] / 2, (inner[-1] + begins[-1]) / 2
    times = np.concatenate([[0.0, ends[0]], inner, [ends[1], begins[-1]]])
    phase = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(cut.h) - 1)
    t = times - begins[phase]
    s = cut.s[phase] + t * (cut.v[phase] + t * (cut.a[phase] / 2 + t * cut.j[phase] / 6))
    s[np.searchsorted(times, fixed)] = stretch.breaks[1:-1]
    s[0], s[-1] = stretch.breaks[0], stretch.breaks[-1]
    return np.diff(times), s


def _within(
    stretch: JointSpline, profile: SpeedProfile, limits: JointLimits
) -> tuple[SpeedProfile, Array]:
    """Return the profile scaled to its limits, and its utilization of each on its phases."""
    motion = compose(stretch, profile)
    peaks = np.stack([
        (block_peaks(motion, limits, order) / getattr(limits, rate)).max(axis=1)
        for order, rate in enumerate(RATES, start=1)
    ])
    orders = np.arange(1, 4)
    factor = float((peaks.max(axis=1) ** (1 / orders)).max())
    made = SpeedProfile(
        profile.s,
        profile.v / factor,
        profile.a / factor**2,
        profile.j / factor**3,
        profile.h * factor,
    )
    return made, peaks / factor ** orders[:, None]
