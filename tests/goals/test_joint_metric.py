"""The weighted joint metric."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.geometry.pose import Pose
from planning.domain.request.options import IkOptions
from planning.domain.robot.joints import JointType
from planning.errors import ProblemInvalid, UnknownName
from planning.goals.joint_metric import JointMetric
from tests.conftest import group_of, random_waypoints
from tests.goals.conftest import ask, at, world_by


@given(
    seed=st.integers(0, 2**32 - 1),
    kinds=st.lists(st.sampled_from(list(JointType)), min_size=1, max_size=4),
)
def test_weights_scale_their_joints_part(seed: int, kinds: list[JointType]) -> None:
    group = group_of(*kinds)
    rows = random_waypoints(group, seed, 5)
    plain = JointMetric.from_names(group, {})
    ones = JointMetric.from_names(group, {joint.name: 1.0 for joint in group.joints})
    np.testing.assert_allclose(plain.distance(rows, rows[0]), ones.distance(rows, rows[0]))
    squares = sum(
        JointMetric.from_names(
            group, {other.name: float(other is joint) for other in group.joints}
        ).distance(rows, rows[0])
        ** 2
        for joint in group.joints
    )
    np.testing.assert_allclose(np.sqrt(squares), plain.distance(rows, rows[0]), atol=1e-9)


def test_nearest_first_is_nearest_by_the_weights() -> None:
    world = world_by("ur5e_pickup", "kernel")
    group, home = world.group("arm"), world.positions(world.group("arm"))
    goal = at(Pose.from_parts([0.45, 0.25, 0.45], rpy=[np.pi, 0, 0.3]))
    weights = {"arm::elbow_joint": 10.0, "arm::shoulder_pan_joint": 0.0}
    found = ask(world, "arm", goal, IkOptions(100, 300, weights))
    plain = ask(world, "arm", goal, IkOptions(100, 300))
    factors = np.array([weights.get(joint.name, 1.0) for joint in group.joints])
    distances = np.linalg.norm(factors * (found.positions - home), axis=1)
    assert (np.diff(distances) >= -1e-9).all()
    assert not np.array_equal(found.positions, plain.positions)


def test_weights_that_make_no_sense_are_refused() -> None:
    group = world_by("ur5e_pickup", "kernel").group("arm")
    with pytest.raises(UnknownName, match=r"did you mean 'arm::elbow_joint'"):
        JointMetric.from_names(group, {"arm::elbow_jont": 1.0})
    for weight in (-1.0, np.nan, np.inf):
        with pytest.raises(ProblemInvalid, match="finite and not negative"):
            JointMetric.from_names(group, {"arm::elbow_joint": weight})
