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
from tests.kernel.conftest import COLLIDING, FREE, UNSURE, ComparedRobot
from tests.profiles import num_cases

# Nearer to a margin than that the kernel may leave the answer to Drake [m].
UNSURE_WITHIN = 1e-4


def batch_kernels() -> list[str]:
    module: Any = native()
    return module.batch_kernels() if module else ["none"]


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
    compared = ComparedRobot.of(
        random_robot(rng, int(rng.integers(1, 9)), int(rng.integers(0, 20)))
    )
    qs = compared.configurations(rng, 48, spread)
    drake = compared.drake(qs, margin)
    for name in batch_kernels():
        verdicts = compared.checker(margin, name).check(qs)
        assert not (drake[verdicts == COLLIDING]).any(), name
        assert drake[verdicts == FREE].all(), name
        assert (verdicts == UNSURE).mean() < 0.2, name


@pytest.mark.parametrize("kernel", batch_kernels())
@given(
    beyond=st.one_of(st.floats(UNSURE_WITHIN, 0.05), st.floats(-0.05, -UNSURE_WITHIN)),
    margin=st.sampled_from([0.0, 0.01]),
)
def test_free_ends_where_the_margin_ends(kernel: str, beyond: float, margin: float) -> None:
    checker = sliding_sphere().checker(margin, kernel)
    verdict = checker.check_one(np.array([0.9 - margin - beyond]))
    assert verdict == (FREE if beyond > 0 else COLLIDING)


@pytest.mark.parametrize("kernel", batch_kernels())
@given(
    beyond=st.floats(-UNSURE_WITHIN, UNSURE_WITHIN).filter(lambda beyond: abs(beyond) > 1e-12),
    margin=st.sampled_from([0.0, 0.01]),
)
def test_where_the_margin_ends_no_verdict_is_wrong(
    kernel: str, beyond: float, margin: float
) -> None:
    checker = sliding_sphere().checker(margin, kernel)
    verdict = checker.check_one(np.array([0.9 - margin - beyond]))
    assert verdict != (COLLIDING if beyond > 0 else FREE)


@cache
def sliding_sphere() -> ComparedRobot:
    """Return a sphere that slides towards a wall: at q it is 0.9 m - q away."""
    builder = Builder()
    builder.link(P, Sphere(0.1), axis=np.array([1.0, 0.0, 0.0]))
    builder.obstacle("wall", Box(0.2, 2.0, 2.0), RigidTransform(np.array([1.1, 0.0, 0.0])))
    return ComparedRobot.of(builder.build())


@pytest.mark.parametrize("kind", [R, PLANAR, P, FLOATING])
@pytest.mark.parametrize("away", [0.0, 50.0, 5e3])
def test_far_from_the_origin_verdicts_get_unsure_but_not_wrong(kind: Any, away: float) -> None:
    builder = Builder()
    far = RigidTransform(np.array([away, 0.0, 0.0]))
    builder.link(kind, Sphere(0.1), x_pf=far)
    builder.obstacle("ball", Sphere(0.1), RigidTransform(np.array([away + 0.25, 0.0, 0.0])))
    compared = ComparedRobot.of(builder.build())
    qs = compared.configurations(np.random.default_rng(1), 200, 0.1)
    verdicts, drake = compared.checker(0.0).check(qs), compared.drake(qs, 0.0)
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
    compared = ComparedRobot.of(builder.build())
    qs = compared.configurations(rng, 100, 1.0)
    turned = qs + 2 * np.pi * rng.integers(-40, 40, qs.shape)
    checker = compared.checker(0.0)
    np.testing.assert_array_equal(checker.check(qs), checker.check(turned))


