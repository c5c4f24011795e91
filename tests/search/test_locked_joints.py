"""Locked joints stay, and the oracle checks configurations of the whole group."""

import numpy as np
import pytest

from planning.domain.request.options import SearchOptions
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointType
from planning.errors import NoPathFound
from planning.search.locked_joints import JointLock, search_with_locked_joints
from planning.search.request import SearchTask
from tests.clocks import no_hurry
from tests.conftest import group_of, limits_of

KINDS = (JointType.REVOLUTE, JointType.FLOATING, JointType.CONTINUOUS, JointType.REVOLUTE)


class Hole:
    """Everything is free but a slab in the first coordinate, with a way round by the second."""

    def is_free(self, q: np.ndarray) -> bool:
        assert len(q) == 3
        return bool(self.are_free(q[None])[0])

    def are_free(self, qs: np.ndarray) -> np.ndarray:
        return (np.abs(qs[:, 0]) > 0.2) | (qs[:, 2] > 1.0)

    def is_motion_free(
        self, origin: np.ndarray, displacement: np.ndarray, resolution: float
    ) -> bool:
        count = int(np.linalg.norm(displacement) / resolution) + 2
        return bool(self.are_free(origin + np.linspace(0, 1, count)[:, None] * displacement).all())

    def are_motions_free(
        self, origins: np.ndarray, displacements: np.ndarray, resolution: float
    ) -> np.ndarray:
        pairs = zip(origins, displacements, strict=True)
        return np.array([self.is_motion_free(a, b, resolution) for a, b in pairs], dtype=bool)


def task_to(*goals: list[float]) -> SearchTask:
    start = np.array([-1.0, 0.3, 0.0])
    return SearchTask(start, np.array(goals), SearchOptions(), 0.05, 0.0, 1)


def found(task: SearchTask, locked: str) -> object:
    group = group_of(*[JointType.REVOLUTE] * 3)
    deadline = no_hurry(20.0)
    watch = Stopwatch(deadline.clock)
    limits = limits_of(group)
    return search_with_locked_joints(
        group, frozenset({locked}), limits, Hole(), task, deadline, watch
    )


def test_the_locked_joint_stays_all_the_way() -> None:
    result = found(task_to([1.0, 0.4, 0.0], [1.0, 0.3, 0.0]), "g::j1")
    assert result.goal_row == 1
    waypoints = result.path.waypoints
    assert len(waypoints) > 2
    assert (waypoints[:, 1] == 0.3).all()
    np.testing.assert_allclose(waypoints[[0, -1], 0], [-1.0, 1.0])


def test_a_goal_elsewhere_is_none() -> None:
    with pytest.raises(NoPathFound) as caught:
        found(task_to([1.0, 0.4, 0.0]), "g::j1")
    assert caught.value.evidence["locked"] == ["g::j1"]


def test_coordinates_are_put_back_where_they_belong() -> None:
    group = group_of(*KINDS)
    start = np.arange(10.0)
    lock = JointLock(group, frozenset({"g::j1", "g::j3"}), start)
    assert [joint.name for joint in lock.free.joints] == ["g::j0", "g::j2"]
    assert lock.free_q_indices.tolist() == [0, 8]
    assert lock.free_v_indices.tolist() == [0, 7]
    whole = lock.expand(np.array([[-1.0, -2.0]]))[0]
    np.testing.assert_array_equal(whole, [-1, 1, 2, 3, 4, 5, 6, 7, -2, 9])
    np.testing.assert_array_equal(
        lock.expand_tangents(np.array([5.0, 6.0])), [5, 0, 0, 0, 0, 0, 0, 6, 0]
    )
    limits = lock.limits(limits_of(group))
    assert limits.blocks == ((0,), (1,))
    assert len(limits.lower) == len(limits.velocity) == 2
