"""Loads of a motion, their derivatives, linearizations and bounds on the path velocity."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.request.motion_limits import MotionLimits, ToolLimit
from planning.domain.request.options import RetimeOptions
from planning.refine.constraints.load import MAX_STATIC_LOAD
from planning.refine.constraints.request_bounds import request_bounds
from planning.refine.constraints.zone_load import ZoneLoad
from planning.refine.curves.bspline_basis import make_bspline
from planning.refine.curves.curve_samples import CurveSamples
from planning.refine.curves.path_velocity import NormalizedDerivatives, duration_of, path_grid
from planning.refine.curves.power_basis import joint_spline
from planning.refine.model.load_evaluation import LoadEvaluation, path_velocity_along
from planning.retime.limits.request_limits import path_limits
from planning.retime.retimer import retime
from tests.conftest import bundled_world
from tests.profiles import num_cases, pairs
from tests.refine.arms import (
    ARMS,
    KINDS,
    arm_of,
    bounds_under,
    curve_points,
    limits_of,
    request_of,
)

SEEDS = st.integers(0, 2**32 - 1)
EACH = pytest.mark.parametrize(("name", "kind"), pairs(list(ARMS), KINDS))
SOME = settings(max_examples=num_cases(4))


def lengths(evaluation: LoadEvaluation, path_velocity: np.ndarray) -> np.ndarray:
    """Return the loads at both ends of every interval, shape (m, balls)."""
    (load,) = evaluation.loads
    samples = CurveSamples.of(
        evaluation.num_control_points,
        evaluation.states_by_num_parts[load.num_parts],
        path_velocity,
        load.num_parts,
    )
    return np.linalg.norm(load.load_ratios(*samples.motion), axis=2)


@EACH
@SOME
@given(seed=SEEDS)
def test_the_load_along_a_curve_is_that_of_its_motions(name, kind, seed):
    rng = np.random.default_rng(seed)
    bounds = bounds_under(name, limits_of(name, kind))
    path_velocity, evaluation = path_velocity_along(curve_points(name, rng), bounds)
    (load,), (along,) = evaluation.loads, evaluation.along
    states = evaluation.states_by_num_parts[load.num_parts]
    samples = CurveSamples.of(
        evaluation.num_control_points,
        states,
        path_velocity * rng.uniform(0.5, 1.5, len(path_velocity)),
        load.num_parts,
    )
    found = along.ratios(samples.grid_indices, samples.b, samples.u)
    expected = load.load_ratios(*samples.motion)
    # Accelerations of frames are difference quotients.
    atol = 1e-5 if kind not in {"torque", "zone"} else 1e-9
    np.testing.assert_allclose(found, expected, rtol=0, atol=atol * (1 + np.abs(expected).max()))
    np.testing.assert_allclose(along.static_load, load.static_load(states[0]), rtol=0, atol=1e-12)


@EACH
@SOME
@given(seed=SEEDS)
def test_slopes_are_those_of_the_vectors(name, kind, seed):
    rng = np.random.default_rng(seed)
    (load,) = bounds_under(name, limits_of(name, kind)).loads
    points = curve_points(name, rng)
    state = np.stack([points, rng.normal(size=points.shape), 3 * rng.normal(size=points.shape)])
    direction, h = rng.normal(size=state.shape), 1e-5
    change = load.load_ratios(*(state + h * direction)) - load.load_ratios(*(state - h * direction))
    expected = np.einsum("kmbdj,kmj->mbd", load.derivatives(*state), direction)
    scale = 1 + np.abs(expected).max()
    off = np.sort(np.abs(change / (2 * h) - expected).max(axis=(1, 2)) / scale)
    if kind != "zone":
        assert off[-1] < 2e-5
    else:
        # Quotients miss half a step times the second derivative, which is large about the faces
        # of a zone; and one of the points may lie where another face becomes the nearest.
        assert off[-2] < 5e-3


@EACH
@SOME
@given(seed=SEEDS)
def test_linearizations_predict_the_loads_of_nearby_motions(name, kind, seed):
    rng = np.random.default_rng(seed)
    bounds = bounds_under(name, limits_of(name, kind))
    points = curve_points(name, rng)
    path_velocity, evaluation = path_velocity_along(points, bounds)
    # The second one of a zone is of its edge: `test_rows_at_a_zones_edge...`.
    linearization = next(
        s for s in evaluation.load_linearizations(path_velocity, 1.0) if s.bound == 1.0
    )
    assume(len(linearization.samples.grid_indices) > 0)
    moved, faster, h = rng.normal(size=points.shape), rng.normal(size=len(path_velocity)), 1e-6
    after = LoadEvaluation.of(points + h * moved, bounds.loads)
    before = LoadEvaluation.of(points - h * moved, bounds.loads)
    change = lengths(after, path_velocity * (1 + h * faster)) - lengths(
        before, path_velocity * (1 - h * faster)
    )
    change /= 2 * h
    predicted = np.einsum(
        "mrkj,mkj->mr", linearization.by_control_point, moved[linearization.samples.control_points]
    )
    predicted += np.einsum(
        "mre,me->mr",
        linearization.by_path_velocity,
        faster[linearization.samples.intervals[:, None] + [0, 1]],
    )
    place = linearization.samples.intervals + linearization.samples.grid_indices
    now = np.linalg.norm(linearization.vectors, axis=2)
    large = now > 0.1
    # To first order a length changes along its vector.
    products = linearization.vectors * predicted.reshape(linearization.vectors.shape)
    signed = products.sum(axis=2) / np.where(large, now, 1.0)
    scale = 1 + np.abs(predicted).max()
    np.testing.assert_allclose(signed[large], change[place][large], atol=1e-3 * scale)


def zone_load(name: str) -> ZoneLoad:
    (load,) = bounds_under(name, limits_of(name, "zone")).loads
    assert isinstance(load, ZoneLoad)
    return load


def weight_at(load: ZoneLoad, margins: np.ndarray) -> np.ndarray:
    """Return the weight of a zone at signed margins, by its definition."""
    inner, outer = load.edge_range
    f = np.clip((outer - margins) / (outer - inner), 0.0, 1.0)
    return f * f * (3 - 2 * f)


@SOME
@given(seed=SEEDS, ratio=st.floats(0.1, 8.0))
def test_what_keeps_a_row_at_a_zones_edge_keeps_its_limit(seed: int, ratio: float) -> None:
    load, rng = zone_load("ur5e"), np.random.default_rng(seed)
    inner, outer = load.edge_range
    # A point that keeps the limit, near a face or before it.
    margin = rng.uniform(inner, outer + 0.08, 50)
    ratios = np.minimum(ratio, 1 / np.maximum(weight_at(load, margin), 1e-9))
    sums, by_margin, by_ratio = load.edge_rows(margin, ratios)
    assert (sums <= 1 + 1e-9).all()
    moved, faster = rng.uniform(-0.1, 0.1, (50, 50)), rng.uniform(-1, 3, (50, 50)) * ratio
    after = np.maximum(ratios[:, None] + faster, 0.0)
    rows = (
        sums[:, None] + by_margin[:, None] * moved + by_ratio[:, None] * (after - ratios[:, None])
    )
    loads = weight_at(load, margin[:, None] + moved) * after
    assert (loads[rows <= 1] <= 1 + 1e-6).all()
    assert (rows <= 1).any()


@pytest.mark.parametrize("name", list(ARMS))
@SOME
@given(seed=SEEDS)
def test_rows_at_a_zones_edge_predict_margins_and_speeds(name: str, seed: int) -> None:
    rng, load = np.random.default_rng(seed), zone_load(name)
    bounds = bounds_under(name, limits_of(name, "zone"))
    points = curve_points(name, rng)
    path_velocity, evaluation = path_velocity_along(points, bounds)
    edge = evaluation.load_linearizations(path_velocity, 1.0)[1]
    assume(len(edge.samples.grid_indices) > 0)

    def sums(h: float) -> np.ndarray:
        after = LoadEvaluation.of(points + h * moved, bounds.loads)
        states = after.states_by_num_parts[load.num_parts]
        samples = CurveSamples.of(
            len(points), states, path_velocity * (1 + h * faster), load.num_parts
        )
        q, v, _ = samples.motion
        ratios = np.linalg.norm(load.box.kinematics.velocities(q, v), axis=1) / load.speed
        found = load.edge_rows(load.box.signed_margins(q), ratios)[0]
        return found[edge.samples.intervals + edge.samples.grid_indices]

    moved, faster, h = rng.normal(size=points.shape), rng.normal(size=len(path_velocity)), 1e-6
    change = (sums(h) - sums(-h)) / (2 * h)
    predicted = np.einsum("mrkj,mkj->m", edge.by_control_point, moved[edge.samples.control_points])
    predicted += np.einsum(
        "mre,me->m", edge.by_path_velocity, faster[edge.samples.intervals[:, None] + [0, 1]]
    )
    np.testing.assert_allclose(sums(0.0), edge.ratios[:, 0], atol=1e-9)
    # One of them may lie where another face becomes the nearest, or another tangent is taken.
    off = np.sort(np.abs(predicted - change)) / (1 + np.abs(change).max())
    assert off[: max(1, len(off) - 2)].max() < 1e-3


@EACH
@SOME
@given(seed=SEEDS)
def test_the_path_velocity_keeps_loads_and_meets_a_bound_everywhere(name, kind, seed):
    bounds = bounds_under(name, limits_of(name, kind))
    points = curve_points(name, np.random.default_rng(seed))
    path_velocity, evaluation = path_velocity_along(points, bounds)
    grid = path_grid(len(points))
    rates = NormalizedDerivatives.of(grid, points, bounds)
    loads = lengths(evaluation, path_velocity)
    assert loads.max() <= 1 + 1e-6
    assert rates.max_acceleration_ratio(grid, path_velocity) <= 1 + 1e-9
    shares = np.maximum(
        np.abs(rates.accelerations(grid, path_velocity)).max(axis=(1, 2)),
        loads.max(axis=1).reshape(len(grid.control_points), -1).max(axis=1),
    )
    used = np.maximum(
        path_velocity[1:-1] / rates.path_velocity_bounds(), np.maximum(shares[1:], shares[:-1])
    )
    assert used.min() > 0.97


@EACH
@SOME
@given(seed=SEEDS)
def test_the_duration_is_what_the_retimer_finds(name, kind, seed):
    world, group = arm_of(name)
    others = limits_of(name, kind)
    bounds = bounds_under(name, others)
    points = curve_points(name, np.random.default_rng(seed), 14)
    path_velocity, _ = path_velocity_along(points, bounds)
    options = RetimeOptions(
        tool_limits=others.tool_limits,
        speed_zones=others.speed_zones,
        effort=others.limits_effort,
        payload=others.payload,
    )
    curve: JointSpline = joint_spline(group.joints, make_bspline(points))
    timed, _ = retime(curve, world.limits(group), options, path_limits(world, group, options))
    # This grid is coarser: the path velocity changes less freely on it; zones begin before faces.
    found = duration_of(path_grid(len(points)), path_velocity)
    most = 1.35 if kind == "zone" else 1.13
    assert 0.98 * timed.duration < found < most * timed.duration


def test_without_limits_on_loads_there_are_no_loads():
    bounds = bounds_under("ur5e", MotionLimits())
    assert bounds.loads == ()
    np.testing.assert_array_equal(bounds.acceleration_range, [[-1.0] * 6, [1.0] * 6])
    _, evaluation = path_velocity_along(curve_points("ur5e", np.random.default_rng(0)), bounds)
    assert evaluation is None


def test_a_load_that_is_nowhere_near_makes_no_rows():
    others = MotionLimits((ToolLimit("arm::tcp", speed=100.0, acceleration=1e4),))
    bounds = bounds_under("ur5e", others)
    points = curve_points("ur5e", np.random.default_rng(1))
    path_velocity, evaluation = path_velocity_along(points, bounds)
    for linearization in evaluation.load_linearizations(path_velocity, 1.0):
        numbers = np.arange(points.size).reshape(points.shape), np.arange(len(path_velocity))
        assert len(linearization.balls(*numbers, np.ones(6)).lower_bounds) == 0


def test_joints_that_float_leave_loads_to_the_retimer():
    world = bundled_world("window_3d")
    group = world.group("body")
    frame = group.tool_frames[0]
    path = JointPath(group, np.stack([world.positions(group)] * 2))
    others = MotionLimits((ToolLimit(frame, speed=0.1),))
    assert request_bounds(world, request_of(world, path, others)).loads == ()


@given(seed=SEEDS)
@SOME
def test_excessive_static_loads_cost_and_are_linearized(seed):
    rng = np.random.default_rng(seed)
    others = limits_of("panda", "torque")
    (load,) = bounds_under("panda", others).loads
    points = curve_points("panda", rng)
    weak = type(load)(load.dynamics, load.columns, load.efforts * 0.3)
    evaluation = LoadEvaluation.of(points, (weak,))
    static_loads = np.abs(weak.static_load(evaluation.states_by_num_parts[1][0]))
    assert evaluation.excess == pytest.approx(np.maximum(static_loads - MAX_STATIC_LOAD, 0).sum())
    assert evaluation.excess > 0
    _, linearization = evaluation.load_linearizations(
        np.ones(len(evaluation.states_by_num_parts[1][0])), 1.0
    )
    moved, h = rng.normal(size=points.shape), 1e-6
    at = linearization.samples.grid_indices
    change = weak.static_load(
        LoadEvaluation.of(points + h * moved, (weak,)).states_by_num_parts[1][0][at]
    )
    change = (
        change
        - weak.static_load(
            LoadEvaluation.of(points - h * moved, (weak,)).states_by_num_parts[1][0][at]
        )
    ) / (2 * h)
    owners = linearization.samples.control_points
    predicted = np.einsum("mrkj,mkj->mr", linearization.by_control_point, moved[owners])
    np.testing.assert_allclose(predicted, change, atol=1e-4 * (1 + np.abs(change).max()))
    assert not linearization.by_path_velocity.any()
