"""Continuous joints, alone and on a sliding base, in all stages."""

from collections.abc import Callable

import numpy as np
import pytest

import planning
from planning.domain.goals.goal import JointGoal
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RefineOptions
from planning.domain.request.problem import PlanningProblem
from planning.world.world import World

LINK = """<link name="{0}"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0"
ixz="0" iyz="0"/></inertial><collision><origin xyz="0.25 0 0"/><geometry><box size="0.4 0.04 0.04"/>
</geometry></collision></link>"""
ARM = """<robot name="r"><link name="base"/><link name="cart"/>{a}{b}
<joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="9" velocity="1"/></joint>
<joint name="shoulder" type="continuous"><parent link="cart"/><child link="a"/><axis xyz="0 0 1"/>
<limit effort="9" velocity="2"/></joint>
<joint name="elbow" type="continuous"><parent link="a"/><child link="b"/>
<origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit effort="9" velocity="2"/></joint></robot>"""


def post_at(x: float) -> dict[str, object]:
    return {
        "name": "post",
        "shape": {"box": [0.1, 0.1, 0.4]},
        "pose": {"position": [x, 0.0, 0.0]},
    }


@pytest.mark.parametrize("method", ["none", "trajopt"])
@pytest.mark.parametrize("is_behind", [True, False])
def test_they_go_the_short_way_round_unless_something_is_there(
    urdf_world: Callable[..., World], deadline: Deadline, method: str, *, is_behind: bool
) -> None:
    text = ARM.format(a=LINK.format("a"), b=LINK.format("b"))
    arm = urdf_world(text, objects=[post_at(-0.6 if is_behind else 0.6)])
    start, goal = np.array([0.0, 2.6, 0.0]), np.array([0.2, -2.6, 0.3])
    problem = PlanningProblem(
        "r", JointGoal(goal[None]), start=start, refine=RefineOptions(method), seed=3
    )
    found = planning.plan(problem, arm, deadline=deadline)
    assert found.certificate.proven
    assert found.certificate.min_clearance > 0
    end = found.trajectory.end
    np.testing.assert_allclose(np.cos(end - goal), 1.0, atol=1e-9)
    qs = found.trajectory.positions(np.linspace(0, found.trajectory.duration, 500))
    assert np.abs(np.diff(qs, axis=0)).max() < 0.1  # no jump by a whole turn
    # Straight on, the shoulder passes the half turn, where the post is behind.
    assert found.stages.search.direct != is_behind
    if not is_behind:
        assert 0 < end[1] - start[1] < 1.1
