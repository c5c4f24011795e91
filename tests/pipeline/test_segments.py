"""Motions of several segments: at rest between them, on their lines, certified as a whole."""

from dataclasses import replace

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import (
    Goal,
    JointGoal,
    LineGoal,
    PoseGoal,
    PoseTarget,
    RegionGoal,
    RelativeGoal,
)
from planning.domain.goals.linear_moves import Displacement
from planning.domain.report.motion_plan import MotionPlan
from planning.domain.request.options import RetimeOptions, SearchOptions
from planning.errors import LineBlocked
from planning.pipeline.segments import tool_frame
from planning.world.world import World
from tests.clocks import no_hurry

ZERO = np.zeros(3)
PICK = PoseGoal((PoseTarget(Pose.identity(), "pick"),), "", ZERO, ZERO)
UP, UPWARDS = np.array([0, 0, -0.1]), np.array([0, 0, 1.0])


def ask(world: World, goal: Goal, method: str = "toppra", seed: int = 3) -> MotionPlan:
    problem = planning.PlanningProblem(
        "arm",
        goal,
        search=SearchOptions(num_states=40, approach_states=30),
        refine=planning.RefineOptions("none"),
        retime=RetimeOptions(method="ruckig" if method == "ruckig" else "toppra"),
        seed=seed,
    )
    return planning.plan(problem, world, deadline=no_hurry(60))


def tool(world: World, found: MotionPlan, times: list[float]) -> list[Pose]:
    full = world.embed(found.group, found.trajectory.positions(np.array(times)))
    return [world.frame_pose("arm::tcp", q) for q in full]


def test_lengths_are_of_the_frame_that_the_goal_names(pickup: World) -> None:
    group = pickup.group("arm")
    shift = Pose.from_parts([0.0, 0.0, 0.05])
    assert tool_frame(group, RelativeGoal(shift, "arm::forearm_link")) == "arm::forearm_link"
    assert tool_frame(group, replace(PICK, frame="arm::forearm_link")) == "arm::forearm_link"
    for goal in (RelativeGoal(shift), PICK, JointGoal(np.zeros(6))):
        assert tool_frame(group, goal) == group.tool_frames[0]


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_a_pick_is_a_free_way_an_approach_and_a_retreat(pickup: World, method: str) -> None:
    found = ask(pickup, replace(PICK, approach=UP, retreat=np.array([0, 0, -0.15])), method)
    free, approach, retreat = found.parts
    assert [part.kind for part in found.parts] == ["free", "approach", "retreat"]
    assert (free.begin, retreat.end) == (0, found.trajectory.duration)
    assert (free.end, approach.end) == (approach.begin, retreat.begin)
    assert approach.length == pytest.approx(0.1)
    assert retreat.length == pytest.approx(0.15)
    assert (approach.num_waypoints, retreat.num_waypoints) == (30, 30)
    assert free.num_waypoints >= 40
    assert len(found.path.waypoints) == sum(part.num_waypoints for part in found.parts) - 2
    rests = np.array([free.begin, free.end, approach.end, retreat.end])
    assert np.abs(found.trajectory.velocities(rests)).max() < 1e-6
    pick = pickup.frame_pose("pick", pickup.state)
    before, at, after = tool(pickup, found, [free.end, approach.end, retreat.end])
    assert max(at.distance(pick)) < 1e-5
    np.testing.assert_allclose(before.position, pick.position + 0.1 * UPWARDS, atol=1e-5)
    np.testing.assert_allclose(after.position, pick.position + 0.15 * UPWARDS, atol=1e-5)
    reached = found.trajectory.positions(np.array([approach.end]))[0]
    np.testing.assert_allclose(found.goal_configuration, reached, atol=1e-9)
    for pose in tool(pickup, found, list(np.linspace(approach.begin, retreat.end, 60))):
        assert np.linalg.norm(pose.position[:2] - pick.position[:2]) < 1e-3
    assert found.certificate.proven
    checks = {check.name: check for check in found.certificate.checks}
    assert checks["line"].value < 1e-4 < checks["line"].bound == 1e-3


