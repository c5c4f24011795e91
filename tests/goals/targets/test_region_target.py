"""Region targets: membership of poses, and solutions that are spread over the region."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseTarget, RegionGoal
from planning.domain.request.options import IkOptions
from planning.errors import GoalUnreachable
from planning.goals.targets.region_samples import RegionSamples
from planning.goals.targets.region_target import RegionTarget
from planning.goals.targets.target_samples import ExactPoses
from planning.goals.targets.workspace_bound import WorkspaceBound, workspace_bound
from tests.goals.conftest import ENGINES, EXACT, ask, world_by
from tests.profiles import num_cases

DOWN = Pose.from_parts([0.45, 0.25, 0.4], rpy=[np.pi, 0, 0])
FREE = np.pi
# Of this box only a corner is in reach: none of 300 poses in it is reached.
HARD, HARD_BOX = Pose.from_parts([1.16, 0.3, 0.5], rpy=[np.pi, 0, 0]), np.full(3, 0.3)


def region(pose: Pose, position: object, turn: object) -> RegionGoal:
    return RegionGoal(
        (PoseTarget(pose),), "", np.array(position, dtype=float), np.array(turn, dtype=float)
    )


def tilt_and_twist(a: np.ndarray, axis: int) -> tuple[np.ndarray, float]:
    """Split R into a tilt square to an axis, after a turn about it, by where R takes the axis."""
    e = np.eye(3)[axis]
    taken = rotation.rotate(a, e)
    square = np.cross(e, taken)
    angle = np.arctan2(np.linalg.norm(square), e @ taken)
    tilt = square / max(np.linalg.norm(square), 1e-12) * angle
    twist = rotation.log(rotation.multiply(rotation.exp(-tilt), a))
    return tilt, float(twist[axis])


@given(
    seed=st.integers(0, 2**32 - 1),
    free=st.lists(st.booleans(), min_size=3, max_size=3),
    bound=st.floats(0.0, 3.0),
)
@settings(max_examples=num_cases(6))
def test_samples_are_in_the_region_and_little_else_is(
    seed: int, free: list[bool], bound: float
) -> None:
    rng = np.random.default_rng(seed)
    middle = Pose.from_parts(rng.normal(size=3), rng.normal(size=4))
    bounds = np.where(free, FREE, bound * rng.uniform(0.3, 1.0, 3))
    box = rng.uniform(0.0, 0.5, 3)
    target = RegionTarget("tool", middle, box, bounds)
    samples = target.sample_poses(12, WorkspaceBound(middle.position, 10.0), rng)
    drawn = [Pose(p, a) for p, a in zip(*samples, strict=True)]
    assert target.are_met_by(np.stack([pose.matrix for pose in drawn])).all()
    for pose in drawn:
        error = middle.inverse @ pose
        assert (np.abs(error.position) <= box + 1e-9).all()
        assert pose.distance(target.closest(pose)) == pytest.approx((0.0, 0.0), abs=1e-6)
        if not any(free):
            assert (np.abs(rotation.log(error.quaternion)) <= bounds + 1e-6).all()
        elif sum(free) == 1:
            tilt, _ = tilt_and_twist(error.quaternion, free.index(True))
            assert (np.abs(tilt) <= bounds + 1e-6).all()
        elif sum(free) == 2:
            _, twist = tilt_and_twist(error.quaternion, free.index(False))
            assert abs(twist) <= bounds[free.index(False)] + 1e-6
    outside = middle @ Pose.from_parts(box + 1e-3)
    assert not target.are_met_by(outside.matrix[None])[0]


@given(seed=st.integers(0, 2**32 - 1), free=st.lists(st.booleans(), min_size=3, max_size=3))
def test_what_is_closest_is_in_the_region_and_widening_takes_anything_in(
    seed: int, free: list[bool]
) -> None:
    rng = np.random.default_rng(seed)
    middle, pose = (Pose.from_parts(rng.normal(size=3), rng.normal(size=4)) for _ in range(2))
    bounds = np.where(free, FREE, rng.uniform(0.0, 1.0, 3))
    target = RegionTarget("tool", middle, rng.uniform(0.0, 0.2, 3), bounds)
    again = target.closest(target.closest(pose))
    assert again.distance(target.closest(pose)) == pytest.approx((0.0, 0.0), abs=1e-6)
    wider = RegionTarget("tool", middle, *target.widened_tolerances(pose))
    assert wider.are_met_by(pose.matrix[None])[0]


@ENGINES
def test_any_yaw_is_any_yaw(engine: str) -> None:
    world = world_by("ur5e_pickup", engine)
    group = world.group("arm")
    found = ask(world, "arm", region(DOWN, EXACT, [0, 0, FREE]), IkOptions(30, 45))
    yaws = []
    for row in found.positions:
        error = DOWN.inverse @ world.frame_pose("arm::tcp", world.embed(group, row))
        assert np.abs(error.position).max() < 2e-6
        assert error.matrix[2, 2] == pytest.approx(1.0, abs=1e-9)
        yaws.append(np.arctan2(error.matrix[1, 0], error.matrix[0, 0]))
    assert np.histogram(yaws, 4, (-np.pi, np.pi))[0].min() > 0


@ENGINES
def test_solutions_are_spread_over_the_box_and_nearest_first(engine: str) -> None:
    world = world_by("ur5e_pickup", engine)
    group = world.group("arm")
    box = np.array([0.08, 0.06, 0.0])
    found = ask(world, "arm", region(DOWN, box, [0.1, 0.1, FREE]), IkOptions(40, 60))
    errors = [
        DOWN.inverse @ world.frame_pose("arm::tcp", world.embed(group, row))
        for row in found.positions
    ]
    places = np.array([error.position for error in errors])
    assert (np.abs(places) <= box + 2e-6).all()
    shares = np.abs(places[:, :2]) / box[:2]
    assert (shares.max(axis=1) < 0.9).mean() > 0.5
    assert np.ptp(places[:, 0]) > box[0]
    distances = np.linalg.norm(found.positions - world.positions(group), axis=1)
    assert (np.diff(distances) >= -1e-9).all()


class Counted(RegionTarget):
    """Notes how many samples were asked for, the most at once."""

    most = 0

    def sample_poses(self, count: int, *rest: Any) -> Any:
        Counted.most = max(Counted.most, count)
        return super().sample_poses(count, *rest)


def test_poses_are_drawn_as_trials_are_made() -> None:
    """However many may come: those that are not needed are not drawn, and all are in there."""
    world = world_by("ur5e_pickup", "kernel")
    reach = workspace_bound(world, world.group("arm"), "arm::tcp")
    regions = [
        Counted("arm::tcp", middle, np.full(3, 0.05), np.array([0.1, 0.1, FREE]))
        for middle in (DOWN, HARD)
    ]
    rng = np.random.default_rng(0)
    aims = RegionSamples(regions, reach, 3001, rng)
    state = rng.bit_generator.state
    assert 0 < Counted.most < 700
    begin = 0
    for some in aims:
        assert isinstance(some.targets, ExactPoses)
        assert some.first_trial == begin
        begin = some.end_trial or 0
        assert len(some.targets) == begin - some.first_trial
        seeds, targets = some.trials(some.first_trial, begin - some.first_trial)
        np.testing.assert_array_equal(seeds, np.arange(some.first_trial, begin))
        np.testing.assert_array_equal(targets, np.arange(len(targets)))
        # The middles, which come first, are alike.
        assert len(np.unique(some.targets.quaternions, axis=0)) >= len(targets) - 1
        for i, region in enumerate(regions):
            those = some.targets.positions[i::90], some.targets.quaternions[i::90]
            poses = [Pose(p, a).matrix for p, a in zip(*those, strict=True)]
            assert region.are_met_by(np.stack(poses)).all()
    assert begin >= 3001
    assert rng.bit_generator.state == state
    assert [id(one) for one in aims] == [id(one) for one in aims]


def test_free_positions_end_where_the_group_does() -> None:
    world = world_by("ur5e_pickup", "kernel")
    group = world.group("arm")
    found = ask(world, "arm", region(DOWN, [np.inf, np.inf, 0], [0, 0, FREE]), IkOptions(40, 200))
    places = np.array([
        world.frame_pose("arm::tcp", world.embed(group, row)).position for row in found.positions
    ])
    np.testing.assert_allclose(places[:, 2], 0.4, atol=2e-6)
    assert np.ptp(places[:, 0]) > 0.5
    assert np.ptp(places[:, 1]) > 0.5


def test_a_region_of_which_hardly_anything_is_in_reach_is_reached() -> None:
    world = world_by("ur5e_pickup", "kernel")
    found = ask(world, "arm", region(HARD, HARD_BOX, EXACT), IkOptions(5, 300))
    assert len(found.positions) == 5
    for row in found.positions:
        reached = world.frame_pose("arm::tcp", world.embed(world.group("arm"), row))
        assert (np.abs((HARD.inverse @ reached).position) <= HARD_BOX + 2e-6).all()


def test_a_region_out_of_reach_says_how_far() -> None:
    world = world_by("ur5e_pickup", "kernel")
    far = Pose.from_parts([2.0, 0.3, 0.4])
    with pytest.raises(GoalUnreachable) as refusal:
        ask(world, "arm", region(far, [0.1, 0.1, 0.1], [FREE] * 3), IkOptions(5, 30))
    nearest = refusal.value.evidence["nearest"]
    missed = np.array(nearest["position"]) - far.position
    assert nearest["translation_error"] == pytest.approx(
        np.linalg.norm(np.maximum(np.abs(missed) - 0.1, 0.0)), abs=1e-9
    )
    assert nearest["rotation_error"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", ["ur5e_pickup", "panda_shelf", "maze_2d", "window_3d"])
def test_no_configuration_leaves_the_ball(name: str) -> None:
    world = world_by(name, "kernel")
    rng = np.random.default_rng(0)
    for group in world.groups:
        limits = world.limits(group)
        lower = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
        upper = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
        rows = rng.uniform(lower, upper, (200, group.num_positions))
        frame = group.tool_frames[0]
        ball = workspace_bound(world, group, frame)
        for x_wt in world.frame_poses(frame, world.embed(group, rows)):
            assert np.linalg.norm(x_wt[:3, 3] - ball.center) <= ball.radius + 1e-9
        assert ball.radius < 3.0


def test_the_ball_of_an_arm_is_as_large_as_its_links_are_long() -> None:
    world = world_by("ur5e_pickup", "kernel")
    group = world.group("arm")
    bodies = [
        world.drake.plant.get_joint(world.drake.joint_indices[joint.name]).child_body()
        for joint in group.joints
    ]
    names = [*(world.drake.body_names[body.index()] for body in bodies), "arm::tcp"]
    places = np.array([world.frame_pose(name, world.state).position for name in names])
    ball = workspace_bound(world, group, "arm::tcp")
    np.testing.assert_allclose(ball.center, places[0], atol=1e-9)
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert ball.radius == pytest.approx(lengths.sum())
