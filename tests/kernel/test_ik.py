"""What the kernel's inverse kinematics calls converged has converged, by Drake's kinematics."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.geometry.pose import Pose
from planning.domain.robot.manifold import Manifold
from planning.goals.targets.tool_target import FreedomKind, ToolTarget
from planning.kernel.native import native
from planning.world.kernel.kernel_tree import kernel_chain
from planning.world.world import World
from tests.conftest import bundled_world
from tests.kernel.test_kinematics import drake_pose, made_up
from tests.profiles import num_cases

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel is not built")

EXACT = np.zeros(3)


def batch_kernels() -> list[str]:
    module: Any = native()
    return module.batch_kernels() if module else []


def tolerance(target: ToolTarget) -> Any:
    module: Any = native()
    rest = target.rotation_freedom
    return module.IkTolerance(
        target.position_tolerance, module.Freedom[rest.kind.name], rest.axis, rest.bound
    )


def flat(poses: np.ndarray) -> np.ndarray:
    return np.concatenate([poses[:, :3, :3].reshape(-1, 9), poses[:, :3, 3]], axis=1)


def exact(pose: np.ndarray) -> ToolTarget:
    return ToolTarget("", Pose.from_matrix(pose), EXACT, EXACT)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=num_cases(6))
def test_on_random_robots_what_converged_reaches_within_limits(seed: int) -> None:
    robot, frame, qs = made_up(seed)
    model = robot.model
    chain: Any = kernel_chain(model, robot.group, robot.state, frame)
    context = model.plant.CreateDefaultContext()
    full = model.embed(robot.group, qs, robot.state)
    targets = np.array([drake_pose(model, context, frame, row) for row in full])
    rng = np.random.default_rng(seed)
    lower = np.where(rng.random(qs.shape[1]) < 0.5, qs.min(axis=0) - 0.1, -np.inf)
    upper = np.where(np.isfinite(lower), qs.max(axis=0) + 0.1, np.inf)
    manifold = Manifold(robot.group.joints)
    is_quaternion = [name.rpartition(".")[2].startswith("q") for name in robot.group.position_names]
    lower[is_quaternion], upper[is_quaternion] = -np.inf, np.inf
    seeds = manifold.plus(qs, rng.normal(0.0, 0.3, (len(qs), manifold.num_velocities)))
    which = np.arange(len(qs))
    wanted = tolerance(exact(targets[0]))
    converged, found, iterations = chain.solve(
        seeds, which, flat(targets), lower, upper, wanted, 10**6, 40
    )
    assert len(converged) == len(qs)
    assert (iterations <= 41).all()
    for i in np.flatnonzero(converged):
        reached = drake_pose(model, context, frame, model.embed(robot.group, found[i], robot.state))
        np.testing.assert_allclose(reached, targets[i], atol=1e-8)
        assert (found[i] >= lower).all()
        assert (found[i] <= upper).all()
    assert converged.mean() > 0.2


@pytest.mark.parametrize("scene", ["panda_shelf", "ur5e_pickup"])
def test_reachable_poses_are_reached_within_64_seeds(scene: str) -> None:
    _, targets, solve = arm(scene, 200)
    converged, _, _ = solve(64, tolerance(exact(targets[0])))
    solved = converged.reshape(len(targets), 64).any(axis=1)
    assert solved.mean() >= 0.99
    assert converged.mean() > 0.5


@pytest.mark.parametrize("scene", ["panda_shelf", "ur5e_pickup"])
def test_every_instruction_set_gives_the_same_bits(scene: str) -> None:
    _, targets, solve = arm(scene, 10)
    answers = [solve(30, tolerance(exact(targets[0])), name) for name in batch_kernels()]
    for answer in answers[1:]:
        for one, other in zip(answers[0], answer, strict=True):
            np.testing.assert_array_equal(one, other)


def test_enough_is_a_prefix_that_ends_with_a_solution() -> None:
    _, targets, solve = arm("panda_shelf", 3)
    wanted = tolerance(exact(targets[0]))
    every, found, iterations = solve(40, wanted)
    for enough in (1, 2, 17):
        some, rows, counts = solve(40, wanted, enough=enough)
        assert some.sum() == enough
        assert some[-1]
        np.testing.assert_array_equal(some, every[: len(some)])
        np.testing.assert_array_equal(rows, found[: len(some)])
        np.testing.assert_array_equal(counts, iterations[: len(some)])
    assert len(solve(40, wanted, enough=0)[0]) == 0


@pytest.mark.parametrize(
    ("box", "turn"),
    [
        (EXACT, np.full(3, 0.2)),
        (EXACT, np.array([0.0, 0.0, np.pi])),
        (EXACT, np.array([np.pi, 0.1, 0.1])),
        (EXACT, np.full(3, np.pi)),
        (np.array([0.05, 0.0, 0.1]), EXACT),
        (np.array([0.05, 0.02, 0.1]), np.array([0.3, np.pi, 0.3])),
    ],
)
def test_tolerances_are_met_and_used(box: np.ndarray, turn: np.ndarray) -> None:
    world, targets, solve = arm("panda_shelf", 12)
    wanted = [ToolTarget("", Pose.from_matrix(x), box, turn) for x in targets]
    converged, found, _ = solve(40, tolerance(wanted[0]))
    assert converged.mean() > 0.5
    group = world.groups[0]
    reached = world.frame_poses(group.tool_frames[0], world.embed(group, found))
    strict = []
    for i, target in enumerate(wanted):
        rows = reached[40 * i : 40 * (i + 1)][converged[40 * i : 40 * (i + 1)].astype(bool)]
        assert target.are_met_by(rows).all()
        # Verified once more the long way: the closest tolerated pose is where it is.
        for row in rows[:3]:
            pose = Pose.from_matrix(row)
            assert max(target.closest(pose).distance(pose)) < 1e-8
        strict.append(exact(targets[i]).are_met_by(rows))
    assert not np.concatenate(strict).all()


def test_a_tool_that_points_the_opposite_way_turns_around() -> None:
    """Half a turn off there is no direction to turn to; no answer may take that for none."""
    world = bundled_world("window_3d")
    group = world.groups[0]
    chain: Any = kernel_chain(world.drake, group, world.state, group.tool_frames[0])
    q = world.positions(group)
    start = world.frame_pose(group.tool_frames[0], world.embed(group, q)).matrix
    for axis in np.eye(3):
        target = start.copy()
        target[:3, :3] = (2 * np.outer(axis, axis) - np.eye(3)) @ start[:3, :3]
        for turn in (EXACT, np.array([0.0, 0.0, np.pi])):
            wanted = ToolTarget("", Pose.from_matrix(target), EXACT, turn)
            limits = np.full(7, np.inf)
            converged, found, _ = chain.solve(
                q[None], np.zeros(1, np.int64), flat(target[None]), -limits, limits,
                tolerance(wanted), 1, 60,
            )  # fmt: skip
            assert converged.all()
            reached = world.frame_poses(group.tool_frames[0], world.embed(group, found))
            assert wanted.are_met_by(reached).all()


def test_circles_end_within_half_a_turn_of_the_seed_and_whole_turns_save_a_limit() -> None:
    world, targets, _ = arm("ur5e_pickup", 30)
    group = world.groups[0]
    chain: Any = kernel_chain(world.drake, group, world.state, group.tool_frames[0])
    seeds = np.random.default_rng(1).uniform(-30, 30, (30, 6))
    free = np.full(6, np.inf)
    which, wanted = np.arange(30), tolerance(exact(targets[0]))
    converged, found, _ = chain.solve(seeds, which, flat(targets), -free, free, wanted, 30, 40)
    assert converged.mean() > 0.7
    assert np.abs(found - seeds).max() <= np.pi + 1e-12


def test_a_bound_of_zero_rotation_is_a_ball_and_three_free_axes_are_free() -> None:
    kinds = [
        ToolTarget("", Pose.identity(), EXACT, np.array(turn)).rotation_freedom.kind
        for turn in ((0.0, 0.0, 0.0), (0.0, 0.0, 4.0), (4.0, 4.0, 0.1), (4.0, 4.0, 4.0))
    ]
    assert kinds == [FreedomKind.BALL, FreedomKind.CONE, FreedomKind.BALL, FreedomKind.FREE]


def arm(scene: str, num_targets: int) -> tuple[World, np.ndarray, Any]:
    """Return a bundled arm, reachable poses of its tool, and a solver from random seeds."""
    world = bundled_world(scene)
    group = world.groups[0]
    frame = group.tool_frames[0]
    chain: Any = kernel_chain(world.drake, group, world.state, frame)
    limits = world.limits(group)
    rng = np.random.default_rng(3)
    q = rng.uniform(limits.lower, limits.upper, (num_targets, group.num_positions))
    targets = world.frame_poses(frame, world.embed(group, q))

    def solve(num_seeds: int, wanted: Any, kernel: str = "", enough: int = 10**9) -> Any:
        count = num_targets * num_seeds
        seeds = np.random.default_rng(4).uniform(limits.lower, limits.upper, (count, q.shape[1]))
        which = np.repeat(np.arange(num_targets), num_seeds)
        bounds = limits.lower, limits.upper
        return chain.solve(seeds, which, flat(targets), *bounds, wanted, enough, 30, kernel)

    return world, targets, solve