def test_the_same_seed_gives_the_same_parts(pickup: World) -> None:
    goal = replace(PICK, approach=UP)
    one, two = ask(pickup, goal), ask(pickup, goal)
    assert one.digest == two.digest
    assert one.parts == two.parts


def test_a_plain_plan_is_one_free_part(pickup: World) -> None:
    found = ask(pickup, PICK)
    (part,) = found.parts
    assert (part.kind, part.begin, part.end) == ("free", 0, found.trajectory.duration)
    straight = np.linalg.norm(
        np.subtract(*(pose.position for pose in tool(pickup, found, [part.begin, part.end])))
    )
    assert part.length > straight - 1e-9
    assert not [check for check in found.certificate.checks if check.name.startswith("line")]


def test_a_line_goal_is_met_straight(pickup: World) -> None:
    down = PoseTarget(Pose.from_parts([0, 0.05, 0.12], rpy=[0, 0, 0.4]), "arm::tcp")
    found = ask(pickup, LineGoal((down,), max_position_deviation=1e-4, max_rotation_deviation=1e-3))
    assert [part.kind for part in found.parts] == ["line"]
    begin = pickup.frame_pose("arm::tcp", pickup.state)
    end = begin @ down.pose
    way = end.position - begin.position
    for pose in tool(pickup, found, list(np.linspace(0, found.trajectory.duration, 80))):
        s = float((pose.position - begin.position) @ way / (way @ way))
        assert np.linalg.norm(pose.position - begin.position - s * way) < 1e-4
        turned = Pose.from_parts(rpy=[0, 0, 0.4 * s])
        assert (Pose(ZERO, begin.quaternion) @ turned).distance(Pose(ZERO, pose.quaternion))[
            1
        ] < 1e-3
    assert max(tool(pickup, found, [found.trajectory.duration])[0].distance(end)) < 1e-6
    bounds = {check.name: check.bound for check in found.certificate.checks}
    assert (bounds["line"], bounds["line rotation"]) == (1e-4, 1e-3)


def test_ways_from_where_the_tool_stands_are_gone_one_after_another(pickup: World) -> None:
    begin = pickup.frame_pose("arm::tcp", pickup.state)
    ways = Displacement(np.array([0, 0, 0.1])), Displacement(np.array([0, 0.06, 0]), "arm::tcp")
    found = ask(pickup, LineGoal(ways))
    assert found.certificate.proven
    assert [part.length for part in found.parts] == pytest.approx([0.1, 0.06])
    first, second = tool(pickup, found, [part.end for part in found.parts])
    assert max(first.distance(Pose(begin.position + ways[0].vector, begin.quaternion))) < 1e-6
    assert max(second.distance(first @ Pose.from_parts(ways[1].vector))) < 1e-6


def test_a_region_is_approached_and_left_in_its_own_axes(pickup: World) -> None:
    box, any_yaw = np.array([0.01, 0.01, 0.0]), np.array([0.0, 0.0, np.pi])
    goal = RegionGoal(PICK.targets, "", box, any_yaw, UP, np.array([0.03, 0, -0.05]))
    found = ask(pickup, goal)
    assert found.certificate.proven
    assert [part.kind for part in found.parts] == ["free", "approach", "retreat"]
    pick = pickup.frame_pose("pick", pickup.state)
    before, at, after = (
        pick.inverse @ pose for pose in tool(pickup, found, [part.end for part in found.parts])
    )
    assert (np.abs(at.position) <= box + 1e-5).all()
    np.testing.assert_allclose(before.position - at.position, UP, atol=1e-5)
    np.testing.assert_allclose(after.position - at.position, [0.03, 0, -0.05], atol=1e-5)


def test_a_path_rests_at_each_of_its_poses(pickup: World) -> None:
    begin = pickup.frame_pose("arm::tcp", pickup.state)
    corners = [[0, 0, 0.1], [0, 0.1, 0.1], [0, 0, 0]]
    targets = tuple(PoseTarget(Pose.from_parts(p), "arm::tcp") for p in corners)
    found = ask(pickup, LineGoal(targets))
    ends = [part.end for part in found.parts]
    assert np.abs(found.trajectory.velocities(np.array(ends))).max() < 1e-6
    for pose, target in zip(tool(pickup, found, ends), targets, strict=True):
        assert max(pose.distance(begin @ target.pose)) < 1e-6
    assert found.goal_index == 2


