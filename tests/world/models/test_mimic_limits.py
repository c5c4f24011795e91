"""A follower's limits limit what it follows, and turns count where a follower shows them."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import planning
from planning.domain.robot.followers import Follower, combine_limits
from planning.domain.robot.joints import JointType
from planning.errors import ModelInvalid
from planning.world.world import World
from tests.conftest import group_of, limits_of

LINK = '<link name="{0}_link"/>'
LEADER = """<joint name="a" type="{0}"><parent link="base"/><child link="a_link"/>
<axis xyz="0 0 1"/>{1}</joint>"""
FOLLOWER = """<joint name="{0}" type="{1}"><parent link="base"/><child link="{0}_link"/>
<axis xyz="0 0 1"/>{2}<mimic joint="{3}" multiplier="{4}" offset="{5}"/></joint>"""
WIDE = '<limit lower="-3" upper="3" velocity="1" effort="1"/>'
FREE = '<limit velocity="2" effort="1"/>'


def robot(leader: str, *followers: str, limit: str = WIDE) -> str:
    names = "abc"[: len(followers) + 1]
    links = "".join(LINK.format(name) for name in names)
    joints = LEADER.format(leader, limit) + "".join(followers)
    return f'<robot name="r"><link name="base"/>{links}{joints}</robot>'


def bounded(name: str, low: float, high: float, velocity: float, *led: object) -> str:
    limit = f'<limit lower="{low}" upper="{high}" velocity="{velocity}" effort="1"/>'
    return FOLLOWER.format(name, "revolute", limit, *led)


def test_limits_of_a_chain_are_those_of_what_leads_it(urdf_world: Callable[..., World]) -> None:
    """b = 2 a + 0.1 in +-0.5 at 0.4, c = -3 b - 0.2 = -6 a - 0.5 in [-2, 0.4] at 0.6."""
    world = urdf_world(
        robot(
            "revolute",
            bounded("b", -0.5, 0.5, 0.4, "a", 2, 0.1),
            bounded("c", -2.0, 0.4, 0.6, "b", -3, -0.2),
        )
    )
    group = world.group("r")
    limits = world.limits(group)
    np.testing.assert_allclose([limits.lower[0], limits.upper[0]], [-0.15, 0.2], atol=1e-12)
    # c binds: 0.6 / 6 [rad/s], and what is assumed from its velocity by the same factors.
    np.testing.assert_allclose(
        [limits.velocity[0], limits.acceleration[0], limits.jerk[0]], [0.1, 0.2, 2.0]
    )
    own, followers = world.stated_limits(group)
    assert (own.lower[0], own.upper[0], own.velocity[0]) == (-3.0, 3.0, 1.0)
    assert [f.name for f in followers] == ["r::b", "r::c"]
    assert world.state[world.drake.position_indices(group)][0] == pytest.approx(0.0)


@given(st.integers(0, 9999))
def test_a_leader_within_them_has_all_followers_within_theirs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    group = group_of(JointType.PRISMATIC)
    own = limits_of(group)
    followers = [
        Follower("f", "g::j0", 0, 0, 0, m, b, b - d, b + e, *rng.uniform(0.1, 3.0, 3))
        for m, b, d, e in zip(
            rng.normal(0, 2, 3), rng.normal(0, 1, 3), *rng.uniform(0.1, 5.0, (2, 3)), strict=True
        )
    ]
    limits = combine_limits(own, followers)
    for q in np.linspace(limits.lower[0] - 0.1, limits.upper[0] + 0.1, 97):
        kept = own.lower[0] <= q <= own.upper[0] and all(
            f.lower - 1e-9 <= f.multiplier * q + f.offset <= f.upper + 1e-9 for f in followers
        )
        assert kept == (limits.lower[0] - 1e-9 <= q <= limits.upper[0] + 1e-9)
    for rate in ("velocity", "acceleration", "jerk"):
        shared = getattr(limits, rate)[0]
        used = [abs(f.multiplier) * shared / getattr(f, rate) for f in followers]
        assert max([*used, shared / getattr(own, rate)[0]]) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("low", "high", "multiplier", "offset"), [(7.0, 8.0, 1, 0.0), (0.0, 1.0, 0, 2.0)]
)
def test_a_follower_that_can_be_nowhere_is_refused(
    urdf_world: Callable[..., World], low: float, high: float, multiplier: float, offset: float
) -> None:
    text = robot("revolute", bounded("b", low, high, 1.0, "a", multiplier, offset))
    with pytest.raises(ModelInvalid, match=r"'r::b' \(q = .*'r::a'") as raised:
        urdf_world(text)
    assert raised.value.evidence["joint"] == "r::b"


def test_bundled_grippers_are_limited_as_their_cards_say(world_of: Callable[[str], World]) -> None:
    for scene, name in (("ur5e_pickup", "arm::gripper"), ("panda_shelf", "panda::hand")):
        world = world_of(scene)
        own, followers = world.stated_limits(world.group(name))
        assert len(followers) == 1
        assert world.limits(world.group(name)) == own


def turning(multiplier: float, kind: str = "continuous", limit: str = FREE) -> str:
    return robot("continuous", FOLLOWER.format("b", kind, limit, "a", multiplier, 0), limit=FREE)


@pytest.mark.parametrize(
    ("text", "kind", "winds"),
    [
        (turning(2.0), JointType.CONTINUOUS, False),
        (turning(-1.0), JointType.CONTINUOUS, False),
        (turning(0.0), JointType.CONTINUOUS, False),
        (turning(0.5), JointType.REVOLUTE, True),
        (turning(1.5), JointType.REVOLUTE, True),
        (turning(1.0, "revolute", WIDE), JointType.REVOLUTE, False),
        (turning(1.0, "prismatic", WIDE), JointType.REVOLUTE, True),
    ],
)
def test_turns_are_nothing_only_if_every_follower_says_so(
    urdf_world: Callable[..., World], text: str, kind: JointType, *, winds: bool
) -> None:
    world = urdf_world(text)
    group = world.group("r")
    (leader,) = group.joints
    assert leader.type is kind
    assert group.winding == (("r::a",) if winds else ())
    turn = np.array([2 * np.pi])
    before, after = (world.frame_pose("r::b_link", world.embed(group, q)) for q in (0 * turn, turn))
    same = np.allclose(before.position, after.position)
    same &= abs(np.dot(before.quaternion, after.quaternion)) > 1 - 1e-9
    assert same != winds


def test_a_goal_is_not_reached_a_turn_off_if_what_follows_is_not(
    urdf_world: Callable[..., World],
) -> None:
    """The tool is carried by a follower: of the turns within limits only some reach the goal."""
    tool = bounded("b", -20.0, 20.0, 2.0, "a", 0.5, 0)
    limit = '<limit lower="-13" upper="13" velocity="2" effort="1"/>'
    world = urdf_world(robot("revolute", tool, limit=limit))
    group = world.group("r")
    assert group.winding == ("r::a",)
    wanted = world.frame_pose("r::b_link", world.embed(group, np.array([0.8])))
    solved = planning.solve_ik(
        world,
        "r",
        planning.PoseGoal((planning.PoseTarget(wanted),), "r::b_link", np.zeros(3), np.zeros(3)),
        deadline=planning.Deadline.after(60.0, lambda: 0.0),
    )
    assert len(solved.positions) > 0
    for q in solved.positions:
        there = world.frame_pose("r::b_link", world.embed(group, q))
        assert abs(np.dot(there.quaternion, wanted.quaternion)) > 1 - 1e-9
