"""Reversed plans: the same configurations in reverse order, certified again."""

from dataclasses import replace

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import Goal, JointGoal, LineGoal, PoseGoal, PoseTarget
from planning.domain.report.motion_plan import MotionPlan
from planning.domain.request.constraint import PlacedBox, TightLimits
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import SpeedZone, ToolLimit
from planning.domain.request.options import CertifyOptions, RetimeOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.errors import NotCertified
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world

ZERO = np.zeros(3)
PICK = PoseGoal((PoseTarget(Pose.identity(), "pick"),), "", ZERO, ZERO, np.array([0, 0, -0.1]))


def soon() -> Deadline:
    return no_hurry(60.0)


def problem_of(
    goal: Goal, method: str = "toppra", group: str = "arm", *, stop_anywhere: bool = False
) -> PlanningProblem:
    return PlanningProblem(
        group,
        goal,
        search=SearchOptions(num_states=20, approach_states=10),
        refine=planning.RefineOptions("none"),
        retime=RetimeOptions(method="ruckig" if method == "ruckig" else "toppra"),
        certify=CertifyOptions(stop_anywhere=stop_anywhere),
        seed=3,
    )


def back_of(world: World, problem: PlanningProblem, found: MotionPlan) -> MotionPlan:
    return planning.reverse_plan(world, problem, found.path, found.trajectory, found.parts, soon())


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_the_way_back_is_the_way_there(pickup: World, method: str) -> None:
    problem = problem_of(PICK, method, stop_anywhere=True)
    found = planning.plan(problem, pickup, deadline=soon())
    back = back_of(pickup, problem, found)
    times = np.linspace(0.0, found.trajectory.duration, 200)
    there = found.trajectory.positions(found.trajectory.duration - times)
    np.testing.assert_allclose(back.trajectory.positions(times), there, atol=1e-9)
    np.testing.assert_array_equal(back.path.waypoints, found.path.waypoints[::-1])
    np.testing.assert_allclose(back.start, found.trajectory.end, atol=1e-12)
    np.testing.assert_allclose(back.goal_configuration, found.start, atol=1e-6)
    assert back.certificate.proven
    assert {check.name for check in back.certificate.checks} == {
        check.name for check in found.certificate.checks
    }
    assert [part.kind for part in back.parts] == ["retreat", "free"]
    assert back.parts[0].end == back.parts[1].begin
    assert back.parts[0].length == found.parts[1].length
    assert back.stages.certify.stop is not None
    assert back.stages.retime.duration == found.trajectory.duration
    assert back.digest != found.digest
    again = back_of(pickup, problem, back)
    twice = again.trajectory.positions(times)
    np.testing.assert_allclose(twice, found.trajectory.positions(times), atol=1e-9)
    assert [part.kind for part in again.parts] == ["free", "approach"]


def test_the_way_back_tells_how_much_of_every_limit_it_uses(pickup: World) -> None:
    box = PlacedBox(np.full(3, 0.1), pickup.frame_pose("arm::tcp", pickup.state))
    options = RetimeOptions(
        effort=True,
        tool_limits=(
            ToolLimit("arm::tcp", 0.3, 1.0),
            ToolLimit("arm::forearm_link", 5.0),
        ),
        speed_zones=(SpeedZone("start", "arm::tcp", box, 0.1),),
    )
    home = pickup.positions(pickup.group("arm"))
    problem = replace(problem_of(JointGoal((home + 0.1)[None])), retime=options)
    found = planning.plan(problem, pickup, deadline=soon())
    there, back = found.stages.retime, back_of(pickup, problem, found).stages.retime
    assert set(back.utilisation) == set(there.utilisation)
    assert back.utilisation == pytest.approx(there.utilisation, rel=5e-3)
    assert back.binding == there.binding
    assert back.binding["tool_speed"] == "arm::tcp"


def test_lines_are_lines_on_the_way_back() -> None:
    world = bundled_world("ur5e_pickup")
    tool = world.frame_pose("arm::tcp", world.state)
    there = Pose(tool.position + np.array([0.0, 0.05, -0.03]), tool.quaternion)
    problem = problem_of(LineGoal((PoseTarget(there, "world"),), "", 1e-3, 0.01))
    found = planning.plan(problem, world, deadline=soon())
    back = back_of(world, problem, found)
    assert [part.kind for part in back.parts] == ["line"]
    assert {"line", "line rotation"} <= {check.name for check in back.certificate.checks}


def test_a_body_that_turns_turns_back() -> None:
    world = bundled_world("window_3d")
    q0 = world.positions(world.group("body"))
    q1 = np.array([0.9, 0.3, -0.2, 0.1, 0.2, 0.05, 0.55])
    q1[:4] /= np.linalg.norm(q1[:4])
    problem = problem_of(JointGoal(q1[None]), group="body")
    found = planning.plan(replace(problem, start=q0), world, deadline=soon())
    back = back_of(world, problem, found)
    manifold = found.trajectory.manifold
    times = np.linspace(0.0, found.trajectory.duration, 50)
    there = found.trajectory.positions(found.trajectory.duration - times)
    assert manifold.distance(back.trajectory.positions(times), there).max() < 1e-9


def test_a_way_back_that_is_not_free_any_more_is_refused_with_reasons(pickup: World) -> None:
    home = pickup.positions(pickup.group("arm"))
    problem = problem_of(JointGoal((home + 0.1)[None]))
    found = planning.plan(problem, pickup, deadline=soon())
    for changed, check in (
        (replace(problem, margin=0.5), "clearance"),
        (
            replace(
                problem, constraints=(TightLimits({"arm::elbow_joint": (-9.0, home[2] + 0.05)}),)
            ),
            "constraint 0",
        ),
    ):
        with pytest.raises(NotCertified) as refused:
            back_of(pickup, changed, found)
        names = [failed["name"] for failed in refused.value.evidence["checks"]]
        assert [name.partition(":")[0] for name in names] == [check]
