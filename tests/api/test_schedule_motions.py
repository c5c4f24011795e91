"""Schedules: proven, as early as brute force finds them, and typed failures with evidence."""

from collections.abc import Sequence
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import planning
from planning import GroupMotion
from planning.domain.report.motion_schedule import MotionSchedule
from planning.errors import DeadlineExceeded, NotCertified, ProblemInvalid, ScheduleNotFound
from planning.world.world import World
from tests.clocks import after_looks, no_hurry
from tests.discs import disc_distance, discs, straight
from tests.profiles import only_campaign, rng_of

# Delays are this much larger than they need be, at most [s]; where discs all but touch [m].
EXCESS, NEAR = 0.06, 0.02
STEP = 0.1


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    starts = {"a": (-1, 0), "b": (0, -1), "c": (2, 2)}
    return discs(tmp_path_factory.mktemp("discs"), starts)


def _motion(world: World, name: str, *way: Sequence[float], seconds: float = 2.0) -> GroupMotion:
    return GroupMotion(name, straight(world, name, *way, seconds=seconds))


def _schedule(world: World, *motions: GroupMotion, **more: float) -> MotionSchedule:
    return planning.schedule_motions(world, motions, deadline=no_hurry(), **more)


def _smallest_distance(motions: Sequence[GroupMotion], delays: Sequence[float]) -> float:
    return min(
        disc_distance(motions[i].trajectory, motions[j].trajectory, delays[j] - delays[i])
        for i, j in combinations(range(len(motions)), 2)
    )


@only_campaign("many schedules: half a minute")
def test_of_two_crossing_discs_the_second_waits_as_long_as_it_must(world: World) -> None:
    motions = [_motion(world, "a", (-1, 0), (1, 0)), _motion(world, "b", (0, -1), (0, 1))]
    found = _schedule(world, *motions)
    assert found.certificate.proven
    assert found.delays[0] == 0
    delays = np.arange(0, 1, 0.001)
    distances = [_smallest_distance(motions, (0, d)) for d in delays]
    least = delays[np.array(distances) > 0][0]
    assert least - 0.001 <= found.delays[1] <= least + 0.02
    (wait,) = found.waits
    assert (wait.group, wait.for_group, wait.delay) == ("b", "a", found.delays[1])
    assert set(wait.pair) == {"a::disc", "b::disc"}
    assert found.motion.group == "a+b"
    assert found.duration == found.delays[1] + 2.0
    # Then they are near each other.
    at = np.array([wait.time])
    q = found.motion.trajectory.positions(at)[0]
    assert np.linalg.norm(q[:2] - q[2:]) < 0.3


def test_the_order_says_who_waits(world: World) -> None:
    a, b = _motion(world, "a", (-1, 0), (1, 0)), _motion(world, "b", (0, -1), (0, 1))
    found = _schedule(world, b, a)
    assert found.groups == ("b", "a")
    assert [wait.group for wait in found.waits] == ["a"]


def test_the_first_waits_only_for_one_that_stands_in_its_way(tmp_path: Path) -> None:
    world = discs(tmp_path, {"a": (-1, 0), "b": (0, 0)})
    a = _motion(world, "a", (-1, 0), (1, 0))
    b = _motion(world, "b", (0, 0), (0, 1), seconds=6.0)
    found = _schedule(world, a, b)
    assert found.delays[1] == 0
    (wait,) = found.waits
    assert (wait.group, wait.for_group) == ("a", "b")
    assert _smallest_distance((a, b), found.delays) > 0
    earlier = (found.delays[0] - EXCESS, 0.0)
    assert _smallest_distance((a, b), earlier) <= 0


def test_without_need_none_waits(world: World) -> None:
    found = _schedule(
        world, _motion(world, "a", (-1, 0), (-1, 1)), _motion(world, "b", (0, -1), (1, -1))
    )
    assert found.delays == (0.0, 0.0)
    assert found.waits == ()


def test_margins_are_kept_and_a_margin_of_the_request_too(world: World) -> None:
    motions = [_motion(world, "a", (-1, 0), (1, 0)), _motion(world, "b", (0, -1), (0, 1))]
    delays = []
    for margin in (0.0, 0.05, 0.2):
        found = _schedule(world, *motions, margin=margin)
        assert _smallest_distance(motions, found.delays) >= margin
        assert found.certificate.min_clearance >= margin - 1e-6
        delays.append(found.delays[1])
    assert delays == sorted(set(delays))


