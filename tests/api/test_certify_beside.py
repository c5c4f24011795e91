"""A motion beside others at any times: analytic cases of discs, what is attached, and faults."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning import TimedTrajectory
from planning.certify.beside import drake_beside
from planning.domain.report.beside_report import BesideOutcome, BesideReport
from planning.errors import Canceled, DeadlineExceeded, ProblemInvalid, UnknownName
from planning.world.world import World
from tests.certify.oracles import without_kernel
from tests.clocks import after_looks, no_hurry
from tests.discs import RADIUS, discs, straight
from tests.profiles import num_cases

type Way = tuple[tuple[float, float], ...]
ACROSS: Way = ((-1, 0), (1, 0))


@pytest.fixture(scope="module")
def crossing(tmp_path_factory: pytest.TempPathFactory) -> World:
    """Two discs whose straight ways may cross at the origin, and a third one."""
    folder = tmp_path_factory.mktemp("discs")
    return discs(folder, {"a": (-1, 0), "b": (0, -1), "c": (2, 2)})


def beside(world: World, a: Way, b: Way, margin: float | None = None) -> BesideReport:
    motion, other = ("a", straight(world, "a", *a)), ("b", straight(world, "b", *b))
    return planning.certify_beside(world, motion, [other], deadline=no_hurry(), margin=margin)


def test_motions_that_a_delay_would_part_are_refused(crossing: World) -> None:
    """Their combined motion is proven with a delay; started one by one they have none."""
    report = beside(crossing, ACROSS, ((0, -1), (0, 1)))
    check = report.failed
    assert check is not None
    assert (report.proven, check.outcome) == (False, BesideOutcome.VIOLATED)
    assert check.pair == ("a::disc", "b::disc")
    a = straight(crossing, "a", *ACROSS).positions(np.array([check.time]))[0]
    b = straight(crossing, "b", (0, -1), (0, 1)).positions(np.array([check.other_time]))[0]
    assert np.linalg.norm(a - b) - 2 * RADIUS == pytest.approx(check.distance, abs=1e-6)
    assert check.distance < 0


@given(height=st.floats(-0.5, -0.01), margin=st.floats(0.0, 0.2))
@settings(max_examples=num_cases(20))
def test_it_is_proven_if_and_only_if_the_ways_are_apart(
    crossing: World, height: float, margin: float
) -> None:
    """Disc b comes up to a height below the way of disc a: their distance is known."""
    reserve = -height - 2 * RADIUS - margin
    outcome = beside(crossing, ACROSS, ((0, -1), (0, height)), margin).checks[0].outcome
    if abs(reserve) > 1e-5:
        expected = BesideOutcome.PROVEN if reserve > 0 else BesideOutcome.VIOLATED
        assert outcome is expected


@given(way=st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=2, max_size=4))
@settings(max_examples=num_cases(10))
def test_both_orders_agree(crossing: World, way: list[tuple[float, float]]) -> None:
    motion = "a", straight(crossing, "a", *ACROSS)
    other = "b", straight(crossing, "b", *way)
    (ours,) = planning.certify_beside(crossing, motion, [other], deadline=no_hurry()).checks
    (theirs,) = planning.certify_beside(crossing, other, [motion], deadline=no_hurry()).checks
    swapped = replace(
        theirs,
        group="b",
        pair=theirs.pair[::-1],
        time=theirs.other_time,
        other_time=theirs.time,
    )
    assert ours == swapped
    again = planning.certify_beside(crossing, motion, [other], deadline=no_hurry())
    assert again.checks == (ours,)


def test_a_robot_at_rest_is_a_motion_without_duration(crossing: World) -> None:
    motion = "a", straight(crossing, "a", *ACROSS)
    joints = crossing.group("b").joints
    for height, is_proven in ((-0.21, True), (-0.19, False)):
        rest = TimedTrajectory.at_rest(joints, np.array([0.0, height]))
        report = planning.certify_beside(crossing, motion, [("b", rest)], deadline=no_hurry())
        assert report.proven is is_proven


def test_what_is_behind_counts_no_more(crossing: World) -> None:
    """Of a motion that has passed the crossing, what is left is beside the other one."""
    a, b = straight(crossing, "a", *ACROSS), straight(crossing, "b", (0, -1), (0, 1))
    for time, is_proven in ((0.9, False), (1.3, True)):
        report = planning.certify_beside(
            crossing, ("a", a.after(time)), [("b", b)], deadline=no_hurry()
        )
        assert report.proven is is_proven


def test_checks_are_in_the_order_given_and_end_at_the_first_failure(crossing: World) -> None:
    motion = "a", straight(crossing, "a", *ACROSS)
    near = "b", straight(crossing, "b", (0, -1), (0, 1))
    far = "c", straight(crossing, "c", (2, 2), (2, 1))
    for others, groups in (([near, far], ["b"]), ([far, near], ["c", "b"]), ([far], ["c"])):
        report = planning.certify_beside(crossing, motion, others, deadline=no_hurry())
        assert [check.group for check in report.checks] == groups
        assert report.proven is (near not in others)
    assert planning.certify_beside(crossing, motion, [], deadline=no_hurry()).proven
    queue = [("c", straight(crossing, "c", (2, 1), (2, 2))), far]
    assert planning.certify_beside(crossing, motion, queue, deadline=no_hurry()).proven


def test_what_is_attached_moves_with_its_robot(tmp_path: Path) -> None:
    """A rod in front of disc b reaches into the way of disc a, which b alone does not."""
    rod = """objects:
  - {name: rod, shape: {box: [0.04, 1.2, 0.04]}, pose: {position: [0, 0.7, 0]}, movable: true,
     attached: {frame: "b::disc"}}
