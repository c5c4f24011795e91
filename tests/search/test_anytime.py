"""Anytime planners: better paths are reported, and a cancel may return the best."""

from dataclasses import replace

import numpy as np
import pytest

from planning.domain.curves.motion_samples import are_motions_free
from planning.domain.request.deadline import Deadline
from planning.domain.robot.manifold import Manifold
from planning.errors import Canceled
from planning.search.solver import search
from tests.clocks import no_hurry
from tests.search.conftest import Oracle, beyond_wall

TELLING = pytest.mark.parametrize(
    "name", ["RRTstar", "InformedRRTstar", "SORRTstar", "BITstar", "AORRTC"]
)


class Counting(Oracle):
    """The wall; its clock counts the calls of the oracle."""

    def __init__(self, are_free=beyond_wall):
        super().__init__(are_free)
        self.count = 0

    def is_motion_free(self, origin, displacement, resolution):
        self.count += 1
        return super().is_motion_free(origin, displacement, resolution)

    def clock(self):
        return float(self.count)


def is_free(oracle, group, waypoints, resolution=0.05 / 4):
    manifold = Manifold(group.joints)
    motions = waypoints[:-1], manifold.minus(waypoints[1:], waypoints[:-1])
    return are_motions_free(manifold, oracle.are_free, motions, resolution).all()


@TELLING
def test_a_cancel_returns_the_path_that_is_being_improved(plane, wall, crossing, name):
    for on_cancel in ("best", "discard"):
        reports = []
        deadline = no_hurry(9.0, lambda reports=reports: bool(reports))
        task = replace(crossing(planner=name, on_cancel=on_cancel), on_best=reports.append)
        if on_cancel == "discard":
            with pytest.raises(Canceled):
                search(*plane, wall, task, deadline)
            continue
        found = search(*plane, wall, task, deadline)
        assert found.report.was_canceled
        assert found.report.solved == 1
        assert is_free(wall, plane[0], found.path.waypoints)
        np.testing.assert_array_equal(found.path.waypoints[0], task.start)
        # Collisions of the fine check are repaired: the path may be a little longer.
        assert found.report.length <= reports[0].attempt.length * 1.5
        assert reports[0].attempt.outcome == "improving"


@pytest.mark.parametrize("name", ["AORRTC"])
def test_callbacks_change_no_byte(plane, wall, soon, crossing, name):
    reports = []
    silent = search(*plane, wall, crossing(3, planner=name), soon)
    heard = search(*plane, wall, replace(crossing(3, planner=name), on_best=reports.append), soon)
    assert silent.path.waypoints.tobytes() == heard.path.waypoints.tobytes()
    assert silent.report == heard.report
    lengths = [best.attempt.length for best in reports]
    assert lengths == sorted(set(lengths), reverse=True)


class Told(Oracle):
    """The wall; it remembers how closely it was looked at."""

    def __init__(self):
        super().__init__(beyond_wall)
        self.resolutions = set()

    def is_motion_free(self, origin, displacement, resolution):
        self.resolutions.add(resolution)
        return super().is_motion_free(origin, displacement, resolution)


@pytest.mark.parametrize("name", ["RRTstar", "InformedRRTstar", "BITstar"])
def test_a_path_close_to_a_wall_is_repaired_and_not_discarded(plane, soon, crossing, name):
    """A new attempt would check at 0.15, a repaired path is checked at 0.075."""
    for seed in range(2):
        wall = Told()
        found = search(*plane, wall, crossing(seed, planner=name, resolution=0.3), soon)
        assert is_free(wall, plane[0], found.path.waypoints, 0.3 / 4)
        assert wall.resolutions == {0.3, 0.3 / 4}


@TELLING
def test_a_path_that_is_being_improved_is_shown_as_it_is(plane, wall, soon, crossing, name):
    """From the start to the goal, free as the planner looks, and as long as it says."""
    reports = []
    task = replace(crossing(4, planner=name), on_best=reports.append)
    search(*plane, wall, task, soon)
    improving = [best for best in reports if best.attempt.outcome == "improving"]
    assert improving
    for best in improving:
        if name == "BITstar":
            assert best.waypoints.shape == (0, 2)
            continue
        np.testing.assert_array_equal(best.waypoints[0], task.start)
        assert (best.waypoints[-1] == task.goals).all(axis=1).any()
        assert is_free(wall, plane[0], best.waypoints, 0.05)
        steps = np.linalg.norm(np.diff(best.waypoints, axis=0), axis=1)
        assert steps.sum() == pytest.approx(best.attempt.length)


def test_costs_that_are_no_lengths_are_not_reported(plane, wall, soon, crossing):
    reports = []
    task = replace(crossing(planner="AORRTC", objective="duration"), on_best=reports.append)
    assert search(*plane, wall, task, soon).report.solved == 1
    assert reports == []


@pytest.mark.parametrize("name", ["RRTConnect", "PRMstar"])
def test_at_every_cancel_the_path_so_far_is_returned(plane, crossing, name):
    """In the search, in shortcutting and in the final check alike."""
    whole = Counting()
    task = crossing(1, planner=name, on_cancel="best")
    search(*plane, whole, task, no_hurry(9.0))
    outcomes = []
    for share in (0.1, 0.6, 0.95):
        oracle = Counting()
        last = share * whole.count

        def is_canceled(oracle=oracle, last=last):
            return oracle.count >= last

        deadline = no_hurry(9.0, is_canceled)
        try:
            found = search(*plane, oracle, task, deadline)
        except Canceled:
            outcomes.append(False)
        else:
            assert found.report.was_canceled
            assert is_free(oracle, plane[0], found.path.waypoints)
            outcomes.append(True)
    assert outcomes == sorted(outcomes)
    assert outcomes[-1]


def test_after_a_cancel_collisions_of_the_fine_check_are_repaired(plane, crossing):
    """The planner cuts the end of a wall that is thinner than it looks."""

    def are_free(qs):
        return ~((np.abs(qs[:, 0]) < 0.008) & (qs[:, 1] < 0.6))

    def listen(best):
        if best.attempt.outcome == "improving":
            reports.append(best)

    reports, canceled = [], []
    for seed in range(4):
        reports.clear()
        deadline = no_hurry(9.0, lambda: bool(reports))
        task = crossing(seed, resolution=0.06, planner="RRTstar", on_cancel="best")
        oracle = Oracle(are_free)
        found = search(*plane, oracle, replace(task, on_best=listen), deadline)
        assert found.report.was_canceled == bool(reports)
        assert is_free(oracle, plane[0], found.path.waypoints, 0.06 / 4)
        canceled.append(bool(reports))
    assert sum(canceled) >= 2


def test_improvement_leaves_time_for_the_following_stages(plane, crossing):
    """The clock counts calls: the deadline passes long before the planner would have ended."""
    oracle, reports = Counting(), []
    task = crossing(1, planner="SORRTstar")
    patient = Deadline.after(1e9, oracle.clock, lambda: bool(reports))
    with pytest.raises(Canceled):
        search(*plane, oracle, replace(task, on_best=reports.append), patient)
    hasty = Counting()
    found = search(*plane, hasty, task, Deadline.after(1.5 * oracle.count, hasty.clock))
    assert found.report.solved == 1
    assert hasty.count < 1.5 * oracle.count
