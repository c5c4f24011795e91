"""Judge: whether a motion is one, keeps its limits and stays on its path, from samples alone."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.retiming.motion import Array, Motion
from benchmarks.retiming.paths import Question

# Ten times finer than motions are usually delivered [s].
PERIOD = 0.001
# How far from its goal a motion may end [rad], and how fast it may be there [rad/s].
_ARRIVED, _AT_REST = 1e-3, 1e-2


@dataclass(frozen=True)
class Verdict:
    """What was found of one motion.

    Attributes:
        valid: It is finite, begins and ends where it should, and is at rest there.
        duration: [s].
        use: Largest rate over its limit, of those that the contender was told.
        deviation: From the path, in joint space [rad].
        milliseconds: That it took.
    """

    valid: bool
    duration: float
    use: float
    deviation: float
    milliseconds: float


def judged(question: Question, motion: Motion | None, ms: float, *, jerk: bool) -> Verdict:
    """Return the verdict on a motion, or on none."""
    nothing = Verdict(False, np.nan, np.nan, np.nan, ms)  # noqa: FBT003
    if motion is None or not (np.isfinite(motion.duration) and motion.duration > 0):
        return nothing
    times = np.linspace(0.0, motion.duration, max(2, int(np.ceil(motion.duration / PERIOD)) + 1))
    q, *rates = motion.sample(times)
    if not all(np.isfinite(array).all() for array in (q, *rates)):
        return nothing
    waypoints, limits = question.path.waypoints, question.limits
    missed = np.abs(q[[0, -1]] - waypoints[[0, -1]]).max()
    bounds: list[Any] = [limits.velocity, limits.acceleration]
    uses = [np.abs(rate / bound).max() for rate, bound in zip(rates, bounds, strict=False)]
    if jerk:
        third = rates[2] if len(rates) > 2 else np.diff(rates[1], axis=0) / np.diff(times)[:, None]
        uses.append(np.abs(third / limits.jerk).max())
    valid = missed <= _ARRIVED and np.abs(rates[0][[0, -1]]).max() <= _AT_REST
    return Verdict(bool(valid), motion.duration, float(max(uses)), deviation(q, waypoints), ms)


def deviation(q: Array, waypoints: Array) -> float:
    """Return the largest distance of configurations from a polyline [rad]."""
    nearest = np.full(len(q), np.inf)
    for begin, end in pairwise(waypoints):
        step = end - begin
        along = np.clip((q - begin) @ step / max(float(step @ step), 1e-30), 0.0, 1.0)
        away = np.linalg.norm(q - begin - along[:, None] * step, axis=1)
        nearest = np.minimum(nearest, away)
    return float(nearest.max())
