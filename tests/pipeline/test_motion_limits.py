"""Plans and given motions under limits of frames, zones and signed accelerations."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning.api.motion_series import motion_series
from planning.api.retime_path import RetimedPath
from planning.certify.frames.tool_checks import tool_checks
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import ConfigurationGoal, Goal, PoseGoal, PoseTarget
from planning.domain.report.motion_plan import MotionPlan
from planning.domain.request.constraint import PlacedBox
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import SpeedZone, ToolLimit
from planning.domain.request.options import RefineOptions, RetimeOptions
from planning.domain.robot.manifold import Manifold
from planning.errors import ProblemInvalid, UnknownName, WayproofError
from planning.retime.blend import blend_corners
from planning.retime.limits.request_limits import path_limits
from planning.retime.retimer import retime
from planning.world.world import World
from tests.certify.conftest import request_for
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases
from tests.retime.limits.test_tool_rate import tool_rates
from tests.retime.limits.test_zone_speed import are_inside

TOOL = "arm::tcp"
LIMITS = (ToolLimit(TOOL, 0.3, 1.0), ToolLimit("arm::forearm_link", 0.2))
# Around the tool where the scene has it, in the tool's own frame.
ZONE = SpeedZone("start", TOOL, PlacedBox(np.full(3, 0.1), reference=TOOL), 0.05)
BOUNDS = {"arm::elbow_joint": (-0.4, 0.9)}
READY = ConfigurationGoal("ready")


def deadline() -> Deadline:
    return no_hurry(30)


def ask(world: World, options: RetimeOptions, goal: Goal = READY) -> MotionPlan:
    problem = planning.PlanningProblem("arm", goal, retime=options, seed=3)
    return planning.plan(problem, world, deadline=deadline())


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_a_plan_keeps_all_of_them_and_says_so(pickup: World, method: str) -> None:
    options = RetimeOptions(
        method=method, tool_limits=LIMITS, speed_zones=(ZONE,), acceleration_bounds=BOUNDS
    )
    found = ask(pickup, options)
    checks = {check.name: check for check in found.certificate.checks}
    assert checks["tool_speed arm::tcp"].value <= 0.3
    assert checks["tool_acceleration arm::tcp"].value <= 1.0
    assert checks["tool_speed arm::forearm_link"].value <= 0.2
    assert checks["speed_zone start"].value <= 0.05
    used = found.stages.retime.utilisation
    assert used["tool_speed"] == pytest.approx(
        max(
            checks[f"tool_speed {limit.frame}"].value / (limit.speed or np.inf) for limit in LIMITS
        ),
        rel=2e-3,
    )
    motion = found.trajectory
    speeds, accelerations = tool_rates(pickup, "arm", TOOL, motion, 3000)
    assert speeds.max() <= 0.3
    assert accelerations.max() <= 1.001
    elbow = motion.tangents(np.linspace(0, motion.duration, 3000), 2)[:, 2]
    assert elbow.min() >= BOUNDS["arm::elbow_joint"][0]
    assert elbow.max() <= BOUNDS["arm::elbow_joint"][1]
    begin = pickup.frame_pose(TOOL, pickup.embed(found.group, found.start))
    zone = replace(ZONE, box=replace(ZONE.box, pose=begin, reference="world"))
    q = motion.positions(np.linspace(0, motion.duration, 3000))
    points = pickup.frame_poses(TOOL, pickup.embed(found.group, q))[:, :3, 3]
    slow = are_inside(zone, points[:-1]) & are_inside(zone, points[1:])
    assert 0 < slow.sum() < len(slow)
    assert speeds[slow].max() <= 0.05


def test_lines_and_a_duration_keep_them_too(pickup: World) -> None:
    zero = np.zeros(3)
    up = np.array([0, 0, -0.1])
    goal = PoseGoal((PoseTarget(Pose.identity(), "pick"),), "", zero, zero, approach=up, retreat=up)
    options = RetimeOptions(tool_limits=LIMITS[:1])
    found = ask(pickup, options, goal)
    speeds, _ = tool_rates(pickup, "arm", TOOL, found.trajectory, 3000)
    assert 0.29 < speeds.max() <= 0.3
    used = found.stages.retime.utilisation["tool_speed"]
    longer = replace(options, duration=1.5 * found.trajectory.duration)
    slower = ask(pickup, longer, goal)
    assert slower.trajectory.duration == pytest.approx(1.5 * found.trajectory.duration)
    assert slower.stages.retime.utilisation["tool_speed"] == pytest.approx(used / 1.5, rel=1e-6)
    assert slower.stages.retime.utilisation["tool_acceleration"] < 0.5
    assert slower.certificate.proven


def test_the_explanation_names_the_frame(pickup: World) -> None:
    options = RetimeOptions(tool_limits=(ToolLimit(TOOL, 0.1),), explain=True)
    explanation = ask(pickup, options).stages.retime.explanation
    assert explanation is not None
    assert ("tool_speed", TOOL) in {(part.limit, part.where) for part in explanation.intervals}
    assert (explanation.savings[0].limit, explanation.savings[0].where) == ("tool_speed", TOOL)


def own(world: World, options: RetimeOptions) -> RetimedPath:
    q = world.positions(world.group("arm"))
    path = q + np.array([np.zeros(6), np.full(6, 0.2), [0.6, 0.2, 0.1, 0.1, 0.1, 0.1]])
    return planning.retime_path(world, "arm", path, deadline=deadline(), options=options)


def test_the_plot_shows_the_use_of_each_by_the_name_of_its_check(pickup: World) -> None:
    options = RetimeOptions(tool_limits=LIMITS, speed_zones=(ZONE,), acceleration_bounds=BOUNDS)
    made = own(pickup, options)
    used = motion_series(pickup, "arm", made.trajectory, 81, options).utilisation
    peaks = {
        check.name: check.value / check.bound
        for check in made.certificate.checks
        if check.name.startswith(("tool", "speed_zone"))
    }
    assert set(used) - {"velocity", "acceleration", "torque"} == set(peaks)
    for name, peak in {**peaks, "acceleration": 1.0}.items():
        assert 0.95 * peak < used[name].max() <= peak + 1e-3, name
    plain = motion_series(pickup, "arm", made.trajectory, 3).utilisation
    assert set(plain) == {"velocity", "acceleration", "torque"}


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_an_own_path_keeps_them_and_what_is_quicker_is_refused(pickup: World, method: str) -> None:
    options = RetimeOptions(
        method=method, tool_limits=LIMITS, speed_zones=(ZONE,), acceleration_bounds=BOUNDS
    )
    made = own(pickup, options)
    assert made.certificate.proven
    nearest = max(
        made.retime.utilisation[name]
        for name in ("tool_speed", "tool_acceleration", "speed_zone", "acceleration_bounds")
    )
    assert nearest > 0.99

    def failed(motion: TimedTrajectory, limits: RetimeOptions) -> set[str]:
        certificate, _ = planning.certify_trajectory(
            pickup, "arm", motion, deadline=deadline(), options=limits
        )
        return {check.name for check in certificate.failed}

    assert not failed(made.trajectory, options)
    assert failed(made.trajectory.time_scaled(0.99), options)
    free = own(pickup, RetimeOptions(method=method)).trajectory
    assert failed(free, options) == {
        "acceleration",
        "speed_zone start",
        "tool_acceleration arm::tcp",
        "tool_speed arm::forearm_link",
        "tool_speed arm::tcp",
    }
    assert failed(free, replace(options, tool_limits=(), acceleration_bounds={})) == {
        "speed_zone start"
    }


@pytest.mark.parametrize(
    ("options", "kind", "words"),
    [
        ({"tool_limits": (ToolLimit("arm::tpc", 1.0),)}, UnknownName, "arm::tcp"),
        ({"tool_limits": (ToolLimit(TOOL),)}, ProblemInvalid, "speed or an acceleration"),
        ({"tool_limits": (ToolLimit(TOOL, 0.0),)}, ProblemInvalid, "positive"),
        ({"tool_limits": (LIMITS[0], LIMITS[0])}, ProblemInvalid, "twice"),
        ({"speed_zones": (ZONE, ZONE)}, ProblemInvalid, "'start'"),
        ({"speed_zones": (replace(ZONE, frame="hand"),)}, UnknownName, "hand"),
        ({"speed_zones": (replace(ZONE, speed=-1.0),)}, ProblemInvalid, "positive"),
        ({"acceleration_bounds": {"arm::elbow": (-1, 1)}}, UnknownName, "arm::elbow_joint"),
        ({"acceleration_bounds": {"arm::elbow_joint": (1, 2)}}, ProblemInvalid, "negative"),
    ],
)
def test_what_cannot_be_meant_is_refused(
    pickup: World, options: dict[str, object], kind: type[WayproofError], words: str
) -> None:
    with pytest.raises(kind, match=words):
        ask(pickup, RetimeOptions(**options))
    with pytest.raises(kind, match=words):
        own(pickup, RetimeOptions(**options))


def test_a_planar_body_has_bounds_on_its_turn_alone() -> None:
    world = bundled_world("maze_2d")
    problem = planning.PlanningProblem(
        "body",
        ConfigurationGoal("exit"),
        refine=RefineOptions("none"),
        retime=RetimeOptions(
            tool_limits=(ToolLimit("body::body", 0.2),),
            acceleration_bounds={"body::base_joint.angular": (-0.5, 0.3)},
        ),
    )
    found = planning.plan(problem, world, deadline=deadline())
    turn = found.trajectory.tangents(np.linspace(0, found.trajectory.duration, 2000), 2)[:, 2]
    assert turn.min() >= -0.5
    assert turn.max() <= 0.3
    speed = next(c for c in found.certificate.checks if c.name == "tool_speed body::body")
    assert 0.19 < speed.value <= 0.2
    for wrong in ("body::base_joint", "body::base_joint.x", "body::base_joint.linear"):
        bounds = replace(problem.retime, acceleration_bounds={wrong: (-1, 1)})
        with pytest.raises(UnknownName) as refused:
            planning.plan(replace(problem, retime=bounds), world, deadline=deadline())
        assert "signed bounds: ['body::base_joint.angular']" in refused.value.detail
        assert "has no sign: ['body::base_joint.linear']" in refused.value.detail


@pytest.mark.parametrize(
    ("scene", "name", "frame"),
    [
        ("ur5e_pickup", "arm", TOOL),
        ("panda_shelf", "panda", "panda::panda_hand_tcp"),
        ("window_3d", "body", "body::body"),
        ("maze_2d", "body", "body::body"),
    ],
)
@given(seed=st.integers(0, 1000), method=st.sampled_from(["toppra", "ruckig"]))
@settings(max_examples=num_cases(3))
def test_what_is_delivered_is_proven_and_a_hair_quicker_is_refused(
    scene: str, name: str, frame: str, seed: int, method: str
) -> None:
    world = bundled_world(scene)
    group = world.group(name)
    path = JointPath(group, near(world, name, seed))
    spline = blend_corners(path, 0.05, 1 if method == "toppra" else 2)
    middle = world.embed(group, spline.positions(np.array([0.5])))
    pose = Pose.from_parts(world.frame_poses(frame, middle)[0, :3, 3], rpy=(0.3, 0.2, 0.1))
    options = RetimeOptions(
        method="ruckig" if method == "ruckig" else "toppra",
        tool_limits=(ToolLimit(frame, 0.2, 0.5),),
        speed_zones=(SpeedZone("slow", frame, PlacedBox(np.full(3, 0.2), pose), 0.1),),
    )
    motion, report = retime(
        spline, world.limits(group), options, path_limits(world, group, options)
    )
    request = replace(
        request_for(world, name, motion),
        tool_limits=options.tool_limits,
        speed_zones=options.speed_zones,
    )
    checks = tool_checks(world.drake, request, deadline())
    assert all(check.passed for check in checks)
    used = report.utilisation
    for check in checks:
        kind = check.name.split(maxsplit=1)[0]
        assert check.value / check.bound == pytest.approx(used[kind], abs=0.011)
    quicker = replace(request, trajectory=motion.time_scaled(0.995))
    refused = {c.name for c in tool_checks(world.drake, quicker, deadline()) if not c.passed}
    # Half a percent is more than the fifth of a percent that is left.
    for check in checks:
        order = 2 if check.name.startswith("tool_acceleration") else 1
        share = check.value / check.bound / 0.995**order
        if abs(share - 1) > 1.5e-3:
            assert (check.name in refused) == (share > 1)


def near(world: World, name: str, seed: int) -> np.ndarray:
    """Return a few configurations, one near the other, from where the group is."""
    group = world.group(name)
    manifold = Manifold(group.joints)
    rng = np.random.default_rng(seed)
    rows = [world.positions(group)]
    for _ in range(2):
        rows.append(manifold.plus(rows[-1], rng.normal(0, 0.4, group.num_velocities)))
    return np.array(rows)
