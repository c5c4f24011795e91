"""Coordinates along paths of bodies that float: where they are, how distances change, how far."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning.domain.curves.path import JointPath
from planning.domain.geometry import rotation
from planning.domain.goals.goal import ConfigurationGoal, JointGoal
from planning.domain.report.motion_plan import MotionPlan
from planning.domain.request.options import RefineOptions, RetimeOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.refine.constraints.distance_query import make_distance_query
from planning.refine.curves.chart import FlatChart, TangentChart, make_chart
from planning.refine.refine_problem import RefineProblem
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.retime.blend import blend_corners
from planning.retime.retimer import retime
from planning.world.loading.load_world import load_world
from planning.world.world import World
from tests.certify.conftest import smallest_distance
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases
from tests.refine.conftest import whole_descent

AXIS = np.array([0.48, 0.6, 0.64])


def path_turning(angles: list[float]) -> JointPath:
    """Return a path of the L in space that turns about an axis through some angles."""
    group = bundled_world("window_3d").group("body")
    places = np.linspace([-0.6, 0.0, 0.5], [-0.4, 0.1, 0.6], len(angles))
    turns = rotation.exp(np.array(angles)[:, None] * AXIS)
    return JointPath(group, np.hstack([turns, places]))


def plan(world: World, method: str, seed: int) -> MotionPlan:
    problem = PlanningProblem(
        "body",
        ConfigurationGoal("beyond"),
        search=SearchOptions(allowed_planning_time=30.0),
        refine=RefineOptions(method),
        seed=seed,
    )
    return planning.plan(problem, world, deadline=no_hurry(30.0))


def test_the_ends_of_a_curve_are_those_of_the_path() -> None:
    path = path_turning([0.0, 1.0, 2.5])
    chart = make_chart(path)
    assert isinstance(chart, TangentChart)
    assert not chart.is_winding
    manifold = path.spline.manifold
    placed = chart.positions(chart.waypoints)
    assert manifold.distance(placed[[0, -1]], path.waypoints[[0, -1]]).max() < 1e-12
    rng = np.random.default_rng(0)
    points = rng.normal(0, 0.2, (14, 6))
    points[0], points[-1] = chart.waypoints[[0, -1]]
    curve = chart.curve(points)
    ends = np.stack([curve.start, curve.end])
    assert manifold.distance(ends, path.waypoints[[0, -1]]).max() < 1e-12


def test_joints_that_do_not_float_have_positions_as_coordinates() -> None:
    world = bundled_world("maze_2d")
    group = world.group("body")
    path = JointPath(group, np.array([[0.0, 0.0, 3.0], [0.1, 0.0, -3.0]]))
    chart = make_chart(path)
    assert isinstance(chart, FlatChart)
    assert chart.waypoints[:, 2] == pytest.approx([3.0, 2 * np.pi - 3.0])


@pytest.mark.parametrize("angles", [[0.0, 0.7, 1.6], [0.0, 2.0, 4.0, 6.0]])
@pytest.mark.parametrize("kernel", [True, False])
def test_gradients_are_those_of_the_coordinates(kernel: bool, angles: list[float]) -> None:
    world = bundled_world("window_3d")
    world = load_world(world.scene, world.library, kernel=kernel)
    path = path_turning(angles)
    chart = make_chart(path)
    ends = world.embed(path.group, path.waypoints[[0, -1]])
    buffers = DistanceBuffers.from_ends(world, world.margins(), ends)
    near = chart.distance_query_in_chart(make_distance_query(world, path.group, buffers))
    rng = np.random.default_rng(1)
    deltas = chart.waypoints[:: len(chart.waypoints) // 6] + rng.normal(
        0, 0.05, chart.waypoints[:: len(chart.waypoints) // 6].shape
    )
    now = near.within(deltas, 2.0)
    step = 1e-5
    for k in range(6):
        there = near.within(deltas + step * np.eye(6)[k], 2.0)
        np.testing.assert_array_equal(there.sample_indices, now.sample_indices)
        slopes = (there.signed_margins - now.signed_margins) / step
        # Where the nearest points are about to change, one side says something else.
        assert (np.abs(slopes - now.gradients[:, k]) < 1e-3).mean() > 0.9


@pytest.mark.parametrize("seed", [0, 2])
def test_a_body_that_floats_flies_quicker_refined(seed: int) -> None:
    world = bundled_world("window_3d")
    refined, plain = plan(world, "trajopt", seed), plan(world, "none", seed)
    assert refined.stages.refine.improved
    assert refined.certificate.proven
    least = refined.stages.refine.lower_bound
    assert least < refined.trajectory.duration < 0.97 * plain.trajectory.duration
    assert smallest_distance(world, refined.trajectory, "body", 0.004) >= -2e-6


def test_held_rotations_stay_fixed() -> None:
    world = bundled_world("maze_2d")
    group = world.group("body")
    start = world.positions(group)
    joint = group.joints[0].name
    problem = PlanningProblem(
        "body",
        JointGoal(start[None] + np.array([[-0.25, 0.3, 0.0]])),
        search=SearchOptions(allowed_planning_time=30.0, spaces={joint: "position"}),
    )
    found = planning.plan(problem, world, deadline=no_hurry(30.0))
    assert found.stages.refine.improved
    q = found.trajectory.positions(np.linspace(0.0, found.trajectory.duration, 500))
    assert np.abs(q[:, 2] - start[2]).max() < 1e-12


@given(turns=st.lists(st.floats(0.1, 2.5), min_size=2, max_size=5), seed=st.integers(0, 99))
@settings(max_examples=num_cases(6))
def test_coordinates_follow_far_turns(turns: list[float], seed: int) -> None:
    rng = np.random.default_rng(seed)
    axes = AXIS + rng.normal(0, 0.2, (len(turns), 3))
    group = bundled_world("window_3d").group("body")
    steps = rotation.exp(np.array(turns)[:, None] * axes)
    quaternions = [np.array([1.0, 0.0, 0.0, 0.0])]
    for step in steps:
        quaternions.append(rotation.multiply(quaternions[-1], step))
    path = JointPath(group, np.hstack([quaternions, np.zeros((len(quaternions), 3))]))
    chart = make_chart(path)
    deltas = chart.waypoints
    turned = np.linalg.norm(deltas[:, :3], axis=1)
    assert turned.max() <= 4.5
    # A small step along the path is a small one in coordinates, at any distance from the base.
    assert np.linalg.norm(np.diff(deltas, axis=0), axis=1).max() < 0.3
    manifold = path.spline.manifold
    ends = chart.positions(deltas[[0, -1]])
    assert manifold.distance(ends, path.waypoints[[0, -1]]).max() < 1e-9
    assert chart.is_winding == (turned.max() > 2.2)


@pytest.mark.parametrize("kernel", [True, False])
@pytest.mark.parametrize("far", [5.5, 12.0])
def test_a_winding_path_is_replaced_by_the_short_one_if_that_is_free(
    far: float, kernel: bool
) -> None:
    world = bundled_world("window_3d")
    world = load_world(world.scene, world.library, kernel=kernel)
    path = path_turning(np.linspace(0.0, far, 12).tolist())
    limits = world.limits(path.group)
    request = RefineRequest(path, limits, world.margins(), RefineOptions("trajopt"))
    curve, report = refine(world, request, no_hurry(30.0))
    assert curve is not None, report.reason
    ends = np.stack([curve.start, curve.end])
    assert path.spline.manifold.distance(ends, path.waypoints[[0, -1]]).max() < 1e-9
    oracle = world.collision_oracle(path.group, world.margins())
    assert oracle.are_free(curve.positions(np.linspace(0.0, 1.0, 1001))).all()
    refined, plain = (retime(one, limits, RetimeOptions())[0] for one in (curve, path.spline))
    assert refined.duration < 0.5 * plain.duration


def test_a_path_that_must_wind_becomes_faster() -> None:
    """A descent near the path winds as it does."""
    world = bundled_world("window_3d")
    path = path_turning([0.0, 1.5, 1.0, 2.5, 4.0, 3.5, 5.5])
    limits = world.limits(path.group)
    request = RefineRequest(path, limits, world.margins(), RefineOptions("trajopt"))
    task = RefineProblem.of(world, request, no_hurry())
    descent = whole_descent(task)
    best = descent.best
    assert best is not None, descent.reason
    assert task.chart.is_winding
    refined, _ = retime(task.curve_of(best), limits, RetimeOptions())
    rounded, _ = retime(blend_corners(path, 0.03, 1), limits, RetimeOptions())
    assert refined.duration < rounded.duration


def test_the_audit_looks_at_positions_of_the_delivered_curve() -> None:
    world = bundled_world("window_3d")
    path = path_turning([0.0, 1.5, 1.0, 2.5, 4.0, 3.5, 5.5])
    request = RefineRequest(path, world.limits(path.group), world.margins(), RefineOptions())
    task = RefineProblem.of(world, request, no_hurry())
    points = task.fit_path(0.15)
    positions = task.samples_of(points).positions
    wanted = task.chart.curve(points).positions(np.linspace(0.0, 1.0, len(positions)))
    np.testing.assert_allclose(positions, wanted, atol=1e-9)
