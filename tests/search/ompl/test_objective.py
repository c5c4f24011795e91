"""Objectives are norms (but for clearance), and OMPL's objectives have the same costs."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ompl import base as ob

from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.search.ompl.objective import Objective
from planning.search.ompl.spaces import SearchSpace
from planning.search.solver import search
from tests.profiles import num_cases, pairs

KINDS = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PLANAR, JointType.FLOATING)
NORMS = ["length", "weighted_length", "duration"]


def objective_of(name, group, limits, clearances=None):
    weights = np.linspace(0.5, 2.0, len(group.blocks))
    return Objective(name, group, limits, weights, clearances)


@pytest.mark.parametrize("name", NORMS)
@given(seed=st.integers(0, 10_000), factor=st.floats(0.0, 10.0))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=num_cases(6))
def test_norms_are_norms(make_group, make_limits, name, seed, factor):
    group = make_group(*KINDS)
    norm = objective_of(name, group, make_limits(group)).norm
    a, b = np.random.default_rng(seed).normal(size=(2, group.num_velocities))
    assert norm(a[None])[0] > 0
    assert norm((factor * a)[None])[0] == pytest.approx(factor * norm(a[None])[0])
    assert norm((a + b)[None])[0] <= norm(a[None])[0] + norm(b[None])[0] + 1e-12


@pytest.mark.parametrize("name", NORMS)
def test_a_path_costs_the_sum_of_its_pieces(make_group, make_limits, name):
    group = make_group(*KINDS)
    objective = objective_of(name, group, make_limits(group))
    manifold = Manifold(group.joints)
    qs = manifold.normalized(np.random.default_rng(0).uniform(-1, 1, (5, group.num_positions)))
    whole = objective.cost(qs)
    assert whole == pytest.approx(objective.edge_costs(qs[:-1], qs[1:]).sum())
    middle = manifold.interpolate(qs[0], qs[1], np.array([0.3]))
    assert objective.cost(np.concatenate([qs[:1], middle, qs[1:]])) == pytest.approx(whole)


def test_the_least_time_is_that_of_the_slowest_block(make_group, make_limits):
    group = make_group(JointType.PLANAR, JointType.REVOLUTE)
    limits = make_limits(group)
    rates = np.array([0.5, 2.0, 1.0])
    limits = type(limits)(limits.lower, limits.upper, rates, rates, rates, rates, limits.blocks)
    q = np.array([[0.0, 0.0, 0.0, 0.0], [0.3, 0.4, 0.0, 0.0], [0.3, 0.4, 1.0, 0.6]])
    assert objective_of("duration", group, limits).cost(q) == pytest.approx(1.0 + 0.6)


def test_clearance_prefers_the_path_farther_from_obstacles(plane):
    group, limits = plane
    objective = objective_of("clearance", group, limits, lambda qs: np.abs(qs[:, 1]))
    near = np.array([[-1.0, 0.1], [1.0, 0.1]])
    around = np.array([[-1.0, 0.1], [-0.5, 0.8], [0.5, 0.8], [1.0, 0.1]])
    assert objective.cost(around) < objective.cost(near)
    assert objective.cost(near) == pytest.approx(2.0 / 0.11)


@pytest.mark.parametrize("name", ["length", "weighted_length", "duration", "clearance"])
def test_ompl_s_objective_has_the_same_costs(make_group, make_limits, name):
    group = make_group(JointType.REVOLUTE, JointType.PRISMATIC)
    limits = make_limits(group)
    objective = objective_of(name, group, limits, lambda qs: np.abs(qs[:, 1]) + 0.05)
    weights = np.linspace(0.5, 2.0, 2)
    space = SearchSpace(group, limits, np.zeros((1, 2)), weights)
    information = ob.SpaceInformation(space.ompl)
    information.setup()
    ompl_objective = objective.make_ompl_objective(information, space, "RRTstar")
    if ompl_objective is None:
        ompl_objective = ob.PathLengthOptimizationObjective(information)
    for q0, q1 in np.random.default_rng(0).uniform(-1, 1, (20, 2, 2)):
        cost = ompl_objective.motionCost(space.write(q0), space.write(q1)).value()
        assert cost == pytest.approx(objective.edge_costs(q0[None], q1[None])[0])


def wanting(task, **options):
    options = replace(task.options, weights={"r::j0": 3.0}, **options)
    distances = lambda qs: np.maximum(np.abs(qs[:, 0]) - 0.1, 0.6 - qs[:, 1])  # noqa: E731
    return replace(task, options=options, clearances=distances)


@pytest.mark.parametrize("name", ["weighted_length", "duration", "clearance"])
def test_the_best_of_many_is_the_best_by_the_objective(plane, wall, soon, crossing, name):
    task = wanting(crossing(), attempts=3, objective=name)
    found = search(*plane, wall, task, soon)
    costs = [entry.cost for entry in found.report.attempts_log if entry.outcome == "solved"]
    assert len(costs) == 3
    assert found.report.cost == min(costs)
    assert found.report.objective == name
    again = search(*plane, wall, task, soon)
    assert again.path.waypoints.tobytes() == found.path.waypoints.tobytes()
    assert again.report == found.report


IMPROVING = {
    "PRM": {},
    "FMT": {"num_samples": 200},
    "BITstar": {"samples_per_batch": 50},
}


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("planner", "name"), pairs(list(IMPROVING), ["weighted_length", "duration", "clearance"])
)
def test_planners_that_improve_take_the_objective(plane, wall, soon, crossing, name, planner):
    task = wanting(crossing(), planner=planner, parameters=IMPROVING[planner], objective=name)
    found = search(*plane, wall, task, soon)
    assert found.report.solved == 1
    weights = np.array([3.0, 1.0])
    objective = Objective(name, *plane, weights, task.clearances)
    assert found.report.cost == pytest.approx(objective.cost(found.path.waypoints))


def test_asking_for_distance_keeps_more_of_it(plane, soon, crossing, make_oracle):
    """Around the end of a wall a path may pass near or far."""

    def distances(qs):
        return np.hypot(qs[:, 0], np.maximum(qs[:, 1] - 0.2, 0.0))

    oracle = make_oracle(lambda qs: distances(qs) > 0.02)
    least = {}
    for name in ("length", "clearance"):
        task = replace(crossing(attempts=5, objective=name, num_states=200), clearances=distances)
        found = search(*plane, oracle, task, soon)
        inner = found.path.waypoints[np.abs(found.path.waypoints[:, 0]) < 0.3]
        least[name] = distances(inner).min()
    assert least["clearance"] > least["length"] + 0.02