"""
    for more, is_proven in (("", True), (rod, False)):
        world = discs(tmp_path, {"a": (-1, 0), "b": (0, -2)}, more=more)
        report = beside(world, ACROSS, ((0, -2), (0, -1)))
        assert report.proven is is_proven
        if report.failed is not None:
            assert report.failed.pair == ("a::disc", "rod")


def test_pairs_have_their_own_margins_or_are_allowed(tmp_path: Path) -> None:
    """The ways are 0.1 m apart."""
    ways: tuple[Way, Way] = (ACROSS, ((0, -1), (0, -0.3)))
    exception = 'margins: [{bodies: ["a::disc", "b::disc"], margin: %s}]\n'
    allowed = 'allowed_collisions: [["a::disc", "b::disc"]]\n'
    for margin, more, is_proven in (
        (0.05, "", True),
        (0.15, "", False),
        (0.15, exception % 0.05, True),
        (0.05, exception % 0.15, False),
        (0.15, allowed, True),
    ):
        world = discs(tmp_path, {"a": (-1, 0), "b": (0, -1)}, margin, more)
        assert beside(world, *ways).proven is is_proven


def test_faults_are_named(crossing: World) -> None:
    a, b = straight(crossing, "a", *ACROSS), straight(crossing, "b", (0, -1), (0, 1))
    with pytest.raises(UnknownName):
        planning.certify_beside(crossing, ("a", a), [("d", b)], deadline=no_hurry())
    with pytest.raises(ProblemInvalid, match=r"others\.1"):
        planning.certify_beside(crossing, ("a", a), [("b", b), ("c", b)], deadline=no_hurry())
    broken = replace(b, coefficients=b.coefficients * np.nan)
    with pytest.raises(ProblemInvalid, match=r"others\.0.*finite"):
        planning.certify_beside(crossing, ("a", a), [("b", broken)], deadline=no_hurry())
    with pytest.raises(ProblemInvalid, match=r"moves body 'a::disc'") as twice:
        planning.certify_beside(crossing, ("a", a), [("b", b), ("a", a)], deadline=no_hurry())
    assert twice.value.evidence["field"] == "others.1"


def test_nothing_is_proven_once_the_time_is_over(crossing: World) -> None:
    motions = (
        ("a", straight(crossing, "a", *ACROSS)),
        ("b", straight(crossing, "b", (0, -1), (0, 1))),
    )
    with pytest.raises(DeadlineExceeded):
        planning.certify_beside(
            crossing, motions[0], [motions[1]], deadline=after_looks(1, seconds=0.0)
        )
    deadline = no_hurry(is_canceled=lambda: True)
    with pytest.raises(Canceled):
        planning.certify_beside(crossing, motions[0], [motions[1]], deadline=deadline)


def test_what_the_bounds_do_not_decide_is_refused_and_says_so(
    crossing: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Motions that are apart, and a proof that ends after a few segments."""
    monkeypatch.setattr(crossing, "drake", without_kernel(crossing.drake))
    assert beside(crossing, ACROSS, ((0, -1), (0, -0.21))).proven
    monkeypatch.setattr(drake_beside, "_MAX_NODES", 3)
    report = beside(crossing, ACROSS, ((0, -1), (0, -0.21)))
    assert report.failed is not None
    assert report.failed.outcome is BesideOutcome.UNDECIDED
    assert report.failed.pair == ("a::disc", "b::disc")
