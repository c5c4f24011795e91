"""Joints that follow others, in whatever order a file lists them."""

from collections.abc import Callable
from itertools import permutations

import numpy as np
import pytest

from planning.certify.clearance.motion_bounds import moving_joints
from planning.domain.robot.payload import Payload
from planning.errors import ModelInvalid
from planning.world.constraints.body_pairs import moved_bodies
from planning.world.mechanics.dynamics import GroupDynamics, validate_payload
from planning.world.mechanics.simulation import Simulation
from planning.world.world import World

LINK = """<link name="{0}"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{0}" type="{1}"><parent link="base"/><child link="{0}_link"/>
<axis xyz="1 0 0"/><limit lower="-3" upper="3" effort="100" velocity="1"/>{2}</joint>"""
# b = 2 a + 0.1 and c = 3 b - 0.2, so c = 6 a + 0.1.
JOINTS = {
    "a": "",
    "b": '<mimic joint="a" multiplier="2" offset="0.1"/>',
    "c": '<mimic joint="b" multiplier="3" offset="-0.2"/>',
}
ORDERS = list(permutations(JOINTS))


def robot(joints: dict[str, str], order: tuple[str, ...], kind: str = "prismatic") -> str:
    links = LINK.format("base") + "".join(LINK.format(f"{name}_link") for name in joints)
    return (
        f'<robot name="r">{links}{"".join(JOINT.format(n, kind, joints[n]) for n in order)}</robot>'
    )


@pytest.mark.parametrize("order", ORDERS, ids="".join)
def test_followers_of_followers_are_where_they_belong(
    urdf_world: Callable[..., World], order: tuple[str, ...]
) -> None:
    world = urdf_world(robot(JOINTS, order))
    group, model = world.group("r"), world.drake
    assert [joint.name for joint in group.joints] == ["r::a"]
    for a in (-0.3, 0.0, 0.2):
        full = world.embed(group, np.array([a]))
        for name, expected in (("a", a), ("b", 2 * a + 0.1), ("c", 6 * a + 0.1)):
            place = world.frame_pose(f"r::{name}_link", full).position
            np.testing.assert_allclose(place, [expected, 0.0, 0.0], atol=1e-12)
    assert {m.joint.name(): m.scale for m in moving_joints(model, group)} == {
        "a": 1.0,
        "b": 2.0,
        "c": 6.0,
    }
    assert moved_bodies(model, group) == {"r::a_link", "r::b_link", "r::c_link"}


@pytest.mark.parametrize("order", ORDERS, ids="".join)
def test_followers_of_followers_burden_the_first(
    urdf_world: Callable[..., World], order: tuple[str, ...]
) -> None:
    """Sliders of 1 kg that go 1, 2 and 6 times as fast are as hard to push as 1 + 4 + 36 kg."""
    world = urdf_world(robot(JOINTS, order))
    group = world.group("r")
    validate_payload(world, group, Payload("r::c_link", 1.0))
    still, pushed = np.zeros((1, 1)), np.ones((1, 1))
    efforts = GroupDynamics(world, group).efforts(still, still, pushed)
    assert efforts[0, 0] == pytest.approx(41.0)


@pytest.mark.parametrize("order", ORDERS, ids="".join)
def test_followers_of_followers_follow_in_a_simulation(
    urdf_world: Callable[..., World], order: tuple[str, ...]
) -> None:
    world = urdf_world(robot(JOINTS, order))
    group = world.group("r")
    simulation = Simulation(world, group, np.zeros(1))
    simulation.command(np.array([0.1]), np.zeros(1), np.zeros(1))
    simulation.advance_to(0.5)
    q = world.drake.plant.GetPositions(simulation._context)
    assert simulation.q[0] == pytest.approx(0.1, abs=1e-3)
    np.testing.assert_allclose(q, world.embed(group, simulation.q), atol=1e-3)


def test_joints_that_follow_each_other_are_refused(urdf_world: Callable[..., World]) -> None:
    joints = {"a": "", "b": '<mimic joint="c"/>', "c": '<mimic joint="b"/>'}
    with pytest.raises(ModelInvalid, match="form a cycle") as raised:
        urdf_world(robot(joints, ("a", "b", "c")))
    assert raised.value.evidence["joints"] == ["b", "c"]


def test_a_joint_of_several_coordinates_leads_nobody(urdf_world: Callable[..., World]) -> None:
    with pytest.raises(ModelInvalid, match="one coordinate"):
        urdf_world(robot({"a": "", "b": '<mimic joint="a"/>'}, ("a", "b"), "planar"))
