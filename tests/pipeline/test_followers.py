"""Mimic joints: motions keep their limits, and full turns of their leaders count."""

from collections.abc import Callable

import numpy as np
import pytest

import planning
from planning.domain.goals.goal import JointGoal
from planning.domain.request.options import RefineOptions, RetimeOptions
from planning.domain.request.problem import PlanningProblem
from planning.errors import PlanningFailure, StartOutOfLimits
from planning.world.world import World
from tests.clocks import no_hurry

LINK = """<link name="{0}"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0"
ixz="0" iyz="0"/></inertial><collision><origin xyz="{1} 0 0"/><geometry><box size="{2} 0.04 0.04"/>
</geometry></collision></link>"""
JOINT = """<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>
<origin xyz="{4} 0 0"/><axis xyz="0 0 1"/><limit {5} effort="9"/>{6}</joint>"""
WIDE = 'lower="-3" upper="3" velocity="2"'
TIGHT = 'lower="-1" upper="1.2" velocity="0.6"'
MIMIC = '<mimic joint="{0}" multiplier="{1}" offset="{2}"/>'


def arm(shoulder: str, limit: str, follower: str, mimic: str) -> str:
    """Return a shoulder and an elbow in a row; what follows the shoulder hangs on the base."""
    links = [LINK.format("base", 0, 0.05), LINK.format("upper", 0.25, 0.4)]
    links += [LINK.format("fore", 0.2, 0.3), '<link name="gauge"/>']
    joints = [
        JOINT.format("shoulder", shoulder, "base", "upper", 0, limit, ""),
        JOINT.format("elbow", "revolute", "upper", "fore", 0.5, WIDE, ""),
        JOINT.format("follow", follower, "base", "gauge", 0, TIGHT, mimic),
    ]
    return f'<robot name="r">{"".join(links + joints)}</robot>'


def planned(
    world: World, start: list[float], goal: list[float], **options: object
) -> planning.MotionPlan:
    problem = PlanningProblem(
        "r", JointGoal(np.array([goal])), start=np.array(start), seed=3, **options
    )
    return planning.plan(problem, world, deadline=no_hurry())


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
@pytest.mark.parametrize("refine", ["none", "trajopt"])
def test_a_plan_keeps_what_limits_a_follower(
    urdf_world: Callable[..., World], method: str, refine: str
) -> None:
    """The follower is -2 q + 0.1: within -1 and 1.2 for q from -0.55 to 0.55, at 0.3 rad/s."""
    post = {
        "name": "post",
        "shape": {"box": [0.05, 0.05, 0.2]},
        "pose": {"position": [0.72, 0.0, 0.0]},
    }
    mimic = MIMIC.format("shoulder", -2, 0.1)
    world = urdf_world(arm("revolute", WIDE, "revolute", mimic), objects=[post])
    found = planned(
        world,
        [-0.5, 0.0],
        [0.5, 0.0],
        refine=RefineOptions(refine),
        retime=RetimeOptions(method=method),
    )
    assert found.certificate.proven
    assert not found.stages.search.direct
    times = np.linspace(0.0, found.trajectory.duration, 3001)
    follower = -2 * found.trajectory.positions(times)[:, 0] + 0.1
    assert follower.min() >= -1 - 1e-6
    assert follower.max() <= 1.2 + 1e-6
    speed = 2 * np.abs(found.trajectory.velocities(times)[:, 0])
    push = 2 * np.abs(found.trajectory.accelerations(times)[:, 0])
    assert speed.max() <= 0.6 * (1 + 1e-5)
    assert push.max() <= 1.2 * (1 + 1e-5)
    # It is the follower's speed or push that it takes its time for.
    assert max(speed.max() / 0.6, push.max() / 1.2) > 0.9


def test_goals_and_starts_beyond_what_a_follower_may_are_refused(
    urdf_world: Callable[..., World],
) -> None:
    world = urdf_world(arm("revolute", WIDE, "revolute", MIMIC.format("shoulder", -2, 0.1)))
    with pytest.raises(PlanningFailure):
        planned(world, [0.0, 0.0], [0.7, 0.0])
    with pytest.raises(StartOutOfLimits):
        planned(world, [0.7, 0.0], [0.0, 0.0])
    for q, valid in ((0.54, True), (0.56, False)):
        (verdict,) = planning.check_configurations(world, "r", np.array([[q, 0.0]]))
        assert verdict.valid == valid


@pytest.mark.parametrize("is_bounded", [True, False])
def test_an_endless_joint_unwinds_what_follows_it_by_half(
    urdf_world: Callable[..., World], *, is_bounded: bool
) -> None:
    """From one side to the other of the half turn: the short way on a circle is the wrong one."""
    text = arm("continuous", 'velocity="2"', "continuous", MIMIC.format("shoulder", 0.5, 0))
    wide = 'lower="-1.5" upper="1.5" velocity="9"' if is_bounded else 'velocity="9"'
    kind = "revolute" if is_bounded else "continuous"
    text = text.replace(TIGHT, wide).replace(
        'name="follow" type="continuous"', f'name="follow" type="{kind}"'
    )
    world = urdf_world(text)
    start, goal = [2.9, 0.0], [-2.9, 0.4]
    found = planned(world, start, goal)
    assert found.certificate.proven
    np.testing.assert_allclose(found.trajectory.start, start, atol=1e-9)
    np.testing.assert_allclose(found.trajectory.end, goal, atol=1e-9)
    q = found.trajectory.positions(np.linspace(0.0, found.trajectory.duration, 500))
    assert np.abs(np.diff(q[:, 0])).max() < 0.2
