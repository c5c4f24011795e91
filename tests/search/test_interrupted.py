"""A known path is returned if the search for a better one is interrupted, at any stage."""

from dataclasses import replace

import numpy as np
import pytest

from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RoadmapOptions, SearchOptions
from planning.errors import Canceled, DeadlineExceeded
from planning.search.request import SearchTask
from planning.search.roadmap.build import RoadmapBuildRequest, grow_roadmap
from planning.search.solver import search
from tests.search.conftest import Oracle, beyond_wall

START = np.array([-0.8, -0.8])
# The first one is behind the wall, the second one far, but in sight.
NEAR, FAR = [0.15, -0.8], [-0.8, 1.0]


class Led:
    """Guide with a path around the top of the wall."""

    name = "led"

    def propose_path(self, goals):
        return np.array([START, [-0.8, 0.8], [0.15, 0.8], goals[0]]), 0


class Ending(Oracle):
    """A world in which time, or patience, ends once a motion has been found free, or blocked."""

    def __init__(self, verdict):
        super().__init__(beyond_wall)
        self._verdict = verdict
        self.is_over = False

    def is_motion_free(self, origin, displacement, resolution):
        found = super().is_motion_free(origin, displacement, resolution)
        self.is_over |= found == self._verdict
        return found


def asked(who, plane, wall, soon, goals, **options):
    task = SearchTask(START, np.array(goals), SearchOptions(**options), 0.05, 0.0, 0)
    if who == "guide":
        return replace(task, guide=Led())
    if who == "roadmap":
        few = SearchOptions(roadmap=RoadmapOptions(states=60, neighbours=6))
        recipe = RoadmapBuildRequest.from_search(*plane, START, few)
        return replace(task, roadmap=grow_roadmap(recipe, wall, "key", soon))
    return task


WHO = pytest.mark.parametrize("who", ["guide", "roadmap", "planner"])


@WHO
def test_the_deadline_returns_the_straight_line(who, plane, wall, soon):
    task, oracle = asked(who, plane, wall, soon, [NEAR, FAR]), Ending(verdict=True)
    deadline = Deadline.after(1.0, lambda: 2.0 * float(oracle.is_over))
    found = search(*plane, oracle, task, deadline)
    assert found.report.direct
    np.testing.assert_array_equal(found.path.waypoints, [START, FAR])
    assert not found.report.was_canceled
    if who == "roadmap":
        assert found.report.roadmap.reason == "interrupted"


@WHO
def test_a_cancel_with_best_returns_the_straight_line(who, plane, wall, soon):
    for on_cancel in ("best", "discard"):
        task = asked(who, plane, wall, soon, [NEAR, FAR], on_cancel=on_cancel)
        oracle = Ending(verdict=True)
        deadline = Deadline.after(9.0, soon.clock, lambda oracle=oracle: oracle.is_over)
        if on_cancel == "best":
            found = search(*plane, oracle, task, deadline)
            assert found.report.direct
            assert found.report.was_canceled
        else:
            with pytest.raises(Canceled):
                search(*plane, oracle, task, deadline)


@WHO
def test_the_deadline_without_any_path_is_an_error_with_evidence(who, plane, wall, soon):
    task, oracle = asked(who, plane, wall, soon, [NEAR]), Ending(verdict=False)
    deadline = Deadline.after(1.0, lambda: 2.0 * float(oracle.is_over))
    with pytest.raises(DeadlineExceeded) as caught:
        search(*plane, oracle, task, deadline)
    evidence = caught.value.evidence
    assert evidence["allowed"] == 1.0
    assert evidence["num_goals"] == 1
    assert evidence["num_states_checked"] > 0
    assert (who == "roadmap") == (evidence.get("roadmap", {}).get("reason") == "interrupted")
