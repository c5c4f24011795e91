"""Curves in the kernel are those of numpy: path velocity and convex steps, on random curves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.robot.joints import JointLimits
from planning.kernel.native import native
from planning.refine.constraints.distance_query import DistanceRows
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.constraints.request_bounds import signed_accelerations
from planning.refine.curves.curve_evaluation import CurveEvaluation
from planning.refine.curves.native_grid import native_path_velocity
from planning.refine.curves.path_velocity import (
    NormalizedDerivatives,
    duration_of,
    minimum_time_path_velocity,
    path_grid,
)
from planning.refine.model.curve_model import CurveModel
from planning.refine.model.load_evaluation import path_velocity_along
from planning.refine.model.penalty_qp import bounds_of, compressed, compressed_balls
from planning.refine.model.variable_layout import make_variable_layout
from tests.profiles import num_cases
from tests.refine.arms import ARMS, KINDS, arm_of, bounds_under, curve_points, limits_of

pytestmark = pytest.mark.skipif(native() is None, reason="there is no kernel")
SEEDS = st.integers(0, 2**32 - 1)
SOME = settings(max_examples=num_cases(4))
EACH = pytest.mark.parametrize("name", ARMS)
NUM_MARGINS = 200


class GivenDistances:
    """Random margins and gradients, the same for any curve."""

    def __init__(self, rng: np.random.Generator, num_instants: int, size: int) -> None:
        self.rows = DistanceRows(
            np.sort(rng.integers(0, num_instants, NUM_MARGINS)),
            rng.uniform(-0.01, 0.1, NUM_MARGINS),
            rng.normal(size=(NUM_MARGINS, size)),
        )

    def within(self, qs, influence_distance):
        return self.rows


def joint_bounds(name: str, rng: np.random.Generator, *, jerk: bool) -> RateBounds:
    world, group = arm_of(name)
    signed = {j.name: tuple(rng.uniform(1, 9, 2) * [-1, 1]) for j in group.joints[::2]}
    return RateBounds.of(
        world.limits(group),
        limits_jerk=jerk,
        acceleration_bounds=signed_accelerations(group, signed),
    )


def assert_same_path_velocity(points: np.ndarray, bounds: RateBounds) -> None:
    grid = path_grid(len(points))
    found, loads = path_velocity_along(points, bounds)
    constraints = None if loads is None else loads.path_velocity_constraints
    assert native_path_velocity(points, bounds, constraints) is not None
    derivatives = NormalizedDerivatives.of(grid, points, bounds)
    expected = minimum_time_path_velocity(grid, derivatives, constraints)
    # The solver ends within its tolerance of the sum of b, which hardly depends on one.
    np.testing.assert_allclose(found, expected, rtol=0.02, atol=1e-4 * expected.max())
    assert duration_of(grid, found) == pytest.approx(duration_of(grid, expected), rel=5e-5)
    assert derivatives.max_acceleration_ratio(grid, found) <= 1 + 1e-9
    if constraints is not None:
        assert constraints.max_value(found) <= 1 + 1e-9


@EACH
@SOME
@given(seed=SEEDS, jerk=st.booleans(), count=st.integers(5, 17))
def test_the_path_velocity_is_that_of_all_rows(name, seed, jerk, count):
    rng = np.random.default_rng(seed)
    assert_same_path_velocity(curve_points(name, rng, count), joint_bounds(name, rng, jerk=jerk))


@EACH
@pytest.mark.parametrize("kind", KINDS)
@SOME
@given(seed=SEEDS)
def test_so_it_is_under_loads(name, kind, seed):
    points = curve_points(name, np.random.default_rng(seed))
    assert_same_path_velocity(points, bounds_under(name, limits_of(name, kind)))


@EACH
@pytest.mark.parametrize("kind", KINDS)
@SOME
@given(seed=SEEDS, radius=st.floats(0.001, 0.4))
def test_rows_of_loads_are_those_of_numpy(name, kind, seed, radius):
    rng = np.random.default_rng(seed)
    points, bounds = curve_points(name, rng), bounds_under(name, limits_of(name, kind))
    path_velocity, loads = path_velocity_along(points, bounds)
    assert loads is not None
    layout = make_variable_layout(*points.shape)
    columns = layout.control_points.astype(np.int64), layout.path_velocity.astype(np.int64)
    radii = radius * bounds.velocity
    for linearization in loads.load_linearizations(path_velocity, 1.0):
        if linearization.are_vectors:
            balls = linearization.balls(*columns, radii)
            expected = *compressed_balls([balls]), bounds_of([balls])[1]
        else:
            rows = linearization.rows(*columns, radii)
            expected = *compressed([rows]), *bounds_of([rows])
        found = linearization.native_rows(*columns, radii)
        assert (found is None) <= (len(expected[-1]) == 0)
        if found is not None:
            of_this_kind, of_the_other = found[:: -1 if linearization.are_vectors else 1]
            assert len(of_the_other[-1]) == 0
            for part, wanted in zip(of_this_kind, expected, strict=True):
                scale = np.abs(wanted).max(initial=1.0)
                np.testing.assert_allclose(part, wanted, rtol=0, atol=1e-12 * scale)


def assert_same_step(model: CurveModel, evaluation: CurveEvaluation, radius: float) -> None:
    points, decrease = model.step(evaluation, radius)
    expected, expected_decrease = model.reference_step(evaluation, radius)
    assert decrease == pytest.approx(expected_decrease, rel=1e-6, abs=1e-9)
    np.testing.assert_allclose(points, expected, atol=1e-6)


@EACH
@SOME
@given(
    seed=SEEDS,
    kind=st.sampled_from([None, *KINDS]),
    jerk=st.booleans(),
    radius=st.floats(0.001, 0.4),
)
def test_a_step_is_that_of_the_rows_in_numpy(name, seed, kind, jerk, radius):
    rng = np.random.default_rng(seed)
    world, group = arm_of(name)
    points = curve_points(name, rng)
    if kind is None:
        bounds = joint_bounds(name, rng, jerk=jerk)
    else:
        bounds = bounds_under(name, limits_of(name, kind))
    distances = GivenDistances(rng, 40, points.shape[1])
    model = CurveModel(distances, world.limits(group), bounds, len(points), 40)
    model.add_samples(rng.uniform(size=3))
    assert_same_step(model, model.evaluate(points), radius)


@SOME
@given(seed=SEEDS, num_coordinates=st.integers(1, 18), jerk=st.booleans())
def test_so_it_is_for_any_number_of_coordinates(
    seed: int, num_coordinates: int, jerk: bool
) -> None:
    """The kernel takes eight at once, and what remains."""
    rng = np.random.default_rng(seed)
    velocity, acceleration, jerks, effort = rng.uniform(1.0, 9.0, (4, num_coordinates))
    far, blocks = np.full(num_coordinates, 9.0), tuple((k,) for k in range(num_coordinates))
    limits = JointLimits(-far, far, velocity, acceleration, jerks, effort, blocks)
    bounds = RateBounds.of(limits, limits_jerk=jerk)
    points = np.cumsum(rng.normal(size=(8, num_coordinates)), axis=0)
    distances = GivenDistances(rng, 20, num_coordinates)
    model = CurveModel(distances, limits, bounds, len(points), 20)
    assert_same_step(model, model.evaluate(points), 0.1)
