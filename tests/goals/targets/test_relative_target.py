"""Relative goals: displacements from the start in the axes of the tool and of other frames."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import RelativeGoal
from planning.domain.request.options import IkOptions
from planning.errors import UnknownName
from tests.goals.conftest import ask, world_by
from tests.profiles import num_cases


@given(
    seed=st.integers(0, 2**32 - 1),
    reference=st.sampled_from(["", "world", "pick", "arm::forearm_link", "arm::tcp"]),
)
@settings(max_examples=num_cases(6))
def test_the_tool_is_displaced_by_the_axes_of_the_reference(seed: int, reference: str) -> None:
    world = world_by("ur5e_pickup", "kernel")
    group = world.group("arm")
    rng = np.random.default_rng(seed)
    by = Pose.from_parts(rng.uniform(-0.05, 0.05, 3), rpy=rng.uniform(-0.3, 0.3, 3))
    found = ask(world, "arm", RelativeGoal(by, "", reference), IkOptions(4, 40), seed)
    assert len(found.positions)
    before = world.frame_pose("arm::tcp", world.state).matrix
    axes = world.frame_pose(reference or "arm::tcp", world.state).matrix[:3, :3]
    for row in found.positions:
        after = world.frame_pose("arm::tcp", world.embed(group, row)).matrix
        np.testing.assert_allclose(after[:3, 3], before[:3, 3] + axes @ by.position, atol=2e-6)
        turn = axes @ by.matrix[:3, :3] @ axes.T
        np.testing.assert_allclose(after[:3, :3], turn @ before[:3, :3], atol=5e-6)


def test_the_tools_own_frame_as_reference_is_no_reference() -> None:
    world = world_by("ur5e_pickup", "kernel")
    by = Pose.from_parts([0.01, -0.02, 0.03], rpy=[0.1, 0.2, -0.1])
    own, named = (
        ask(world, "arm", RelativeGoal(by, "", name), IkOptions(4, 40)) for name in ("", "arm::tcp")
    )
    np.testing.assert_allclose(own.positions, named.positions, atol=1e-6)


def test_no_displacement_is_where_it_is() -> None:
    world = world_by("ur5e_pickup", "kernel")
    found = ask(world, "arm", RelativeGoal(Pose.identity()), IkOptions(4, 40))
    np.testing.assert_allclose(found.positions[0], world.positions(world.group("arm")), atol=1e-6)


def test_a_reference_that_does_not_exist_is_named() -> None:
    world = world_by("ur5e_pickup", "kernel")
    with pytest.raises(UnknownName, match="frame 'pik' does not exist; did you mean 'pick'"):
        ask(world, "arm", RelativeGoal(Pose.identity(), "", "pik"))
