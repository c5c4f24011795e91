"""Curves along the path that are certainly slower than the refined one are timed when needed."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planning
from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.options import RetimeOptions
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointType
from planning.kernel.native import native
from planning.pipeline import candidate_motions
from planning.pipeline.timing import candidate_timing
from planning.pipeline.timing.candidate_order import cheapest_first
from planning.pipeline.timing.candidate_timing import REFINED_CURVE, CandidateMotion
from planning.pipeline.timing.path_curves import PathCurve
from planning.pipeline.timing.path_duration_bound import path_duration_bound
from planning.retime.blend import blend_corners
from planning.retime.bspline_smoothing import smooth_path
from planning.retime.retimer import RETIMERS, retime
from planning.retime.smooth_pieces import smooth_pieces
from tests.clocks import no_hurry
from tests.conftest import group_of, limits_of, random_waypoints
from tests.profiles import rng_of, seeds
from tests.refine.conftest import puck_world

CORNERS = np.array([[-0.6, -0.2], [-0.1, 0.4], [0.4, -0.1], [0.6, 0.3]])
METHODS = ["toppra", "ruckig"]
GROUPS = [
    (JointType.REVOLUTE, JointType.PRISMATIC),
    (JointType.CONTINUOUS, JointType.FLOATING),
    (JointType.PLANAR,),
]


def found_on(folder: Path, method: str, taken: int | None = None) -> list[CandidateMotion]:
    """Return the first `taken` candidates along the path of `CORNERS`, all for None."""
    world = puck_world(folder, [([0.1, 0.1, 0.2], [0.0, -0.5, 0.0])])
    problem = planning.PlanningProblem(
        "puck", planning.JointGoal(CORNERS[-1:]), retime=RetimeOptions(method)
    )
    deadline = no_hurry(60.0)
    candidates = candidate_motions.candidates(
        world,
        JointPath(world.group("puck"), CORNERS),
        problem,
        world.margins(None),
        deadline,
        Stopwatch(deadline.clock),
        path_limits=(),
    )
    return list(candidates) if taken is None else [next(candidates) for _ in range(taken)]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("end", ["straight", "rounded"])
def test_order_is_that_of_curves_that_are_all_timed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: str, end: str
) -> None:
    """With a bound of zero every curve is timed at once."""
    group = puck_world(tmp_path, []).group("puck")
    corners = CORNERS[[0, -1]] if end == "straight" else CORNERS
    refined = blend_corners(JointPath(group, corners), 0.05, 2)
    report = RefineReport("trajopt", improved=True)
    monkeypatch.setattr(candidate_motions, "refine", lambda *_: (refined, report))
    timed: list[JointSpline] = []

    def counted(spline: JointSpline, *rest: Any) -> Any:
        timed.append(spline)
        return retime(spline, *rest)

    monkeypatch.setattr(candidate_timing, "retime", counted)
    found_on(tmp_path, method, taken=1)
    assert (len(timed) == 1) == (end == "straight")
    found = found_on(tmp_path, method)
    monkeypatch.setattr(candidate_timing, "path_duration_bound", lambda *_: 0.0)
    expected = found_on(tmp_path, method)
    assert [(c.name, c.cost) for c in found] == [(c.name, c.cost) for c in expected]
    assert len(found) > 2


def test_unrefined_curves_wait_where_another_is_certainly_quicker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The path itself, say, with its rests; the order is that of curves that are all timed."""
    report = RefineReport("none", improved=False)
    monkeypatch.setattr(candidate_motions, "refine", lambda *_: (None, report))
    timed: list[JointSpline] = []

    def counted(spline: JointSpline, *rest: Any) -> Any:
        timed.append(spline)
        return retime(spline, *rest)

    monkeypatch.setattr(candidate_timing, "retime", counted)
    found_on(tmp_path, "ruckig", taken=1)
    num_at_once = len(timed)
    found = found_on(tmp_path, "ruckig")
    assert num_at_once < len(timed) - num_at_once
    monkeypatch.setattr(candidate_timing, "path_duration_bound", lambda *_: 0.0)
    expected = found_on(tmp_path, "ruckig")
    assert [(c.name, c.cost) for c in found] == [(c.name, c.cost) for c in expected]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", seeds(8, 300))
