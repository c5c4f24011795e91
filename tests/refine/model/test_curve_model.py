"""The model predicts the decrease that a small step achieves."""

import numpy as np
import pytest

from planning.domain.request.options import ClearanceObjective
from planning.refine.constraints.clearance_objective import make_clearance_objective
from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.refine.constraints.distance_query import make_distance_query
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.curves.bspline_fit import fit_control_points, unwrapped_waypoints
from planning.refine.descents.trust_region import TrustRegion
from planning.refine.model.curve_model import CurveModel
from tests.profiles import num_cases

NUM_INSTANTS = 60


def model_of(case, objective=None) -> tuple[CurveModel, np.ndarray, RateBounds]:
    path, limits = case.request.path, case.request.limits
    waypoints = unwrapped_waypoints(path)
    bounds = RateBounds.of(limits, limits_jerk=case.request.limits_jerk)
    ends = case.world.embed(path.group, waypoints[[0, -1]])
    buffers = DistanceBuffers.from_ends(case.world, case.request.margins, ends)
    distance_query = make_distance_query(case.world, path.group, buffers)
    guess = fit_control_points(waypoints, bounds.velocity)
    clearance_cost = make_clearance_objective(
        case.world, path.group, case.request.margins, objective
    )
    model = CurveModel(distance_query, limits, bounds, len(guess), NUM_INSTANTS, clearance_cost)
    return model, guess, bounds


@pytest.mark.parametrize("objective", [None, ClearanceObjective(0.08, 5.0)])
@pytest.mark.parametrize("box", [0.001, 0.004])
def test_a_small_step_achieves_what_the_model_predicts(case, box, objective):
    model, points, _ = model_of(case, objective)
    for _ in range(3):
        before = model.evaluate(points)
        points, predicted = model.step(before, box)
        achieved = before.merit - model.evaluate(points).merit
        assert predicted > 0
        assert 0.3 * predicted < achieved < 3 * predicted


def test_a_step_stays_in_its_box_and_holds_the_ends(case):
    model, points, bounds = model_of(case)
    before = model.evaluate(points)
    after, _ = model.step(before, 0.05)
    np.testing.assert_array_equal(after[[0, -1]], points[[0, -1]])
    assert (np.abs(after - points) <= 0.05 * bounds.velocity * (1 + 1e-9)).all()
    limits = case.request.limits
    assert (after >= limits.lower - 1e-9).all()
    assert (after <= limits.upper + 1e-9).all()


def test_distances_that_are_too_short_cost(thin_wall):
    model, points, _ = model_of(thin_wall)
    free = model.evaluate(points)
    through = points.copy()
    through[1:-1] = np.linspace(points[0], points[-1], len(points))[1:-1]
    broken = model.evaluate(through)
    assert broken.duration < free.duration
    assert broken.merit > broken.duration
    before = model.evaluate(through)
    model.add_samples(np.array([0.5, 0.501]))
    assert model.evaluate(through).merit > before.merit


@pytest.mark.parametrize("objective", [None, ClearanceObjective(0.08, 5.0)])
def test_an_evaluation_with_added_instants_is_that_of_all_instants(thin_wall, objective):
    model, points, _ = model_of(thin_wall, objective)
    points[1:-1] = np.linspace(points[0], points[-1], len(points))[1:-1]
    first = model.evaluate(points)
    for added in ([0.31, 0.5], [0.503]):
        model.add_samples(np.array(added))
        again, whole = model.evaluate_again(first), model.evaluate(points)
        assert again.merit == pytest.approx(whole.merit, abs=1e-9)
        assert (again.objective, again.num_instants) == (whole.objective, whole.num_instants)
        ours, theirs = again.distances, whole.distances
        assert len(ours.sample_indices) > len(first.distances.sample_indices)
        np.testing.assert_array_equal(ours.sample_indices, theirs.sample_indices)
        np.testing.assert_allclose(ours.signed_margins, theirs.signed_margins, atol=1e-9)
        np.testing.assert_allclose(ours.gradients, theirs.gradients, atol=1e-6)
        first = again


def test_a_violated_distance_is_repaired(thin_wall):
    model, points, _ = model_of(thin_wall)
    # Pushed into the end of the wall a little.
    low = points - 0.03 * np.exp(-(((np.arange(len(points)) - 6.5) / 3) ** 2))[:, None] * [0, 1]
    low[[0, -1]] = points[[0, -1]]
    while (model.evaluate(low).distances.signed_margins > -0.002).all():
        low[1:-1, 1] -= 0.01
    before = model.evaluate(low)
    after = model.evaluate(model.step(before, 0.05)[0])
    assert after.distances.signed_margins.min() > before.distances.signed_margins.min()


@pytest.mark.parametrize("objective", [None, ClearanceObjective(0.08, 5.0)])
def test_only_trials_above_the_merit_are_left_out(case, objective):
    model, points, bounds = model_of(case, objective)
    rng = np.random.default_rng(4)
    current, outcomes = model.evaluate(points), set[bool]()
    for scale in np.geomspace(0.001, 0.5, num_cases(12)):
        trial = points.copy()
        trial[1:-1] += scale * bounds.velocity * rng.uniform(-1, 1, trial[1:-1].shape)
        whole = model.evaluate(trial)
        for merit in whole.merit * np.array([0.3, 0.9, 1 - 1e-6, 1 + 1e-6, 3.0]):
            found = model.evaluate_trial(trial, current, merit)
            outcomes.add(found is None)
            if found is None:
                assert whole.merit > merit
            else:
                assert found.merit == whole.merit
                np.testing.assert_array_equal(found.path_velocity, whole.path_velocity)
                np.testing.assert_array_equal(found.distances.gradients, whole.distances.gradients)
    assert outcomes == {True, False}


class WholeTrials:
    """A model all of whose trials are evaluated."""

    def __init__(self, model: CurveModel) -> None:
        self.evaluate, self.step = model.evaluate, model.step

    def evaluate_trial(self, points, current, merit):
        return self.evaluate(points)


def test_a_descent_goes_the_same_way_with_trials_left_out(case):
    model, points, _ = model_of(case)
    descents = [TrustRegion(m, model.evaluate(points)) for m in (model, WholeTrials(model))]
    with_trials_left_out, whole = ([e.points for e in d.run(15)] for d in descents)
    assert descents[0].num_steps == descents[1].num_steps
    np.testing.assert_array_equal(with_trials_left_out, whole)
