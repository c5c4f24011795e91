"""The funnel adds up."""

import json
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.goals.funnel import (
    Funnel,
    PairTally,
    funnel_evidence,
    funnel_summary,
    rejections,
)

# The names in evidence that differ from those of the fields.
_KEYS = {
    "num_samples": "tried",
    "num_samples_violating": "breaking",
    "num_goals_violating": "violating",
    "num_with_linear_moves": "approach_ok",
}


def drawn(seed: int) -> Funnel:
    rng = np.random.default_rng(seed)
    counts = [int(rng.integers(1, 1000))]
    for _ in range(4):
        counts.append(int(rng.integers(0, counts[-1] + 1)))
    left, tallies = counts[2] - counts[3], []
    for i in range(rng.integers(0, 5)):
        count = int(rng.integers(0, left + 1))
        if count:
            tallies.append(PairTally((f"a{i}", "b"), count, 0.001, 0.02))
        left -= count
    approached = int(rng.integers(counts[4], counts[3] + 1))
    return Funnel(*counts, tuple(tallies), num_with_linear_moves=approached)


@given(seed=st.integers(0, 2**32 - 1))
def test_every_sample_is_distinct_or_has_a_reason(seed: int) -> None:
    funnel = drawn(seed)
    assert sum(one.count for one in rejections(funnel)) + funnel.distinct == funnel.num_samples
    assert all(one.count > 0 for one in rejections(funnel))
    colliding = sum(one.count for one in rejections(funnel) if one.reason == "collision")
    assert colliding == funnel.within_limits - funnel.collision_free
    evidence = json.loads(json.dumps(funnel_evidence(funnel)))
    keys = {_KEYS.get(field.name, field.name) for field in fields(Funnel)}
    assert keys <= set(evidence)
    assert all(evidence[key] == getattr(funnel, name) for name, key in _KEYS.items())
    blocked = sum(one.count for one in rejections(funnel) if one.reason == "approach")
    assert blocked == funnel.collision_free - funnel.num_with_linear_moves
    shares = sum(one["share"] for one in evidence["rejected"])
    assert abs(shares + funnel.distinct / funnel.num_samples - 1) < 1e-9


def test_the_sentence_says_what_was_hit_how_often_and_how_deep() -> None:
    hits = (PairTally(("table", "arm::forearm_link"), 31, 0.008, 0.031),)
    funnel = Funnel(300, 37, 37, 6, 4, hits, num_with_linear_moves=5)
    assert funnel_summary(funnel) == (
        "300 tried, 37 converged, 31 of them hit table-arm::forearm_link by 8 to 31 mm, "
        "6 are free, 1 of these have no free approach or retreat, 4 are distinct"
    )


@pytest.mark.parametrize(
    ("num_free", "counts", "text"),
    [
        (0, (), "9 of them collide"),
        (2, (4, 3), "4 of them hit a0-b by 1 to 2 mm, 3 of them hit a1-b by 1 to 2 mm, 2 are free"),
        (0, (2, 1), "(3 measured: 2 of them hit a0-b by 1 to 2 mm, 1 of them hit a1-b by 1 to 2"),
        (0, (4, 2, 1, 1, 1), "1 of them hit a2-b by 1 to 2 mm, 2 of them hit other pairs"),
    ],
)
def test_the_sentence_names_the_most_frequent_pairs_of_those_measured(
    num_free: int, counts: tuple[int, ...], text: str
) -> None:
    hits = tuple(PairTally((f"a{i}", "b"), n, 0.001, 0.002) for i, n in enumerate(counts))
    sentence = funnel_summary(Funnel(9, 9, 9, num_free, num_free, hits))
    assert text in sentence
    assert "otherwise" not in sentence


def test_nothing_tried_is_nothing_to_say() -> None:
    assert funnel_evidence(Funnel())["rejected"] == []
