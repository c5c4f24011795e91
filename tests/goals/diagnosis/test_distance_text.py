"""Small distances are written with enough digits; a violated margin is no collision."""

from collections.abc import Callable

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import JointGoal, PoseGoal, PoseTarget
from planning.domain.request.options import IkOptions
from planning.errors import (
    GoalInCollision,
    GoalTooNear,
    GoalUnreachable,
    PlanningFailure,
    StartInCollision,
    StartTooNear,
)
from planning.goals.diagnosis.distance_text import degrees, millimetres
from planning.world.world import World
from tests.clocks import no_hurry

LIMIT = '<limit lower="-3" upper="3" velocity="1" effort="9"/>'
EXACT = np.zeros(3)


def joint(i: int, axis: str, kind: str = "revolute", length: float = 0.3) -> str:
    return (
        f'<joint name="j{i}" type="{kind}"><parent link="l{i - 1}"/><child link="l{i}"/>'
        f'<origin xyz="0 0 {length if i > 1 else 0}"/><axis xyz="{axis}"/>{LIMIT}</joint>'
    )


# Turns, bends three times in one plane, and turns its tool: five joints, so that a tool that is to
# look straight down misses that plane by what is rounded.
FIVE = "".join([
    '<robot name="m">',
    *(f'<link name="l{i}"/>' for i in range(6)),
    joint(1, "0 0 1"),
    *(joint(i, "0 1 0") for i in (2, 3, 4)),
    joint(5, "0 0 1", length=0.1),
    "</robot>",
])
# A ball of 0.1 m that slides along x.
BALL = '<link name="l1"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
SLIDE = f'<robot name="m"><link name="l0"/>{BALL}{joint(1, "1 0 0", "prismatic")}</robot>'


def failing(world: World, goal: PoseGoal | JointGoal, **more: object) -> PlanningFailure:
    with pytest.raises(PlanningFailure) as caught:
        planning.plan(planning.PlanningProblem("r", goal, **more), world, deadline=no_hurry())
    return caught.value


def test_pi_of_six_digits_misses_by_digits_that_show(urdf_world: Callable[..., World]) -> None:
    world = urdf_world(FIVE)
    position, options = np.array([0.35, 0.35, 0.2]), IkOptions(5, 40)
    found = []
    for roll in (np.pi, 3.14159):
        pose = Pose.from_parts(position, rpy=(roll, 0, 0.3))
        goal = PoseGoal((PoseTarget(pose),), "r::l5", EXACT, EXACT)
        try:
            found.append(planning.solve_ik(world, "r", goal, deadline=no_hurry(), options=options))
        except GoalUnreachable as failure:
            found.append(failure)
    exact, rounded = found
    assert not isinstance(exact, GoalUnreachable)
    assert isinstance(rounded, GoalUnreachable)
    assert "0.0 mm" not in rounded.detail
    assert "0.00 deg" not in rounded.detail
    assert "give a `tolerance`" in rounded.detail
    nearest = rounded.evidence["nearest"]
    assert 0 < nearest["rotation_error"] < 1e-4


def test_a_far_miss_is_not_blamed_on_rounding(urdf_world: Callable[..., World]) -> None:
    goal = PoseGoal((PoseTarget(Pose.from_parts((3, 0, 0))),), "r::l5", EXACT, EXACT)
    with pytest.raises(GoalUnreachable) as refusal:
        planning.solve_ik(
            urdf_world(FIVE), "r", goal, deadline=no_hurry(), options=IkOptions(5, 10)
        )
    assert " mm and " in refusal.value.detail
    assert "tolerance" not in refusal.value.detail


@pytest.mark.parametrize(
    ("value", "length", "angle"),
    [
        (0.0, "0.0 mm", "0.00 deg"),
        (1.3e-9, "1.3e-06 mm", "7.4e-08 deg"),
        (4e-5, "0.04 mm", "0.0023 deg"),
        (0.0125, "12.5 mm", "0.72 deg"),
    ],
)
def test_only_nothing_reads_as_nothing(value: float, length: str, angle: str) -> None:
    assert (millimetres(value), degrees(value)) == (length, angle)


WALL = {"name": "wall", "shape": {"box": [0.2, 1, 1]}, "pose": {"position": [1, 0, 0]}}


@pytest.mark.parametrize(
    ("at", "margin", "start", "goal", "words"),
    [
        # the ball is at the wall from x = 0.8 on
        (0.79, 0.02, StartTooNear, GoalTooNear, "10.0 mm apart with a margin of 20.0 mm"),
        (0.81, 0.02, StartInCollision, GoalInCollision, "r::l1-wall by 10.0 mm"),
        (0.81, 0.0, StartInCollision, GoalInCollision, "r::l1-wall by 10.0 mm"),
    ],
)
def test_a_margin_that_is_not_kept_is_no_collision(
    urdf_world: Callable[..., World],
    at: float,
    margin: float,
    start: type[PlanningFailure],
    goal: type[PlanningFailure],
    words: str,
) -> None:
    world = urdf_world(SLIDE, objects=[WALL], margin=margin)
    there, away = np.array([at]), JointGoal(np.array([[0.0]]))
    refused = failing(world, away, start=there), failing(world, JointGoal(there[None]))
    tool = PoseGoal((PoseTarget(Pose.from_parts((at, 0, 0))),), "r::l1", EXACT, EXACT)
    with pytest.raises(PlanningFailure) as caught:
        planning.solve_ik(world, "r", tool, deadline=no_hurry(), options=IkOptions(1, 4))
    posed = caught.value
    assert [type(failure) for failure in (*refused, posed)] == [start, goal, goal]
    for failure in (*refused, posed):
        assert words in failure.detail
        collides = "collides" in failure.detail or "reach the goal collide" in failure.detail
        assert collides is (start is StartInCollision), failure.detail
    (pair,) = refused[0].evidence["pairs"]
    assert pair["margin"] == margin
    assert pair["distance"] == pytest.approx(0.8 - at)
    assert pair["depth"] == pytest.approx(margin - (0.8 - at))


def test_one_that_only_breaks_a_margin_is_what_is_told_of(urdf_world: Callable[..., World]) -> None:
    world = urdf_world(SLIDE, objects=[WALL], margin=0.02)
    failure = failing(world, JointGoal(np.array([[0.9], [0.79], [0.95]])))
    assert isinstance(failure, GoalTooNear)
    assert "10.0 mm apart" in failure.detail
    assert failure.evidence["pairs"][0]["distance"] == pytest.approx(0.01)
