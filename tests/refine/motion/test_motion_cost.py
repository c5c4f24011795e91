"""Costs and rows of spline motions: gradients are those of their values."""

from dataclasses import replace

import numpy as np
import pytest

from planning.domain.curves.path import JointPath
from planning.domain.request.refine_objective import RefineObjective
from planning.refine.curves.bspline_basis import make_bspline
from planning.refine.curves.chart import FlatChart
from planning.refine.drake.margin_rows import MarginRows
from planning.refine.motion.load_rows import LoadRows
from planning.refine.motion.motion_cost import MotionCost
from planning.refine.motion.motion_objectives import MotionObjectives
from planning.refine.motion.motion_residuals import cost_residuals
from planning.refine.motion.spline_matrices import rate_maps, split
from planning.refine.motion.spline_motion import SplineMotion, fit_motion, rate_time_scaling
from planning.refine.refine_problem import RefineProblem
from planning.world.mechanics.dynamics import GroupDynamics
from tests.clocks import no_hurry
from tests.profiles import rng_of
from tests.refine.arms import arm_of, bounds_under, curve_points, limits_of
from tests.refine.conftest import whole_descent

COUNT = 10
OBJECTIVES = {
    "acceleration": RefineObjective(smoothness=2.0),
    "jerk": RefineObjective(smoothness=0.1, derivative="jerk"),
    "energy": RefineObjective(energy=0.01),
    "path_length": RefineObjective(path_length=3.0),
    "sum": RefineObjective(1.0, 0.1, 0.001, 0.5, max_duration=9.0),
}


def difference_quotient(function, x: np.ndarray, direction: np.ndarray) -> np.ndarray:
    step = 1e-5
    return (function(x + step * direction) - function(x - step * direction)) / (2 * step)


@pytest.fixture
def points() -> np.ndarray:
    return curve_points("ur5e", rng_of(3), COUNT)


@pytest.mark.parametrize("name", OBJECTIVES)
def test_gradients_of_costs_are_right(name, points):
    world, group = arm_of("ur5e")
    cost = MotionCost(OBJECTIVES[name], GroupDynamics(world, group), COUNT)
    x, rng = np.append(points.ravel(), 1.7), rng_of(5)
    value, by_points, by_time = cost.gradient(*split(x, COUNT))
    assert value == pytest.approx(cost.value(points, 1.7))
    for _ in range(3):
        direction = rng.normal(size=len(x))
        slope = difference_quotient(lambda at: cost.value(*split(at, COUNT)), x, direction)
        assert np.append(by_points.ravel(), by_time) @ direction == pytest.approx(slope, rel=1e-4)


@pytest.mark.parametrize("name", OBJECTIVES)
def test_the_cost_is_what_the_report_measures(name, points):
    world, group = arm_of("ur5e")
    # Rest at both ends without acceleration, so that jerks are finite.
    motion = SplineMotion(points, 1.7).with_ends_of(points, 3)
    cost = MotionCost(OBJECTIVES[name], GroupDynamics(world, group), COUNT)
    trajectory = motion.trajectory(FlatChart(JointPath(group, points)))
    measured = MotionObjectives.of(world, group, trajectory, OBJECTIVES[name], None)
    assert measured.cost() == pytest.approx(cost.value(motion.points, 1.7), rel=5e-3)


@pytest.mark.parametrize("name", OBJECTIVES)
def test_squares_of_residuals_have_the_gradient_of_the_cost(name, points):
    """Of lengths they are an upper bound, that touches the cost."""
    world, group = arm_of("ur5e")
    objective = replace(OBJECTIVES[name], duration=0.0)
    cost = MotionCost(objective, GroupDynamics(world, group), COUNT)
    columns = np.arange(points.size).reshape(points.shape)
    gradient, nq = np.zeros(points.size + 1), points.shape[1]
    for part in cost_residuals(cost, points, 1.7):
        at, entries, values = part.rows(columns, points.size, np.ones(nq))
        np.add.at(gradient, at, 2 * values[:, None] * entries)
    _, by_points, by_time = cost.gradient(points, 1.7)
    tie_break = objective.time_weight
    expected = np.append(by_points.ravel(), 1.7 * (by_time - tie_break))
    size = np.abs(expected).max()
    np.testing.assert_allclose(
        gradient, expected, atol=(2e-2 if objective.path_length else 1e-6) * size
    )


