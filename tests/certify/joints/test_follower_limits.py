"""Followers (mimic joints) keep their own limits, and clearance uses their own positions."""

from collections.abc import Callable

import numpy as np
import pytest

import planning
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.options import RetimeOptions
from planning.world.world import World
from tests.certify.conftest import quintic
from tests.clocks import no_hurry
from tests.profiles import rng_of, seeds

pytestmark = [pytest.mark.usefixtures("implementation")]

JOINT = """<link name="{0}_link"><collision><geometry><box size="0.02 0.02 0.02"/></geometry>
</collision></link><joint name="{0}" type="{1}"><parent link="base"/><child link="{0}_link"/>
<origin xyz="0 0 {2}"/><axis xyz="0 0 1"/>
<limit lower="{3}" upper="{4}" velocity="{5}" effort="1"/>{6}</joint>"""
MIMIC = '<mimic joint="{0}" multiplier="{1}" offset="{2}"/>'
# Of the chain a, b, c: multiplier and offset of each in terms of the one before it.
RATES = ("velocity", "acceleration", "jerk")


def chain(rng: np.random.Generator) -> tuple[str, list[tuple[float, ...]]]:
    """Return a robot of three joints, and (scale, offset, low, high, velocity) of both that follow.

    The position of each follower is scale times that of the first joint, plus offset.
    """
    joints = [JOINT.format("a", "revolute", 0, -3, 3, 1.0, "")]
    scale, offset, followers = 1.0, 0.0, []
    for z, (name, leader) in enumerate(("ba", "cb"), start=1):
        m, b = float(rng.choice([-1, 1]) * rng.uniform(0.3, 3)), float(rng.uniform(-0.5, 0.5))
        scale, offset = m * scale, m * offset + b
        wide = rng.uniform(0.2, 2.0) * abs(scale)
        low, high = offset - wide, offset + wide
        velocity = float(rng.uniform(0.2, 2.0) * abs(scale))
        mimic = MIMIC.format(leader, m, b)
        joints.append(JOINT.format(name, "revolute", z, low, high, velocity, mimic))
        followers.append((scale, offset, low, high, velocity))
    return f'<robot name="r"><link name="base"/>{"".join(joints)}</robot>', followers


@pytest.mark.campaign
def test_follower_motions_are_checked_against_follower_limits(
    urdf_world: Callable[..., World],
) -> None:
    """The oracle is dense samples, which contain the peaks of a quintic."""
    verdicts = set[bool]()
    for seed in seeds(12):
        rng = rng_of(seed)
        text, followers = chain(rng)
        world = urdf_world(text)
        group = world.group("r")
        goal, duration = rng.uniform(-1.5, 1.5, 1), float(rng.uniform(1.0, 10.0))
        motion = quintic(group, np.zeros(1), goal, duration)
        times = np.linspace(0.0, duration, 4001)
        a, v, dv = (motion.tangents(times, k)[:, 0] for k in range(3))
        excess = [max((-3 - a).max(), (a - 3).max())]
        share, push = [np.abs(v).max()], [np.abs(dv).max() / 2]
        for scale, offset, low, high, velocity in followers:
            q = scale * a + offset
            excess.append(max((q - high).max(), (low - q).max()))
            share.append(abs(scale) * np.abs(v).max() / velocity)
            push.append(abs(scale) * np.abs(dv).max() / (2 * velocity))
        certificate, _ = planning.certify_trajectory(world, "r", motion, deadline=no_hurry())
        checks = {check.name: check for check in certificate.checks}
        names = ["r::a", "r::b", "r::c"]
        for name, uses in (("position", excess), ("velocity", share), ("acceleration", push)):
            check = checks[name]
            assert check.value == pytest.approx(max(uses), abs=1e-5)
            assert check.where == names[int(np.argmax(uses))]
            assert check.passed == (max(uses) <= check.bound)
        verdicts.add(certificate.proven)
    assert verdicts == {True, False}


