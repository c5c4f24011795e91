"""Ball targets: poses within a weighted distance of a center pose, in the requested axes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseBall, PoseGoal
from planning.domain.request.options import IkOptions
from planning.errors import GoalUnreachable, UnknownName
from planning.goals.targets.ball_target import BallTarget
from planning.goals.targets.workspace_bound import WorkspaceBound
from planning.world.world import World
from tests.goals.conftest import ENGINES, ask, at, world_by
from tests.profiles import num_cases

DOWN = Pose.from_parts([0.45, 0.25, 0.4], rpy=[np.pi, 0, 0])


def distance(target: Pose, reached: Pose, weights: np.ndarray, axes: np.ndarray) -> float:
    """The definition, with rotation vectors and unrotated ways."""
    way = rotation.rotate(rotation.conjugate(axes), reached.position - target.position)
    return float(np.linalg.norm([*(way * weights[:3]), weights[3] * target.distance(reached)[1]]))


def within(goal: PoseGoal, tolerance: float, weights: object, frame: str = "") -> PoseGoal:
    return replace(goal, ball=PoseBall(tolerance, np.array(weights, dtype=float), frame))


@given(seed=st.integers(0, 2**32 - 1), free=st.lists(st.booleans(), min_size=4, max_size=4))
@settings(max_examples=num_cases(6))
def test_samples_are_inside_and_what_is_closest_is_too(seed: int, free: list[bool]) -> None:
    rng = np.random.default_rng(seed)
    middle, far = (Pose.from_parts(rng.normal(size=3), rng.normal(size=4)) for _ in range(2))
    axes = Pose.from_parts(quaternion=rng.normal(size=4)).quaternion
    weights = np.where(free, 0.0, rng.uniform(0.1, 5.0, 4))
    ball = BallTarget("tool", middle, weights, float(rng.uniform(0.01, 1.0)), axes)
    samples = ball.sample_poses(9, WorkspaceBound(middle.position, 2.0), rng)
    drawn = [Pose(p, a) for p, a in zip(*samples, strict=True)]
    assert drawn[0].distance(middle) == pytest.approx((0.0, 0.0), abs=1e-7)
    for pose in [*drawn, ball.closest(far)]:
        true = distance(middle, pose, weights, axes)
        assert true <= ball.tolerance + 1e-6
        assert ball.distances(pose.matrix[None])[0] == pytest.approx(true, abs=1e-6)
        assert ball.are_met_by(pose.matrix[None])[0]
        assert ball.closest(pose).distance(pose) == pytest.approx((0.0, 0.0), abs=1e-6)
    true = distance(middle, far, weights, axes)
    assert ball.are_met_by(far.matrix[None])[0] == (true <= ball.tolerance + 1e-5)
    box = ball.inscribed_target
    corner = middle @ Pose(box.position_tolerance, rotation.exp(box.rotation_tolerance * 0))
    assert distance(middle, corner, weights, axes) <= ball.tolerance / np.sqrt(2) + 1e-9


@ENGINES
@pytest.mark.parametrize("frame", ["", "world", "pick"])
def test_solutions_are_spread_over_the_ball(engine: str, frame: str) -> None:
    world, weights = world_by("ur5e_pickup", engine), np.array([1.0, 4.0, 20.0, 0.2])
    pose = DOWN @ Pose.from_parts(rpy=[0, 0, 0.5])
    found = ask(world, "arm", within(at(pose), 0.08, weights, frame), IkOptions(40, 50))
    axes = {"": pose.quaternion, "world": Pose.identity().quaternion}
    axis = axes[frame] if frame in axes else world.frame_pose("pick", world.state).quaternion
    distances = [distance(pose, one, weights, axis) for one in reached(world, found.positions)]
    assert max(distances) <= 0.08 + 1e-4
    assert len(found.positions) > 10
    assert np.ptp(distances) > 0.04


def test_a_ball_out_of_reach_says_how_far_from_it_the_nearest_is() -> None:
    world = world_by("ur5e_pickup", "kernel")
    goal = within(at(Pose.from_parts([2.0, 0.3, 0.4])), 0.1, [1.0, 1.0, 1.0, 0.0])
    with pytest.raises(GoalUnreachable) as refusal:
        ask(world, "arm", goal, IkOptions(5, 30))
    nearest = refusal.value.evidence["nearest"]
    gap = np.linalg.norm(np.array(nearest["position"]) - [2.0, 0.3, 0.4])
    assert nearest["translation_error"] == pytest.approx(gap - 0.1, abs=1e-6)
    with pytest.raises(UnknownName):
        ask(world, "arm", within(at(DOWN), 0.1, np.ones(4), "pikc"))


def reached(world: World, rows: np.ndarray) -> list[Pose]:
    full = world.embed(world.group("arm"), rows)
    return [world.frame_pose("arm::tcp", q) for q in full]
