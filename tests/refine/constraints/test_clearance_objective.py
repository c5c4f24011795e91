"""The clearance objective is weighed against the duration, and against nothing else."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import planning
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation import trajectory_through
from planning.domain.request.options import ClearanceObjective, RefineOptions
from planning.errors import ProblemInvalid
from planning.refine.constraints.clearance_objective import make_clearance_objective
from planning.world.loading.load_world import load_world
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.refine.conftest import Case, puck_world

RADIUS, WALL_END = 0.02, 0.3
# So far that it takes longer to keep it.
DISTANCE = 0.5


def clearance(positions: np.ndarray) -> np.ndarray:
    """Of the puck to the wall of `thin_wall`, a box 1 mm thick that ends at y = 0.3."""
    x, y = np.abs(positions[:, 0]) - 0.0005, positions[:, 1] - WALL_END
    return np.hypot(np.maximum(x, 0), np.maximum(y, 0)) - RADIUS


def refined(case: Case, distance: float, weight: float) -> tuple[float, float]:
    """Return the estimated duration of the refined curve, and its mean shortfall along s."""
    options = RefineOptions(clearance=ClearanceObjective(distance, weight))
    curve, report = replace(case, request=replace(case.request, options=options)).refined()
    assert curve is not None
    lacks = np.maximum(distance - clearance(curve.positions(np.linspace(0, 1, 2001))), 0)
    return report.duration_after, float(lacks.mean())


@pytest.fixture(scope="module")
def bargain(thin_wall: Case) -> Callable[[float], tuple[float, float]]:
    """Return duration and shortfall by weight beside the thin wall, refining once for each."""
    return cache(partial(refined, thin_wall, DISTANCE))


def test_more_weight_buys_more_clearance_for_more_time(bargain):
    bought = [bargain(weight) for weight in (1e-3, 1.0, 10.0, 1e3)]
    for (duration, shortfall), (other_duration, other_shortfall) in pairwise(bought):
        assert other_duration > duration - 0.01
        assert other_shortfall < shortfall + 1e-4
    assert bought[0][1] > 0.01
    assert bought[-1][1] < 1e-3
    assert bought[-1][0] > bought[0][0] + 0.05


@pytest.mark.parametrize("weight", [1.0, 10.0, 100.0])
def test_no_other_weight_has_a_better_bargain(bargain, weight):
    duration, shortfall = bargain(weight)
    for other in (1e-3, weight / 10, weight * 10):
        other_duration, other_shortfall = bargain(other)
        assert duration + weight * shortfall < (other_duration + weight * other_shortfall) * 1.01


@pytest.fixture(scope="module")
def walled(tmp_path_factory) -> dict[bool, World]:
    world = puck_world(tmp_path_factory.mktemp("puck"), [([0.001, 1.3, 0.2], [0.0, -0.35, 0.0])])
    return {True: world, False: load_world(world.scene, world.library, kernel=False)}


@given(
    kernel=st.booleans(),
    distance=st.floats(0.03, 0.5),
    ends=st.lists(st.floats(-0.9, -0.1), min_size=4, max_size=4),
)
def test_the_shortfall_is_a_mean_over_the_motion(walled, kernel, distance, ends):
    world = walled[kernel]
    group = world.group("puck")
    start, goal = np.array(ends[:2]), np.array([ends[2], 1.4 + ends[3]])
    trajectory: TimedTrajectory = trajectory_through(
        group.joints, np.array([0.0, 2.0]), np.array([start, goal]), np.zeros((2, 2))
    )
    clearance_cost = make_clearance_objective(
        world, group, world.margins(), ClearanceObjective(distance, 1.0)
    )
    assert clearance_cost is not None
    qs = trajectory.positions(np.linspace(0, 2, 5001))
    lacks = np.maximum(distance - clearance(qs), 0)
    # Inside the wall the analytic formula does not hold.
    assume(clearance(qs).min() > 0)
    # The mean of 201 samples is off by half of one at each end, at most.
    assert clearance_cost.mean_shortfall(trajectory) == pytest.approx(
        lacks.mean(), abs=distance / 200
    )


def test_links_of_one_robot_may_be_near_one_another(arm):
    alone = load_world(replace(arm.world.scene, objects=()), arm.world.library)
    group = alone.group("arm")
    clearance_cost = make_clearance_objective(
        alone, group, alone.margins(), ClearanceObjective(1.0, 1.0)
    )
    assert clearance_cost is not None
    folded = np.array([[0.0, 2.4, 2.4], [1.0, 2.4, 2.4]])
    trajectory = trajectory_through(group.joints, np.array([0.0, 1.0]), folded, np.zeros((2, 3)))
    assert clearance_cost.mean_shortfall(trajectory) == 0


def test_a_plan_pays_for_its_clearance_and_says_so():
    world = bundled_world("panda_shelf")
    target = planning.PoseTarget(planning.Pose.identity(), "lower")
    goal = planning.PoseGoal((target,), "", np.zeros(3), np.zeros(3))
    plain, cautious = (
        planning.plan(
            planning.PlanningProblem(
                "panda",
                goal,
                refine=RefineOptions(clearance=clearance),
                retime=planning.RetimeOptions(method="ruckig"),
            ),
            world,
            deadline=no_hurry(30.0),
        )
        for clearance in (None, ClearanceObjective(0.1, 30.0))
    )
    assert plain.stages.refine.shortfall is None
    assert cautious.stages.refine.shortfall == pytest.approx(0, abs=1e-3)
    assert cautious.trajectory.duration > plain.trajectory.duration
    assert cautious.certificate.proven
    assert cautious.certificate.min_clearance > plain.certificate.min_clearance + 0.02


@pytest.mark.parametrize(
    ("options", "field"),
    [
        (RefineOptions(clearance=ClearanceObjective(0.0, 1.0)), "refine.clearance.distance"),
        (RefineOptions(clearance=ClearanceObjective(np.inf, 1.0)), "refine.clearance.distance"),
        (RefineOptions(clearance=ClearanceObjective(0.05, -1.0)), "refine.clearance.weight"),
        (RefineOptions(clearance=ClearanceObjective(0.05, np.nan)), "refine.clearance.weight"),
        (RefineOptions("none", ClearanceObjective(0.05, 1.0)), "refine.clearance"),
    ],
)
def test_invalid_clearance_objectives_are_refused(options, field):
    world = bundled_world("panda_shelf")
    goal = planning.ConfigurationGoal("ready")
    problem = planning.PlanningProblem("panda", goal, refine=options)
    with pytest.raises(ProblemInvalid) as refusal:
        planning.plan(problem, world, deadline=no_hurry(5.0))
    assert refusal.value.evidence["field"] == field