def test_scales_and_jerk_count_for_followers_too(urdf_world: Callable[..., World]) -> None:
    mimic = MIMIC.format("a", 2, 0)
    joints = JOINT.format("a", "revolute", 0, -3, 3, 1, "")
    joints += JOINT.format("b", "revolute", 1, -6, 6, 0.5, mimic)
    world = urdf_world(f'<robot name="r"><link name="base"/>{joints}</robot>')
    motion = quintic(world.group("r"), np.zeros(1), np.array([0.5]), 4.0)
    options = RetimeOptions(method="ruckig", velocity_scale=0.5, acceleration_scale=0.25)
    plain, scaled = (
        planning.certify_trajectory(world, "r", motion, deadline=no_hurry(), options=given)[0]
        for given in (RetimeOptions(method="ruckig"), options)
    )
    for name, factor in zip(RATES, (2.0, 4.0, 4.0), strict=True):
        before, after = (
            next(check for check in made.checks if check.name == name) for made in (plain, scaled)
        )
        assert before.where == after.where == "r::b"
        assert after.value == pytest.approx(factor * before.value, rel=1e-6)


TURN = """<robot name="m"><link name="base"/><link name="a"/><link name="b"><collision>
<origin xyz="0.5 0 0"/><geometry><box size="1 0.02 0.02"/></geometry></collision></link>
<joint name="lead" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
<limit velocity="2" effort="1"/></joint><joint name="follow" type="continuous">
<parent link="base"/><child link="b"/><axis xyz="0 0 1"/><limit velocity="9" effort="1"/>
<mimic joint="lead" multiplier="{0}"/></joint></robot>"""


def in_two_pieces(world: World, jump: float) -> TimedTrajectory:
    """Return 0 to 0.1 to 0.4 rad, the second piece anchored elsewhere by a jump."""
    steps = [[[0], [0], [3 * d], [-2 * d]] for d in (0.1, 0.3)]
    bases = np.array([[0.0], [0.1 + jump]])
    return TimedTrajectory(
        world.group("r").joints, np.arange(3.0), bases, np.array(steps, dtype=np.float64)
    )


@pytest.mark.parametrize(("multiplier", "is_free"), [(0.5, False), (2.0, True)])
def test_a_whole_turn_of_the_leader_is_a_jump_of_a_half_rate_follower(
    urdf_world: Callable[..., World], multiplier: float, *, is_free: bool
) -> None:
    world, turn = urdf_world(TURN.format(multiplier)), 2 * np.pi
    ends = {"start": [turn], "goal": [0.4 - turn]}
    for trajectory, given, broken in (
        (in_two_pieces(world, turn), {}, "continuity"),
        (in_two_pieces(world, 0.0), ends, "start"),
        (in_two_pieces(world, 0.0), ends, "goal"),
    ):
        certificate, _ = planning.certify_trajectory(
            world, "r", trajectory, deadline=no_hurry(), **given
        )
        assert (broken in {check.name for check in certificate.failed}) != is_free
        assert certificate.proven == is_free
    assert planning.certify_trajectory(world, "r", in_two_pieces(world, 0.0), deadline=no_hurry())[
        0
    ].proven


def test_end_distances_count_the_followers(urdf_world: Callable[..., World]) -> None:
    """With a multiplier of 1,000 the start is a micrometre off if the leader is a nanometre off."""
    joints = JOINT.format("a", "prismatic", 0, -3, 3, 1, "")
    joints += JOINT.format("b", "prismatic", 1, -3e3, 3e3, 1e3, MIMIC.format("a", 1000, 0))
    world = urdf_world(f'<robot name="r"><link name="base"/>{joints}</robot>')
    motion = quintic(world.group("r"), np.zeros(1), np.array([0.1]), 3.0)
    for off, is_kept in ((0.9e-9, True), (1.1e-9, False)):
        certificate, _ = planning.certify_trajectory(
            world, "r", motion, deadline=no_hurry(), start=[off]
        )
        assert certificate.proven == is_kept
