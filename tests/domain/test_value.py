"""Values freeze, pickle, compare and hash by content."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from planning.domain.curves.curve import JointSpline
from planning.domain.geometry.pose import Pose
from planning.domain.robot.joints import JointType
from planning.domain.value import digest
from planning.errors import ProblemInvalid
from tests.conftest import group_of, random_waypoints


def test_arrays_are_read_only_copies_also_after_pickling() -> None:
    source = np.array([1.0, 2.0, 3.0])
    pose = Pose(source, np.array([1.0, 0.0, 0.0, 0.0]))
    source[0] = 9.0
    assert pose.position[0] == 1.0
    again = pickle.loads(pickle.dumps(pose))
    for one in (pose, again):
        with pytest.raises(ValueError, match="read-only"):
            one.position[0] = 5.0
    assert again == pose
    assert hash(again) == hash(pose)


def test_one_bit_makes_another_value() -> None:
    group = group_of(JointType.REVOLUTE, JointType.REVOLUTE)
    waypoints = random_waypoints(group, 1, 4)
    spline = JointSpline.through(group.joints, waypoints)
    waypoints[2, 1] = np.nextafter(waypoints[2, 1], 9.0)
    assert JointSpline.through(group.joints, waypoints) != spline


def test_equality_is_that_of_digests() -> None:
    """What is seen at first sight and what is not: arrays, their shapes, and all else."""
    group, other = (group_of(*[JointType.REVOLUTE] * count) for count in (2, 3))
    rows = random_waypoints(group, 1, 4)
    kept = JointSpline.through(group.joints, rows)
    made = [kept, JointSpline.through(group.joints, rows.copy())]
    made += [JointSpline.through(group.joints, rows[:3]), replace(kept, joints=other.joints)]
    made += [replace(kept, bases=bases) for bases in (-kept.bases, kept.bases * np.nan)]
    made.append(replace(kept, bases=made[-1].bases))
    for one in made:
        for another in made:
            assert (one == another) == (digest(one) == digest(another))
    assert made[0] == made[1]
    assert made[-1] == made[-2]


def test_digests_tell_shapes_and_kinds_apart() -> None:
    zeros = np.zeros(4)
    contents = [zeros, zeros.reshape(2, 2), [0.0] * 4, "0000", {"a": 0.0}, None, False, ("a", 0.0)]
    assert len({digest(content) for content in contents}) == len(contents)
    with pytest.raises(TypeError, match="object is not a value"):
        digest(object())


@pytest.mark.parametrize(
    ("parts", "field"),
    [
        ({"position": [0, 0]}, "position"),
        ({"position": [0, 0, float("nan")]}, "position"),
        ({"quaternion": [0, 0, 0, 0]}, "quaternion"),
        ({"quaternion": [1, 0, 0, 0], "rpy": [0, 0, 0]}, "rpy"),
    ],
)
def test_poses_refuse_what_is_none(parts: dict, field: str) -> None:
    with pytest.raises(ProblemInvalid) as refusal:
        Pose.from_parts(**parts)
    assert refusal.value.evidence["field"] == field


def test_pose_algebra() -> None:
    x_ab = Pose.from_parts([1, 2, 3], rpy=[0.1, -0.4, 2.0])
    x_bc = Pose.from_parts([-1, 0, 2], rpy=[1.0, 0.3, -0.2])
    assert np.allclose((x_ab @ x_bc).matrix, x_ab.matrix @ x_bc.matrix)
    assert np.allclose((x_ab @ x_ab.inverse).matrix, np.eye(4), atol=1e-12)
    assert np.allclose(Pose.from_matrix(x_ab.matrix).matrix, x_ab.matrix)


def test_digests_are_those_of_earlier_versions() -> None:
    """They are stored beside plans and scenes: how they are made may change, they may not."""
    pose = Pose(np.array([1.0, 2.0, 3.0]), np.array([1.0, 0.0, 0.0, 0.0]))
    scalars = (1, -1, 2**70, 1.5, float("inf"), True, None, "", "x" * 100, "\ud800", "arm")
    turned = np.arange(6.0).reshape(2, 3).T
    content = (pose, scalars, [turned, np.int32(3)], {"b": (), "a": JointType.REVOLUTE})
    assert digest(content) == "673b50e3b36a2db46acb0a448a78193af1ce173e10ec9552d1b94cf5497feace"
