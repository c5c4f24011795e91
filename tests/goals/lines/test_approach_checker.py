"""Goal configurations are filtered by approach and retreat; the funnel has the reasons."""

from dataclasses import replace

import numpy as np
import pytest

from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseGoal
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.request.options import IkOptions
from planning.errors import ApproachBlocked
from planning.world.world import World
from tests.goals.conftest import ENGINES, ask, at, world_by
from tests.profiles import num_cases

DOWN = np.array([0, 0, -0.1])


def with_ways(
    goal: PoseGoal, approach: np.ndarray | None, retreat: np.ndarray | None = None
) -> PoseGoal:
    return replace(goal, approach=approach, retreat=retreat)


def tool(world: World, q: np.ndarray) -> Pose:
    return world.frame_pose("arm::tcp", world.embed(world.group("arm"), q))


def require_whole(world: World, found: GoalConfigurations, pick: Pose) -> None:
    """Every kept row has both lines, free, within limits and without jumps."""
    limits = world.limits(world.group("arm"))
    for q, legs in zip(found.positions, found.moves, strict=True):
        assert legs.approach is not None
        assert legs.retreat is not None
        np.testing.assert_allclose(legs.approach.positions[-1], q, atol=1e-9)
        np.testing.assert_allclose(legs.retreat.positions[0], q, atol=1e-9)
        before, after = (
            tool(world, row) for row in (legs.approach.positions[0], legs.retreat.positions[-1])
        )
        np.testing.assert_allclose((pick.inverse @ before).position, DOWN, atol=1e-5)
        np.testing.assert_allclose((pick.inverse @ after).position, [0.02, 0, -0.12], atol=1e-5)
        for leg in legs.all:
            assert np.abs(np.diff(leg.positions, axis=0)).max() < 0.25
            assert (leg.positions >= limits.lower - 1e-6).all()
            assert (leg.positions <= limits.upper + 1e-6).all()
            assert (
                world
                .collision_oracle(world.group("arm"), world.margins())
                .are_free(leg.positions)
                .all()
            )


@ENGINES
def test_kept_configurations_have_both_lines_nearest_entry_first(engine: str) -> None:
    world = world_by("ur5e_pickup", engine)
    goal = with_ways(at(Pose.identity(), "pick"), DOWN, np.array([0.02, 0, -0.12]))
    found = ask(world, "arm", goal, IkOptions(max_trials=40))
    require_whole(world, found, world.frame_pose("pick", world.state))
    start = world.positions(world.group("arm"))
    distances = np.linalg.norm(found.entries - start, axis=1)
    assert (np.diff(distances) >= -1e-9).all()
    funnel = found.funnel
    counts = [
        funnel.num_samples, funnel.converged, funnel.within_limits, funnel.collision_free,
        funnel.num_with_linear_moves, funnel.distinct,
    ]  # fmt: skip
    assert counts == sorted(counts, reverse=True)


def test_lines_strike_branches_that_the_pose_alone_would_keep() -> None:
    world = world_by("ur5e_pickup", "kernel")
    pose = at(Pose.from_parts([0.45, 0.25, 0.45], rpy=[np.pi, 0, 0.3]))
    free = ask(world, "arm", pose)
    kept = ask(world, "arm", with_ways(pose, np.array([0, 0, -0.17])))
    assert 0 < kept.funnel.distinct < free.funnel.distinct
    assert kept.funnel.num_with_linear_moves < kept.funnel.collision_free
    assert sum(tally.count for tally in kept.funnel.blocked_by) >= 1
    assert {tally.move for tally in kept.funnel.blocked_by} == {"approach"}
    assert free.funnel.num_with_linear_moves == free.funnel.collision_free


@pytest.mark.parametrize(
    ("approach", "retreat", "leg", "reason", "where"),
    [
        ([0, 0, 0.3], None, "approach", "collision", "can"),
        (None, [0, 0.15, -0.05], "retreat", "collision", "can"),
        ([0, 0, -0.9], None, "approach", "singularity", ""),
    ],
)
def test_a_goal_without_a_free_line_says_what_blocks_it(
    approach: list[float] | None, retreat: list[float] | None, leg: str, reason: str, where: str
) -> None:
    world = world_by("ur5e_pickup", "kernel")
    ways = [None if way is None else np.array(way) for way in (approach, retreat)]
    # To follow a line as far as it goes takes longer.
    looks = 300 if reason == "singularity" else 150
    with pytest.raises(ApproachBlocked) as failure:
        ask(world, "arm", with_ways(at(Pose.identity(), "pick"), *ways), looks=looks)
    funnel = failure.value.evidence["funnel"]
    assert funnel["collision_free"] > funnel["approach_ok"] == funnel["distinct"] == 0
    first = funnel["blocked_by"][0]
    assert (first["leg"], first["reason"]) == (leg, reason)
    assert where in first["where"]
    assert 0 <= first["max_fraction"] < 1
    assert leg in failure.value.detail


WAYS = [
    (None, [0, 0.15, -0.05]),
    ([0, 0, -0.9], [0.02, 0, -0.12]),
    ([0, 0, -0.1], [0, 0.15, -0.05]),
    # In a campaign only:
    ([0, 0, 0.3], None),
    ([0, 0, -0.9], None),
]


@pytest.mark.campaign
@pytest.mark.parametrize(("approach", "retreat"), WAYS[: num_cases(2, 5)])
def test_lines_as_long_as_a_refusal_says_would_do(
    approach: list[float] | None, retreat: list[float] | None
) -> None:
    world = world_by("ur5e_pickup", "kernel")
    asked = {"approach": approach, "retreat": retreat}
    ways = {name: None if way is None else np.array(way) for name, way in asked.items()}
    goal = at(Pose.identity(), "pick")
    with pytest.raises(ApproachBlocked) as failure:
        ask(world, "arm", with_ways(goal, **ways), looks=300)
    relaxation = failure.value.evidence["relaxation"]
    shares = {
        name: relaxation[name] / np.linalg.norm(way)
        for name, way in ways.items()
        if way is not None
    }
    assert set(shares) == {name for name in ways if relaxation[name] is not None}
    assert 0 < max(shares.values()) <= 1 + 1e-9
    assert min(shares.values()) < 1
    shorter = {name: ways[name] * min(share, 1.0) for name, share in shares.items() if share}
    found = ask(world, "arm", with_ways(goal, **{"approach": None, **shorter}))
    assert found.funnel.num_with_linear_moves > 0
    # A tenth more of what is cut short is more than there is.
    cut = min(shares, key=lambda name: shares[name])
    longer = shorter | {cut: ways[cut] * min(1.0, 1.1 * shares[cut] + 0.01)}
    with pytest.raises(ApproachBlocked):
        ask(world, "arm", with_ways(goal, **{"approach": None, **longer}), looks=300)
