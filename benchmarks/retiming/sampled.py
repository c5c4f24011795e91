"""The same curves and lines, sampled finely and coarsely: the motions should be the same."""

import time
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from benchmarks.retiming.motion import Array
from benchmarks.retiming.paths import Question
from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.retime.blend import blend_corners
from planning.retime.bspline_smoothing import smooth_path
from planning.retime.retimer import RETIMERS, retime

# How far a curve may be from the path, as plans have it (joint-space length).
_ALLOWED = 0.1
COUNTS = (5, 10, 25, 50, 100, 200)
_STEP = 0.5


@dataclass(frozen=True)
class Sampled:
    """What came of one way of sampling, medians over questions.

    Attributes:
        kind: `curve` or `line`.
        count: Waypoints.
        method: Who timed it.
        duration_s: Of the motion.
        rounded_s: With its corners rounded, one by one.
        ms: That timing took.
    """

    kind: str
    count: int
    method: str
    duration_s: float
    rounded_s: float
    ms: float


def sampled(
    questions: list[Question], seed: int, counts: tuple[int, ...] = COUNTS
) -> list[Sampled]:
    """Return a row for every kind, count of waypoints and method."""
    methods: tuple[Literal["toppra", "ruckig"], ...] = ("toppra", "ruckig")
    return [
        _timed(kind, count, method, [_path(kind, count, q, seed + i) for i, q in pairs])
        for kind in ("curve", "line")
        for count in counts
        for method in methods
        for pairs in [list(enumerate(questions))]
    ]


def _path(kind: str, count: int, question: Question, seed: int) -> Question:
    """Return waypoints on a line, or on a curve, from where the question's path begins."""
    rng = np.random.default_rng(seed)
    begin = question.path.waypoints[0]
    ahead, aside = rng.normal(0.0, _STEP, (2, len(begin)))
    x = np.linspace(0.0, 1.0, count)[:, None]
    bent: Array = np.zeros_like(x) if kind == "line" else 1 - np.cos(2 * x)
    rows = begin + ahead * x + aside * bent
    return Question(question.robot, JointPath(question.path.group, rows), question.limits)


def _timed(
    kind: str, count: int, method: Literal["toppra", "ruckig"], questions: list[Question]
) -> Sampled:
    smoothness, options = RETIMERS[method].smoothness, RetimeOptions(method)
    found: list[tuple[float, float, float]] = []
    for question in questions:
        begun = time.perf_counter()
        rounded = blend_corners(question.path, _ALLOWED, smoothness)
        near = smooth_path(question.path, [_ALLOWED]) if method == "ruckig" else []
        durations: list[Any] = [
            retime(curve, question.limits, options)[0].duration
            for curve in (rounded, *(curve for _, curve in near))
        ]
        ms = (time.perf_counter() - begun) * 1000
        found.append((min(durations), durations[0], ms))
    return Sampled(kind, count, method, *(float(np.median(x)) for x in zip(*found, strict=True)))
