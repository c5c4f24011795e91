"""Line tracing: waypoints on the line, a bound on the deviation between them, a verified stop."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning.api.trace_line import TraceResolution, trace_line
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseTarget
from planning.domain.goals.line_trace import LineTrace
from planning.domain.goals.linear_moves import Displacement
from planning.domain.robot.manifold import Manifold
from planning.errors import DeadlineExceeded, ProblemInvalid, UnknownName
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.goals.conftest import ENGINES, world_by
from tests.profiles import num_cases


def follow(
    world: World, group: str, to: PoseTarget | Displacement, fineness: TraceResolution | None = None
) -> LineTrace:
    deadline = no_hurry(30)
    return trace_line(world, group, to, deadline=deadline, fineness=fineness)


def by(*vector: float, frame: str = "world") -> Displacement:
    return Displacement(np.array(vector), frame)


def poses_at(world: World, group: str, frame: str, rows: np.ndarray) -> list[Pose]:
    full = world.embed(world.group(group), rows)
    return [world.frame_pose(frame, q) for q in full]


@ENGINES
@given(seed=st.integers(0, 500))
@settings(max_examples=num_cases(3))
def test_the_tool_is_on_the_line_at_waypoints_and_as_near_as_said_between(
    engine: str, seed: int
) -> None:
    world = world_by("ur5e_pickup", engine)
    group, limits = world.group("arm"), world.limits(world.group("arm"))
    rng = np.random.default_rng(seed)
    turn = rng.normal(0, 0.5, 3)
    to = PoseTarget(Pose.from_parts(rng.normal(0, 0.1, 3), rpy=turn), "arm::tcp")
    found = follow(world, "arm", to)
    line = found.line
    assert found.fractions[0] == 0
    assert (np.diff(found.fractions) > 0).all()
    assert (found.stop is None) == (found.fraction == 1)
    reached = poses_at(world, "arm", line.frame, found.positions)
    for pose, fraction in zip(reached, found.fractions, strict=True):
        assert max(pose.distance(line.pose(fraction))) < 1e-6
    assert (found.positions >= limits.lower).all()
    assert (found.positions <= limits.upper).all()
    manifold = Manifold(group.joints)
    for i in range(len(found.positions) - 1):
        between = manifold.interpolate(*found.positions[i : i + 2], np.linspace(0, 1, 6))
        assert all(not world.violations(group, q, world.margins(0)) for q in between[:-1])
        for pose in poses_at(world, "arm", line.frame, between):
            fraction = (
                np.dot(pose.position - line.begin.position, line.translation) / line.length**2
            )
            nearest = line.pose(float(np.clip(fraction, 0, 1)))
            assert pose.distance(nearest)[0] <= found.max_position_deviation + 1e-9
    assert 0 < found.max_position_deviation <= TraceResolution().max_shift
    assert found.max_rotation_deviation <= TraceResolution().max_turn


@given(seed=st.integers(0, 100))
@settings(max_examples=num_cases(2))
def test_both_engines_follow_the_same_line(seed: int) -> None:
    rng = np.random.default_rng(seed)
    to = by(*rng.normal(0, 0.3, 3))
    kernel, drake = (
        follow(world_by("ur5e_pickup", engine), "arm", to) for engine in ("kernel", "drake")
    )
    assert kernel.fraction == pytest.approx(drake.fraction, abs=1e-9)
    np.testing.assert_allclose(kernel.positions, drake.positions, atol=1e-8)


def test_a_limit_stops_exactly_where_it_is() -> None:
    world = bundled_world("window_3d")
    group = world.group("body")
    found = follow(world, "body", by(-1.0, 0, 0))
    limits, x = world.limits(group), world.positions(group)[4]
    assert found.stop is not None
    assert found.stop.reason == "limit"
    assert found.stop.joint == "body::base_joint.x"
    assert x - found.length == pytest.approx(limits.lower[4], abs=2e-5)


def test_a_collision_stops_just_before_it_and_names_the_pair() -> None:
    world = bundled_world("ur5e_pickup")
    found = follow(world, "arm", by(0, 0, -0.5))
    stop = found.stop
    assert stop is not None
    assert stop.reason == "collision"
    assert stop.pair is not None
    assert stop.pair.bodies == ("arm::forearm_link", "box")
    assert -1e-4 < stop.pair.distance < 0
    group = world.group("arm")
    assert not world.violations(group, stop.positions, world.margins())
    closest = world.distance_probe(world.margins()).pairs_within(
        world.embed(group, stop.positions), 1e-4
    )
    assert closest[0].bodies == stop.pair.bodies


def test_a_margin_stops_earlier() -> None:
    world = bundled_world("ur5e_pickup")
    deadline = no_hurry(30)
    near = trace_line(world, "arm", by(0, 0, -0.5), deadline=deadline)
    far = trace_line(world, "arm", by(0, 0, -0.5), deadline=deadline, margin=0.02)
    assert far.length < near.length - 0.01


def test_beyond_a_singular_stretch_no_configuration_reaches() -> None:
    world = bundled_world("ur5e_pickup")
    found = follow(world, "arm", by(1.0, 0, 0))
    assert found.stop is not None
    assert found.stop.reason == "singularity"
    assert found.stop.singular_value < 0.01
    beyond = found.line.pose(found.fraction + 1e-3)
    goal = planning.PoseGoal((PoseTarget(beyond),), "", np.zeros(3), np.zeros(3))
    with pytest.raises(planning.errors.GoalUnreachable):
        planning.solve_ik(world, "arm", goal, deadline=no_hurry(30))


def test_joints_that_cannot_lift_say_so() -> None:
    world = bundled_world("maze_2d")
    found = follow(world, world.groups[0].name, by(0, 0, 0.1))
    assert found.stop is not None
    assert found.stop.reason == "unreachable"
    assert found.fraction == 0


def test_a_spare_joint_gives_way_at_its_limit() -> None:
    world = bundled_world("panda_shelf")
    group = world.group("panda")
    limits = world.limits(group)
    start = np.array(world.positions(group))
    start[0] = limits.upper[0] - 0.02
    deadline = no_hurry(30)
    to = by(0, -0.05, 0, frame="panda::panda_hand_tcp")
    there = trace_line(world, "panda", to, deadline=deadline, start=start)
    back = trace_line(
        world, "panda", by(0, 0.05, 0, frame=to.frame), deadline=deadline, start=start
    )
    assert there.stop is None
    assert back.stop is None
    for found in (there, back):
        assert found.positions[:, 0].max() <= limits.upper[0]
    assert max(there.positions[-1, 0], back.positions[-1, 0]) > limits.upper[0] - 0.02


def test_a_step_bounds_the_way_between_waypoints() -> None:
    world = bundled_world("ur5e_pickup")
    found = follow(world, "arm", by(0.1, 0, 0), TraceResolution(max_step=0.004))
    steps = np.diff(found.fractions) * found.line.length
    assert steps.max() <= 0.004 + 1e-9
    with pytest.raises(ProblemInvalid):
        follow(world, "arm", by(0.1, 0, 0), TraceResolution(max_step=0.0))


def test_a_start_that_collides_goes_nowhere() -> None:
    world = bundled_world("ur5e_pickup")
    flat = np.zeros(6)
    deadline = no_hurry(30)
    found = trace_line(world, "arm", by(0, 0, 0.1), deadline=deadline, start=flat)
    assert found.fraction == 0
    assert found.stop is not None
    assert found.stop.reason == "collision"


def test_names_and_time_are_checked() -> None:
    world = bundled_world("ur5e_pickup")
    with pytest.raises(UnknownName):
        follow(world, "arm", by(0, 0, 0.1, frame="nowhere"))
    with pytest.raises(DeadlineExceeded):
        trace_line(world, "arm", by(0, 0, 0.1), deadline=no_hurry(-1.0))