@only_campaign("many schedules: half a minute")
@given(seed=st.integers(0, 2**32 - 1))
def test_no_delays_of_a_grid_are_smaller(world: World, seed: int) -> None:
    """Brute force over delays in lexicographic order, for two and for three discs."""
    rng = rng_of(seed)
    names = ("a", "b", "c")[: rng.integers(2, 4)]
    motions = [
        _motion(world, name, *rng.uniform(-0.7, 0.7, (2, 2)), seconds=float(rng.uniform(1, 2)))
        for name in names
    ]
    largest = sum(motion.trajectory.duration for motion in motions)
    grid = np.arange(0, largest + STEP, STEP)
    count = len(grid)
    is_clear = {
        (i, j): {
            k
            for k in range(1 - count, count)
            if disc_distance(motions[i].trajectory, motions[j].trajectory, k * STEP) > NEAR
        }
        for i, j in combinations(range(len(motions)), 2)
    }
    first = next(
        (
            delays
            for delays in product(range(count), repeat=len(motions))
            if min(delays) == 0
            and all(delays[j] - delays[i] in own for (i, j), own in is_clear.items())
        ),
        None,
    )
    if first is None:
        return  # there may be one between the instants of the grid
    found = _schedule(world, *motions)
    assert found.certificate.proven
    assert _smallest_distance(motions, found.delays) > 0
    bound = tuple(STEP * k for k in first)
    for delay, other in zip(found.delays, bound, strict=True):
        assert delay <= other + EXCESS, (found.delays, bound)
        if delay < other - EXCESS:
            break  # earlier in the order, so the ones after it may be later


def test_two_that_change_places_have_no_schedule(tmp_path: Path) -> None:
    world = discs(tmp_path, {"a": (-1, 0), "b": (1, 0)})
    with pytest.raises(ScheduleNotFound) as failure:
        _schedule(world, _motion(world, "a", (-1, 0), (1, 0)), _motion(world, "b", (1, 0), (-1, 0)))
    evidence = failure.value.evidence
    assert failure.value.code == "schedule_not_found"
    assert failure.value.stage == "schedule"
    assert evidence["groups"] == ["a", "b"]
    assert set(evidence["pair"]) == {"a::disc", "b::disc"}
    first, second = evidence["encounters"]
    assert (first["waiting"], second["waiting"]) == ("b", "a")
    # However long b waits, a comes to where b stands.
    assert first["times"]["b"] == 0.0
    assert 1.0 < first["times"]["a"] <= 2.0
    assert evidence["time"] == first["times"]["a"]


def test_three_that_wait_for_each_other_in_a_circle_have_no_schedule(tmp_path: Path) -> None:
    """Each ends where the next one starts, at the corners of a triangle too small to turn in."""
    corners = [(0.0, 0.0), (0.3, 0.0), (0.15, 0.26)]
    world = discs(tmp_path, dict(zip("abc", corners, strict=True)))
    ways = zip("abc", corners, [*corners[1:], corners[0]], strict=True)
    motions = [_motion(world, name, begin, end) for name, begin, end in ways]
    for two in combinations(motions, 2):
        starts = {motion.group: motion.trajectory.start.tolist() for motion in two}
        assert _schedule(discs(tmp_path, starts), *two).certificate.proven
    with pytest.raises(ScheduleNotFound, match="circle") as failure:
        _schedule(world, *motions)
    evidence = failure.value.evidence
    assert evidence["groups"] == ["a", "b", "c"]
    circle = [set(entry["times"]) for entry in evidence["encounters"]]
    assert circle == [{"a", "b"}, {"a", "c"}, {"b", "c"}]
    for entry in evidence["encounters"]:
        assert {body.partition("::")[0] for body in entry["pair"]} == set(entry["times"])


def test_what_no_delay_can_mend_is_not_certified(tmp_path: Path) -> None:
    wall = "objects: [{name: wall, shape: {box: [0.1, 0.1, 1]}, pose: {position: [0, 0, 0]}}]\n"
    world = discs(tmp_path, {"a": (-1, 0), "b": (1, 1)}, more=wall)
    with pytest.raises(NotCertified) as failure:
        _schedule(world, _motion(world, "a", (-1, 0), (1, 0)), _motion(world, "b", (1, 1), (1, 2)))
    assert failure.value.evidence["checks"][0]["name"] == "clearance"
    fast = _motion(world, "a", (-1, 0), (-1, 2), seconds=0.2)
    with pytest.raises(NotCertified) as failure:
        _schedule(world, fast, _motion(world, "b", (1, 1), (1, 2)))
    assert "velocity" in {check["name"] for check in failure.value.evidence["checks"]}


def test_the_deadline_ends_it(world: World) -> None:
    motions = [_motion(world, "a", (-1, 0), (1, 0)), _motion(world, "b", (0, -1), (0, 1))]
    with pytest.raises(DeadlineExceeded) as failure:
        planning.schedule_motions(world, motions, deadline=after_looks(3))
    assert failure.value.stage == "schedule"


def test_groups_with_a_common_joint_are_refused(world: World) -> None:
    a = _motion(world, "a", (-1, 0), (1, 0))
    with pytest.raises(ProblemInvalid) as refusal:
        _schedule(world, a, a)
    assert refusal.value.evidence["joint"] == "a::x"
