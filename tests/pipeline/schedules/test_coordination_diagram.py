"""Blocked delays of two motions, against distances of discs that need no engine."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.pipeline.schedules.blocked_delays import BlockedDelays, Encounter
from planning.pipeline.schedules.coordination_diagram import PairOfMotions, blocked_delays
from planning.pipeline.schedules.motion_spans import MotionSpans
from planning.pipeline.schedules.shared_bodies import SharedPairs
from planning.world.world import World
from tests.clocks import no_hurry
from tests.discs import disc_distance, discs, straight
from tests.profiles import only_campaign, rng_of

# Blocked intervals end some hundredths of a second beyond the truth.
EXCESS = 0.05


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return discs(tmp_path_factory.mktemp("discs"), {"a": (-1, 0), "b": (1, 0)})


def _blocked(world: World, a: TimedTrajectory, b: TimedTrajectory) -> BlockedDelays:
    groups = [world.group("a"), world.group("b")]
    shared = SharedPairs(world.drake, groups, world.margins())
    spans = MotionSpans(world, groups[0], a), MotionSpans(world, groups[1], b)
    pair = PairOfMotions(0, 1, world.group("a+b"), spans)
    return blocked_delays(world, pair, shared, no_hurry())


@only_campaign("7 s")
@given(seed=st.integers(0, 2**32 - 1))
def test_no_delay_is_free_at_which_the_discs_touch(world: World, seed: int) -> None:
    rng = rng_of(seed)
    a, b = (
        straight(world, name, *rng.uniform(-0.6, 0.6, (rng.integers(2, 4), 2)))
        for name in ("a", "b")
    )
    free = _blocked(world, a, b).free
    for delay in rng.uniform(-a.duration - 1, b.duration + 1, 40):
        truth = disc_distance(a, b, float(delay))
        is_free = any(low <= delay <= high for low, high in free)
        assert not (is_free and truth <= 0), (delay, truth)
    # What is blocked is near a delay at which they touch, or all but touch.
    for delay in rng.uniform(-a.duration - 1, b.duration + 1, 10):
        near = delay + np.linspace(-EXCESS, EXCESS, 11)
        if all(disc_distance(a, b, float(r)) > 0.02 for r in near):
            assert any(low <= delay <= high for low, high in free), delay


def test_discs_that_pass_beside_each_other_are_free_at_every_delay(world: World) -> None:
    a = straight(world, "a", (-1, 0), (1, 0))
    b = straight(world, "b", (1, 0.22), (-1, 0.22))
    assert _blocked(world, a, b).free == [(-np.inf, np.inf)]


def test_an_end_in_the_way_blocks_all_delays_on_one_side(world: World) -> None:
    """Disc b ends in the way of a, so it may come after a only."""
    a = straight(world, "a", (-1, 0), (1, 0))
    b = straight(world, "b", (0, 1), (0, 0))
    (only,) = _blocked(world, a, b).free
    assert only[1] == np.inf
    truth = next(r for r in np.arange(-3, 3, 0.005) if disc_distance(a, b, float(r)) > 0)
    assert truth - 0.005 <= only[0] <= truth + EXCESS


def test_the_union_covers_what_it_covers() -> None:
    blocked, met = BlockedDelays(), Encounter(np.zeros(1), np.zeros(1), (0.0, 0.0))
    assert not blocked.are_covered(np.zeros(1), np.ones(1)).any()
    for low, high in ((0.0, 1.0), (1.0, 2.0), (4.0, np.inf), (0.5, 0.7)):
        blocked.add(low, high, met)
    blocked.merge()
    assert blocked.free == [(-np.inf, 0.0), (2.0, 4.0)]
    low = np.array([0.1, -0.1, 1.5, 2.5, 5.0, 5.0])
    high = np.array([1.9, 0.1, 2.5, 3.5, np.inf, 6.0])
    assert blocked.are_covered(low, high).tolist() == [True, False, False, False, True, True]