@pytest.mark.parametrize("types", GROUPS, ids="-".join)
def test_bound_is_below_every_timing(types: tuple[JointType, ...], seed: int, method: str) -> None:
    """Of rounded, smoothed and cornered random paths, under scaled limits too."""
    rng, group = rng_of(seed), group_of(*types)
    limits = limits_of(group, *rng.uniform(0.5, 2.0, 3) * [2.0, 10.0, 100.0])
    path = JointPath(group, random_waypoints(group, seed, int(rng.integers(2, 6))))
    scales = rng.uniform(0.1, 1.0, 2)
    options = RetimeOptions(method, velocity_scale=scales[0], acceleration_scale=scales[1])
    curves = [blend_corners(path, deviation, 2) for deviation in (0.2, 0.01, 0.0)]
    curves += [curve for _, curve in smooth_path(path, (0.2,))]
    for curve in curves:
        bound = path_duration_bound(curve, limits, options)
        duration = retime(curve, limits, options)[0].duration
        assert 0.3 * duration < bound <= duration


@pytest.mark.skipif(native() is None, reason="the native kernel was not built")
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", seeds(8, 300))
def test_bound_and_corners_are_those_of_numpy(
    monkeypatch: pytest.MonkeyPatch, seed: int, method: str
) -> None:
    group = group_of(*[JointType.REVOLUTE] * 7)
    path = JointPath(group, random_waypoints(group, seed, 2 + seed % 5))
    curve = blend_corners(path, [0.1, 0.0][seed % 2], 2)
    limits, smoothness = limits_of(group), RETIMERS[method].smoothness
    bound, pieces = (
        path_duration_bound(curve, limits, RetimeOptions(method)),
        smooth_pieces(curve, smoothness),
    )
    for module in ("retime.smooth_pieces", "pipeline.timing.path_duration_bound"):
        monkeypatch.setattr(f"planning.{module}.native", lambda: None)
    assert path_duration_bound(curve, limits, RetimeOptions(method)) == pytest.approx(bound)
    assert smooth_pieces(curve, smoothness) == pieces


@pytest.mark.parametrize(("method", "share"), [("toppra", 0.999), ("ruckig", 0.8)])
def test_bound_of_a_straight_line_is_near(tmp_path: Path, method: str, share: float) -> None:
    """A long one, most of which is at full speed."""
    world = puck_world(tmp_path, [])
    group, limits = world.group("puck"), world.limits(world.group("puck"))
    line = JointPath(group, np.array([[-1.0, -0.3], [1.0, 0.3]])).spline
    duration = retime(line, limits, RetimeOptions(method))[0].duration
    assert path_duration_bound(line, limits, RetimeOptions(method)) > share * duration


@pytest.mark.parametrize("seed", seeds(20))
def test_slower_curves_wait_only_for_the_first_refusal(seed: int) -> None:
    """Whatever they cost: the order is that of curves of which all are timed at once."""
    costs = rng_of(seed).uniform(1.0, 2.0, 5)
    names = [REFINED_CURVE, "a", "b", "c", "d"]
    # Of a motion only its name and its cost count here.
    none: Any = None
    motions = {
        name: CandidateMotion(name, none, none, none, none, objective_cost=cost)
        for name, cost in zip(names, costs, strict=True)
    }
    curves = {n: PathCurve(n, 0.0, none) for n in names[1:]}
    slower = [c for n, c in curves.items() if motions[n].cost > costs[0]]
    asked: list[str] = []

    def time_curve(curve: PathCurve, _: bool) -> list[CandidateMotion]:
        asked.append(curve.name)
        return [motions[curve.name]]

    timed = [motions[n] for n in names if motions[n].cost <= costs[0]]
    found = cheapest_first(timed, [], time_curve, slower=slower)
    first = next(found)
    assert not asked
    names_in_order = [motion.name for motion in cheapest_first([*motions.values()], [], time_curve)]
    assert [first.name, *(motion.name for motion in found)] == names_in_order