def test_a_blocked_line_says_which_how_far_and_why(pickup: World) -> None:
    targets = tuple(PoseTarget(Pose.from_parts([0, 0, z]), "arm::tcp") for z in (0.05, 1.0))
    with pytest.raises(LineBlocked) as failure:
        ask(pickup, LineGoal(targets))
    evidence = failure.value.evidence
    assert evidence["line"] == 1
    assert evidence["stopped_by"]["reason"] == "collision"
    assert evidence["stopped_by"]["pair"]["bodies"] == ["arm::forearm_link", "box"]
    assert evidence["length"] == pytest.approx(0.95 * evidence["fraction"], rel=1e-6)
    assert "line 2 of 2" in failure.value.detail


def test_a_duration_is_that_of_all_parts_together(pickup: World) -> None:
    quick = ask(pickup, replace(PICK, approach=UP))
    wanted = 2 * quick.trajectory.duration
    problem = planning.PlanningProblem(
        "arm",
        replace(PICK, approach=UP),
        refine=planning.RefineOptions("none"),
        retime=RetimeOptions(duration=wanted),
        seed=3,
    )
    found = planning.plan(problem, pickup, deadline=no_hurry(60))
    assert found.trajectory.duration == pytest.approx(wanted)
    assert found.parts[-1].end == pytest.approx(wanted)
    assert found.certificate.proven
    assert found.stages.retime.duration == pytest.approx(wanted)


@pytest.mark.parametrize("slower", [None, 1.5])
def test_all_parts_are_explained(pickup: World, slower: float | None) -> None:
    """Savings of parts add up; a motion that is slowed a lot is bound by nothing."""
    problem = planning.PlanningProblem(
        "arm",
        replace(PICK, approach=UP, retreat=UP),
        refine=planning.RefineOptions("none"),
        retime=RetimeOptions(explain=True),
        seed=3,
    )
    found = planning.plan(problem, pickup, deadline=no_hurry(60))
    duration = found.trajectory.duration
    if slower is not None:
        duration *= slower
        problem = replace(problem, retime=RetimeOptions(explain=True, duration=duration))
        found = planning.plan(problem, pickup, deadline=no_hurry(60))
    explained = found.stages.retime.explanation
    assert explained is not None
    begins = [entry.begin for entry in explained.intervals]
    ends = [entry.end for entry in explained.intervals]
    assert begins == pytest.approx([0.0, *ends[:-1]])
    assert ends[-1] == pytest.approx(duration)
    for part in found.parts:
        limits = {
            entry.limit
            for entry in explained.intervals
            if part.begin <= (entry.begin + entry.end) / 2 <= part.end
        }
        assert (limits == {"duration"}) is (slower is not None)
        assert "" not in limits
    named = [(saving.limit, saving.where) for saving in explained.savings]
    assert len(named) == len(set(named))
    assert bool(named) is (slower is None)


@pytest.mark.parametrize("method", ["ruckig", "toppra"])
def test_lines_are_explained(pickup: World, method: str) -> None:
    pose = pickup.frame_pose("arm::tcp", pickup.state)
    down = Pose(pose.position + np.array([0, 0.05, -0.05]), pose.quaternion)
    goal = LineGoal((PoseTarget(down, "world"),), "", 1e-3, 0.01)
    options = RetimeOptions("ruckig" if method == "ruckig" else "toppra", explain=True)
    problem = planning.PlanningProblem("arm", goal, retime=options)
    found = planning.plan(problem, pickup, deadline=no_hurry(60))
    explained = found.stages.retime.explanation
    assert explained is not None
    assert all(entry.limit and entry.share > 0 for entry in explained.intervals)
    assert explained.intervals[-1].end == pytest.approx(found.trajectory.duration)
