"""The referee sees what collides, also between the knots, and where a motion begins and ends."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.motion_bench_maker.problems import Obstacle, Problem
from benchmarks.motion_bench_maker.referee import Polynomials, Referee
from benchmarks.motion_bench_maker.robots import ROBOTS, robot_files
from tests.benchmarks.conftest import GOAL, JOINTS, START

FAR = (0.0, 0.0, 2.5)
AHEAD = (0.4, 0.0, 0.6)
PLATE = (0.3, 0.002, 0.4)


def straight(start: list[float], goal: list[float]) -> Polynomials:
    slopes = (np.array(goal) - start) / 2.0
    return Polynomials(
        tuple(JOINTS),
        np.array([0.0, 2.0]),
        np.array([start]),
        np.stack([np.zeros(7), slopes])[None],
    )


def referee(models: Path, position: tuple[float, ...], dims: tuple[float, ...]) -> Referee:
    box = Obstacle("box", "box", dims, position, (1.0, 0.0, 0.0, 0.0))
    problem = Problem("swing", 1, tuple(JOINTS), tuple(START), tuple(GOAL), (box,))
    return Referee(robot_files(models, ROBOTS["panda"]), problem)


@pytest.mark.parametrize("dims", [(0.1, 0.1, 0.4), PLATE])
def test_a_motion_through_a_box_is_not_free(models: Path, dims: tuple[float, ...]) -> None:
    swing = straight(START, GOAL)
    hit, clear = referee(models, AHEAD, dims), referee(models, FAR, dims)
    assert hit.is_valid
    assert clear.is_valid
    assert not hit.is_free(swing)
    assert clear.is_free(swing)


def test_a_touch_at_the_turning_point_is_seen(models: Path) -> None:
    judge = referee(models, AHEAD, PLATE)

    def turned(angle: float) -> list[float]:
        return [angle, *START[1:]]

    free, touching = -0.7, 0.0
    while touching - free > 1e-6:
        middle = (free + touching) / 2
        at_rest = straight(turned(middle), turned(middle))
        free, touching = (middle, touching) if judge.is_free(at_rest) else (free, middle)

    def dip(peak: float) -> Polynomials:
        """Return q1(t) = peak - 0.2 (t - 1)^2 for t in [0, 2.3]."""
        coefficients = np.zeros((1, 3, 7))
        coefficients[0, 1:, 0] = 0.4, -0.2
        base = np.array([turned(peak - 0.2)])
        return Polynomials(tuple(JOINTS), np.array([0.0, 2.3]), base, coefficients)

    assert judge.is_free(dip(free - 1e-6))
    assert not judge.is_free(dip(touching + 3e-5))


def test_a_start_inside_a_box_is_not_valid(models: Path) -> None:
    assert not referee(models, (0.0, 0.0, 0.4), (0.3, 0.3, 0.3)).is_valid


def test_links_that_cross_are_not_free(models: Path) -> None:
    folded = [0.0, 1.7, 0.0, -3.0, 0.0, 0.1, 0.0]
    assert not referee(models, FAR, PLATE).is_free(straight(START, folded))


def test_ends_are_where_they_were_asked_to_be(models: Path) -> None:
    judge = referee(models, FAR, PLATE)
    late, near = [*START[:6], START[6] + 1e-3], [*GOAL[:6], GOAL[6] + 1e-3]
    for pose in (False, True):
        assert judge.is_from_start_to_goal(straight(START, GOAL), pose=pose)
        assert not judge.is_from_start_to_goal(straight(START, near), pose=pose)
        assert not judge.is_from_start_to_goal(straight(late, GOAL), pose=pose)


def test_columns_may_come_in_any_order(models: Path) -> None:
    swing = straight(START, GOAL)
    turned = replace(
        swing,
        joints=swing.joints[::-1],
        bases=swing.bases[:, ::-1],
        coefficients=swing.coefficients[:, :, ::-1],
    )
    judge = referee(models, AHEAD, (0.1, 0.1, 0.4))
    assert judge.is_from_start_to_goal(turned, pose=False)
    assert not judge.is_free(turned)


@given(st.integers(0, 2**32 - 1))
def test_samples_are_near_one_another_and_reach_both_ends(seed: int) -> None:
    rng = np.random.default_rng(seed)
    breaks = np.cumsum([0.0, *rng.uniform(0.01, 0.5, 3)])
    coefficients = rng.normal(size=(3, 5, 7))
    bases = np.zeros((3, 7))
    for i in range(2):  # let the pieces join
        powers = (breaks[i + 1] - breaks[i]) ** np.arange(5)
        bases[i + 1] = bases[i] + powers @ coefficients[i] - coefficients[i + 1, 0]
    samples = Polynomials(tuple(JOINTS), breaks, bases, coefficients).samples()
    steps = np.linalg.norm(np.diff(samples, axis=0), axis=1)
    assert steps.max() <= 0.002 * (1 + 1e-9)
    last = (breaks[3] - breaks[2]) ** np.arange(5)
    np.testing.assert_allclose(samples[0], bases[0] + coefficients[0, 0])
    np.testing.assert_allclose(samples[-1], bases[2] + last @ coefficients[2])