@pytest.mark.parametrize("kind", ["torque", "both"])
def test_gradients_of_loads_are_right(kind, points):
    bounds = bounds_under("ur5e", limits_of("ur5e", kind))
    rows = LoadRows.of(bounds.loads[0], COUNT)
    x = np.append(points.ravel(), 1.1)
    values, gradients = rows(x)
    assert len(values) == rows.num_rows(points.shape[1])
    direction = rng_of(7).normal(size=len(x))
    slopes = difference_quotient(lambda at: rows(at)[0], x, direction)
    np.testing.assert_allclose(gradients @ direction, slopes, rtol=1e-3, atol=1e-4)


def test_margins_of_the_nearest_pairs_have_their_gradients(pillar):
    problem = RefineProblem.of(pillar.world, pillar.request, no_hurry())
    points = problem.fit_path(0.15)
    rows = MarginRows.at(np.linspace(0.1, 0.9, 15), problem.distance_query, len(points))
    x = np.append(points.ravel(), 1.0)
    margins, gradients = rows(x)
    assert margins.min() < 0.1
    by_instant = margins.reshape(15, -1)
    assert (np.diff(by_instant, axis=1) >= 0).all()
    everywhere = np.zeros(gradients.shape, dtype=bool)
    everywhere[tuple(np.array(rows.sparsity(points.shape[1])).T)] = True
    assert not gradients[~everywhere].any()
    direction = 1e-2 * rng_of(9).normal(size=len(x))
    slopes = difference_quotient(lambda at: rows(at)[0], x, direction)
    # Nearest pairs of the meshes change here and there.
    agrees = np.isclose(gradients @ direction, slopes, rtol=1e-2, atol=1e-5)
    assert agrees.mean() > 0.9


@pytest.mark.parametrize("order", [1, 2, 3])
def test_rates_and_control_points_convert_into_each_other(order, points):
    to_rates, from_rates = rate_maps(COUNT, order)
    rates = to_rates @ points
    np.testing.assert_allclose(
        to_rates @ (from_rates @ rates), rates, atol=1e-8 * np.abs(rates).max()
    )
    derivative = make_bspline(points).MakeDerivative(order)
    np.testing.assert_allclose(rates[0], derivative.value(0.0).ravel(), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(rates[-1], derivative.value(1.0).ravel(), rtol=1e-9, atol=1e-9)


def test_a_fitted_motion_has_the_duration_of_its_curve(pillar):
    problem = RefineProblem.of(pillar.world, pillar.request, no_hurry())
    evaluation = whole_descent(problem).best
    assert evaluation is not None
    motion = fit_motion(evaluation.points, evaluation.path_velocity, 24, 2)
    assert motion.duration == pytest.approx(evaluation.duration, rel=1e-9)
    curve, near = problem.curve_of(evaluation), problem.chart.curve(motion.points)
    s = np.linspace(0.0, 1.0, 200)
    distances = np.linalg.norm(near.positions(s)[:, None] - curve.positions(s)[None], axis=2).min(
        axis=1
    )
    assert distances.max() < 0.05


def test_a_motion_beyond_its_rates_is_slowed_until_it_keeps_them(pillar):
    problem = RefineProblem.of(pillar.world, pillar.request, no_hurry())
    bounds = replace(problem.rate_bounds, jerk=np.full(6, 40.0), loads=())
    motion = SplineMotion(problem.fit_path(0.15), 0.5).with_ends_of(problem.waypoints, 3)
    time_scaling = rate_time_scaling(motion, bounds)
    assert time_scaling > 1
    slower = SplineMotion(motion.points, motion.duration * time_scaling)
    assert rate_time_scaling(slower, bounds) == pytest.approx(1.0)
    trajectory = slower.trajectory(problem.chart)
    times = np.linspace(0.0, trajectory.duration, 2001)
    for order, bound in enumerate((bounds.velocity, bounds.acceleration, bounds.jerk), start=1):
        assert (np.abs(trajectory.tangents(times, order)) <= bound * 1.001).all()