@pytest.mark.parametrize("kernel", batch_kernels())
def test_batches_motions_and_single_questions_agree(kernel: str) -> None:
    rng = np.random.default_rng(8)
    compared = ComparedRobot.of(_robot_that_does_not_float())
    checker = compared.checker(0.01, kernel)
    origins = compared.configurations(rng, 40, 0.3)
    steps = rng.normal(0.0, 0.3, origins.shape)
    verdicts, unsure = checker.check_motions(origins, steps, 0.05)
    for j, (origin, step) in enumerate(zip(origins, steps, strict=True)):
        n = max(1, int(np.ceil(np.linalg.norm(step) / 0.05 - 1e-9)))
        qs = origin + (np.arange(1, n + 1) / n)[:, None] * step
        one_by_one = np.array([checker.check_one(q) for q in qs])
        np.testing.assert_array_equal(one_by_one, checker.check(qs))
        if (one_by_one == COLLIDING).any():
            assert verdicts[j] == COLLIDING
        elif (one_by_one == UNSURE).any():
            assert verdicts[j] == UNSURE
            rows = unsure[unsure[:, 0] == j]
            assert sorted(rows[:, 1]) == list(np.flatnonzero(one_by_one == UNSURE) + 1)
        else:
            assert verdicts[j] == FREE


@pytest.mark.parametrize("kernel", batch_kernels())
def test_what_was_asked_before_changes_no_verdict(kernel: str) -> None:
    """The pair that blocked the last motion is tried first: verdicts and samples are the same."""
    rng = np.random.default_rng(9)
    compared = ComparedRobot.of(_robot_that_does_not_float())
    origins = compared.configurations(rng, 60, 0.3)
    steps = rng.normal(0.0, 0.3, origins.shape)
    anew = [
        compared.checker(0.01, kernel).check_motions(origins[j : j + 1], steps[j : j + 1], 0.05)
        for j in range(len(origins))
    ]
    checker = compared.checker(0.01, kernel)
    for j in rng.permutation(len(origins)):
        verdict, unsure = checker.check_motions(origins[j : j + 1], steps[j : j + 1], 0.05)
        assert verdict[0] == anew[j][0][0]
        np.testing.assert_array_equal(unsure, anew[j][1])
    assert {int(verdict[0]) for verdict, _ in anew} >= {FREE, COLLIDING}


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
    compared = ComparedRobot.of(replace(robot, group=still, state=np.array([0.0, reach])))
    checker = compared.checker(0.0)
    assert len(checker.undecided_static_pairs) == (expected == UNSURE)
    qs = np.linspace(-1.0, 1.0, 40)[:, None]
    assert (checker.check(qs) == expected).all()
    np.testing.assert_array_equal(compared.drake(qs, 0.0), expected == FREE)


@pytest.mark.parametrize("kernel", batch_kernels())
@pytest.mark.parametrize("wild", [np.nan, np.inf, -np.inf, 1e9, 1e300])
def test_of_wild_numbers_nothing_is_sure(kernel: str, wild: float) -> None:
    """And their neighbours in a batch are compared as ever."""
    builder = Builder()
    arm = builder.link(R, Box(0.1, 0.1, 0.6), x_bg=RigidTransform(np.array([0.0, 0.0, 0.3])))
    builder.link(P, Sphere(0.1), arm, axis=np.array([1.0, 0.0, 0.0]))
    builder.obstacle("post", Box(0.1, 0.1, 1.0), RigidTransform(np.array([0.4, 0.0, 0.4])))
    compared = ComparedRobot.of(builder.build())
    checker = compared.checker(0.0, kernel)
    qs = compared.configurations(np.random.default_rng(2), 33, 1.0)
    before = checker.check(qs)
    for coordinate in range(2):
        strange = qs.copy()
        strange[::3, coordinate] = wild
        verdicts = checker.check(strange)
        assert (verdicts[::3] == UNSURE).all()
        others = np.arange(33) % 3 > 0
        np.testing.assert_array_equal(verdicts[others], before[others])
    step = np.array([[0.0, wild]])
    with pytest.raises(ValueError, match="a motion is finite"):
        checker.check_motions(np.zeros((1, 2)), step, 0.05)


def test_bad_arguments_are_refused() -> None:
    compared = ComparedRobot.of(random_robot(np.random.default_rng(0), 3, 3))
    checker = compared.checker(0.0)
    nq = compared.robot.group.num_positions
    with pytest.raises(ValueError, match=r"qs has shape \(2, 5\), not \(n, 4\)"):
        checker.check(np.zeros((2, nq + 1)))
    with pytest.raises(ValueError, match="resolution"):
        checker.check_motions(np.zeros((1, nq)), np.zeros((1, nq)), 0.0)
    with pytest.raises(ValueError, match="no kernel mmx"):
        compared.checker(0.0, "mmx")
