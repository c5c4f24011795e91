"""A verdict of the kernel is never wrong, whatever it runs on."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform

from planning.domain.robot.joints import JointGroup
from planning.kernel.native import native
from tests.certify.chains import FLOATING, PLANAR, Builder, P, R, Robot, random_robot
from tests.kernel.conftest import COLLIDING, FREE, UNSURE, Judged
from tests.profiles import num_cases

# Nearer to a margin than that the kernel may leave the answer to Drake [m].
UNSURE_WITHIN = 1e-4


def lane_kernels() -> list[str]:
    module: Any = native()
    return module.lane_kernels() if module else ["none"]


def _robot_that_does_not_float() -> Robot:
    robots = (random_robot(np.random.default_rng(seed), 5, 12) for seed in range(100))
    return next(r for r in robots if r.group.num_positions == r.group.num_velocities)


@settings(max_examples=num_cases(6))
@given(
    seed=st.integers(0, 2**32 - 1),
    margin=st.sampled_from([0.0, 0.001, 0.02, 0.1]),
    spread=st.sampled_from([0.2, 0.5, 3.0]),
)
def test_no_verdict_is_wrong_on_random_robots(seed: int, margin: float, spread: float) -> None:
    rng = np.random.default_rng(seed)
    judged = Judged.of(random_robot(rng, int(rng.integers(1, 9)), int(rng.integers(0, 20))))
    qs = judged.configurations(rng, 48, spread)
    drake = judged.drake(qs, margin)
    for name in lane_kernels():
        verdicts = judged.checker(margin, name).judge(qs)
        assert not (drake[verdicts == COLLIDING]).any(), name
        assert drake[verdicts == FREE].all(), name
        assert (verdicts == UNSURE).mean() < 0.2, name


@pytest.mark.parametrize("kernel", lane_kernels())
@given(
    beyond=st.one_of(st.floats(UNSURE_WITHIN, 0.05), st.floats(-0.05, -UNSURE_WITHIN)),
    margin=st.sampled_from([0.0, 0.01]),
)
def test_free_ends_where_the_margin_ends(kernel: str, beyond: float, margin: float) -> None:
    checker = sliding_sphere().checker(margin, kernel)
    verdict = checker.judge_one(np.array([0.9 - margin - beyond]))
    assert verdict == (FREE if beyond > 0 else COLLIDING)


@pytest.mark.parametrize("kernel", lane_kernels())
@given(
    beyond=st.floats(-UNSURE_WITHIN, UNSURE_WITHIN).filter(lambda beyond: abs(beyond) > 1e-12),
    margin=st.sampled_from([0.0, 0.01]),
)
def test_where_the_margin_ends_no_verdict_is_wrong(
    kernel: str, beyond: float, margin: float
) -> None:
    checker = sliding_sphere().checker(margin, kernel)
    verdict = checker.judge_one(np.array([0.9 - margin - beyond]))
    assert verdict != (COLLIDING if beyond > 0 else FREE)


@cache
def sliding_sphere() -> Judged:
    """Return a sphere that slides towards a wall: at q it is 0.9 m - q away."""
    builder = Builder()
    builder.link(P, Sphere(0.1), axis=np.array([1.0, 0.0, 0.0]))
    builder.obstacle("wall", Box(0.2, 2.0, 2.0), RigidTransform(np.array([1.1, 0.0, 0.0])))
    return Judged.of(builder.build())


@pytest.mark.parametrize("kind", [R, PLANAR, P, FLOATING])
@pytest.mark.parametrize("away", [0.0, 50.0, 5e3])
def test_far_from_the_origin_verdicts_get_unsure_but_not_wrong(kind: Any, away: float) -> None:
    builder = Builder()
    far = RigidTransform(np.array([away, 0.0, 0.0]))
    builder.link(kind, Sphere(0.1), x_pf=far)
    builder.obstacle("ball", Sphere(0.1), RigidTransform(np.array([away + 0.25, 0.0, 0.0])))
    judged = Judged.of(builder.build())
    qs = judged.configurations(np.random.default_rng(1), 200, 0.1)
    verdicts, drake = judged.checker(0.0).judge(qs), judged.drake(qs, 0.0)
    assert drake[verdicts == FREE].all()
    assert not drake[verdicts == COLLIDING].any()
    assert (verdicts == UNSURE).mean() < 0.5


def test_whole_turns_change_nothing() -> None:
    rng = np.random.default_rng(5)
    builder = Builder()
    arm = builder.link(R, Box(0.1, 0.1, 0.6), x_bg=RigidTransform(np.array([0.0, 0.0, 0.3])))
    builder.link(
        R, Sphere(0.1), arm, RigidTransform(np.array([0.3, 0.0, 0.6])), np.array([1.0, 0, 0])
    )
    builder.obstacle("post", Box(0.1, 0.1, 1.0), RigidTransform(np.array([0.4, 0.0, 0.4])))
    judged = Judged.of(builder.build())
    qs = judged.configurations(rng, 100, 1.0)
    turned = qs + 2 * np.pi * rng.integers(-40, 40, qs.shape)
    checker = judged.checker(0.0)
    np.testing.assert_array_equal(checker.judge(qs), checker.judge(turned))


@pytest.mark.parametrize("kernel", lane_kernels())
def test_batches_motions_and_single_questions_agree(kernel: str) -> None:
    rng = np.random.default_rng(8)
    judged = Judged.of(_robot_that_does_not_float())
    checker = judged.checker(0.01, kernel)
    origins = judged.configurations(rng, 40, 0.3)
    steps = rng.normal(0.0, 0.3, origins.shape)
    verdicts, unsure = checker.judge_motions(origins, steps, 0.05)
    for j, (origin, step) in enumerate(zip(origins, steps, strict=True)):
        n = max(1, int(np.ceil(np.linalg.norm(step) / 0.05 - 1e-9)))
        qs = origin + (np.arange(1, n + 1) / n)[:, None] * step
        one_by_one = np.array([checker.judge_one(q) for q in qs])
        np.testing.assert_array_equal(one_by_one, checker.judge(qs))
        if (one_by_one == COLLIDING).any():
            assert verdicts[j] == COLLIDING
        elif (one_by_one == UNSURE).any():
            assert verdicts[j] == UNSURE
            rows = unsure[unsure[:, 0] == j]
            assert sorted(rows[:, 1]) == list(np.flatnonzero(one_by_one == UNSURE) + 1)
        else:
            assert verdicts[j] == FREE


@pytest.mark.parametrize(("reach", "expected"), [(0.0, FREE), (0.6, UNSURE)])
def test_what_the_group_does_not_move_is_judged_once(reach: float, expected: int) -> None:
    """A slider outside of the group touches a wall or does not: if so, nothing is called free."""
    builder = Builder()
    builder.link(R, Box(0.2, 0.2, 0.2))
    slider = RigidTransform(np.array([2.0, 0.0, 0.0]))
    builder.link(P, Sphere(0.1), x_pf=slider, axis=np.array([1.0, 0.0, 0.0]))
    builder.obstacle("wall", Box(0.2, 1.0, 1.0), RigidTransform(np.array([2.7, 0.0, 0.0])))
    robot = builder.build()
    still = JointGroup("robot", robot.group.joints[:1], ())
    judged = Judged.of(replace(robot, group=still, state=np.array([0.0, reach])))
    checker = judged.checker(0.0)
    assert len(checker.doubtful_fixed_pairs) == (expected == UNSURE)
    qs = np.linspace(-1.0, 1.0, 40)[:, None]
    assert (checker.judge(qs) == expected).all()
    np.testing.assert_array_equal(judged.drake(qs, 0.0), expected == FREE)


@pytest.mark.parametrize("kernel", lane_kernels())
@pytest.mark.parametrize("wild", [np.nan, np.inf, -np.inf, 1e9, 1e300])
def test_of_wild_numbers_nothing_is_sure(kernel: str, wild: float) -> None:
    """And their neighbours in a batch are judged as ever."""
    builder = Builder()
    arm = builder.link(R, Box(0.1, 0.1, 0.6), x_bg=RigidTransform(np.array([0.0, 0.0, 0.3])))
    builder.link(P, Sphere(0.1), arm, axis=np.array([1.0, 0.0, 0.0]))
    builder.obstacle("post", Box(0.1, 0.1, 1.0), RigidTransform(np.array([0.4, 0.0, 0.4])))
    judged = Judged.of(builder.build())
    checker = judged.checker(0.0, kernel)
    qs = judged.configurations(np.random.default_rng(2), 33, 1.0)
    before = checker.judge(qs)
    for coordinate in range(2):
        strange = qs.copy()
        strange[::3, coordinate] = wild
        verdicts = checker.judge(strange)
        assert (verdicts[::3] == UNSURE).all()
        others = np.arange(33) % 3 > 0
        np.testing.assert_array_equal(verdicts[others], before[others])
    step = np.array([[0.0, wild]])
    with pytest.raises(ValueError, match="a motion is finite"):
        checker.judge_motions(np.zeros((1, 2)), step, 0.05)


def test_bad_arguments_are_refused() -> None:
    judged = Judged.of(random_robot(np.random.default_rng(0), 3, 3))
    checker = judged.checker(0.0)
    nq = judged.robot.group.num_positions
    with pytest.raises(ValueError, match=r"qs has shape \(2, 5\), not \(n, 4\)"):
        checker.judge(np.zeros((2, nq + 1)))
    with pytest.raises(ValueError, match="resolution"):
        checker.judge_motions(np.zeros((1, nq)), np.zeros((1, nq)), 0.0)
    with pytest.raises(ValueError, match="no kernel mmx"):
        judged.checker(0.0, "mmx")
