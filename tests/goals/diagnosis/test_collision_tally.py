"""Which of many colliding configurations are measured, and which pair comes first."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.request.deadline import NO_DEADLINE
from planning.goals.diagnosis.collision_tally import count_collisions


class World:
    """Has the pair of bodies that the first coordinate numbers in collision."""

    def __init__(self) -> None:
        self.measured: list[float] = []

    def distance_probe(self, _: Any) -> "World":
        return self

    def embed(self, _: Any, q: Any) -> Any:
        return q

    def violations(self, q: Any) -> tuple[BodyPair, ...]:
        self.measured.append(float(q[1]))
        return (BodyPair((f"a{int(q[0])}", "b"), -0.01, np.zeros((2, 3))),)


QUERY: Any = SimpleNamespace(group=None, margins=SimpleNamespace(of=lambda *_: 0.0))


def counted(pairs: list[int], num_measured: int) -> tuple[Any, list[float]]:
    world: Any = World()
    rows = [np.array([pair, k], dtype=float) for k, pair in enumerate(pairs)]
    tally = count_collisions(world, QUERY, rows, num_measured, NO_DEADLINE)
    return tally.summary, world.measured


def test_the_most_frequent_pair_comes_first_though_others_were_found_before() -> None:
    summary, _ = counted([0] * 10 + [1] * 90, 5)
    assert [(one.bodies, one.count) for one in summary] == [(("a1", "b"), 4), (("a0", "b"), 1)]


@given(st.integers(0, 40), st.integers(0, 10))
def test_different_configurations_are_measured_from_all_of_them(count: int, most: int) -> None:
    summary, measured = counted([0] * count, most)
    assert len(set(measured)) == len(measured) == min(count, most)
    assert sum(one.count for one in summary) == len(measured)
    gaps = np.diff([*measured, count])
    assert gaps.size == 0 or gaps.max() <= -(-count // max(1, min(count, most)))


@pytest.mark.parametrize("count", [1, 3])
def test_all_are_measured_where_they_are_few(count: int) -> None:
    assert counted([0] * count, 5)[1] == list(range(count))
