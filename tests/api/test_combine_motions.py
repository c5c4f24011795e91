"""Several motions at once, certified as one: analytic collisions of discs, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import planning
from planning import GroupMotion
from planning.domain.report.certificate import Certificate
from planning.errors import ProblemInvalid, UnknownName
from planning.world.world import World
from tests.clocks import no_hurry
from tests.discs import RADIUS, disc_distance, discs, straight


@pytest.fixture(scope="module")
def crossing(tmp_path_factory: pytest.TempPathFactory) -> World:
    """Two discs whose straight ways cross at the origin."""
    return discs(tmp_path_factory.mktemp("discs"), {"a": (-1, 0), "b": (0, -1)})


def _motions(world: World, delay: float) -> list[GroupMotion]:
    return [
        GroupMotion("a", straight(world, "a", (-1, 0), (1, 0))),
        GroupMotion("b", straight(world, "b", (0, -1), (0, 1)), delay),
    ]


def _certify(world: World, motions: list[GroupMotion]) -> Certificate:
    whole = planning.combine_motions(world, motions)
    certificate, _ = planning.certify_trajectory(
        world, whole.group, whole.trajectory, deadline=no_hurry()
    )
    return certificate


def test_two_discs_at_one_place_are_refused_and_a_delay_that_parts_them_is_proven(
    crossing: World,
) -> None:
    refused = _certify(crossing, _motions(crossing, 0.0))
    assert not refused.proven
    assert [check.name for check in refused.failed] == ["clearance"]
    assert set(refused.pair) == {"a::disc", "b::disc"}
    # Both are at s = -1 + 2 (3 u^2 - 2 u^3), so they touch where sqrt(2) |s| is two radii.
    u = refused.proven_until / 2.0
    s = -1 + 2 * (3 * u**2 - 2 * u**3)
    assert np.sqrt(2) * abs(s) == pytest.approx(2 * RADIUS, abs=1e-3)
    proven = _certify(crossing, _motions(crossing, 1.0))
    assert proven.proven
    motions = _motions(crossing, 1.0)
    truth = disc_distance(motions[0].trajectory, motions[1].trajectory, 1.0)
    assert proven.min_clearance <= truth <= proven.observed_clearance + 1e-6
    assert truth - proven.min_clearance < 1e-3 + 0.01 * truth  # the resolution of the proof


@given(delay=st.floats(0.0, 2.5))
def test_it_is_proven_if_and_only_if_the_discs_do_not_touch(crossing: World, delay: float) -> None:
    motions = _motions(crossing, delay)
    truth = disc_distance(motions[0].trajectory, motions[1].trajectory, delay)
    certificate = _certify(crossing, motions)
    if abs(truth) > 2e-3:
        assert certificate.proven == (truth > 0)
    if certificate.proven:
        assert certificate.min_clearance <= truth + 1e-6


def test_neither_alone_knows_of_the_other(crossing: World) -> None:
    """What the combined motion refuses, both certificates of one robot each had proven."""
    for motion in _motions(crossing, 0.0):
        certificate, _ = planning.certify_trajectory(
            crossing, motion.group, motion.trajectory, deadline=no_hurry()
        )
        assert certificate.proven


def test_the_margin_of_the_scene_is_kept_between_robots_too(tmp_path: Path) -> None:
    world = discs(tmp_path, {"a": (-1, 0), "b": (0, -1)}, margin=0.05)
    delays = np.linspace(0.15, 0.35, 9)
    found = {delay: _certify(world, _motions(world, delay)).proven for delay in delays}
    motions = _motions(world, 0.0)
    truth = {d: disc_distance(motions[0].trajectory, motions[1].trajectory, d) for d in delays}
    assert found == {delay: distance > 0.05 for delay, distance in truth.items()}
    assert any(0 < distance < 0.05 for distance in truth.values())


def test_what_is_attached_moves_with_its_robot_and_counts(tmp_path: Path) -> None:
    """A rod in front of disc b reaches into the way of disc a, which b alone does not."""
    rod = """objects:
  - {name: rod, shape: {box: [0.04, 1.2, 0.04]}, pose: {position: [0, 0.7, 0]}, movable: true,
     attached: {frame: "b::disc"}}
"""
    motions = {
        "a": ((-1.0, 0.0), (1.0, 0.0)),
        "b": ((0.0, -1.0), (0.0, -1.6)),
    }
    for more, is_proven in (("", True), (rod, False)):
        world = discs(tmp_path, {"a": (-1, 0), "b": (0, -1)}, more=more)
        both = [GroupMotion(name, straight(world, name, *way)) for name, way in motions.items()]
        certificate = _certify(world, both)
        assert certificate.proven is is_proven
        if not is_proven:
            assert set(certificate.pair) == {"rod", "a::disc"}


def test_groups_order_joints_as_the_motions_are_given(crossing: World) -> None:
    whole = planning.combine_motions(crossing, _motions(crossing, 0.5)[::-1])
    assert whole.group == "b+a"
    assert whole.trajectory.joints == crossing.group("b+a").joints
    assert whole.trajectory.duration == 2.5


def test_faults_are_named(crossing: World) -> None:
    a, b = _motions(crossing, 0.0)
    with pytest.raises(ProblemInvalid, match="at least one"):
        planning.combine_motions(crossing, [])
    with pytest.raises(ProblemInvalid, match="several of the groups") as twice:
        planning.combine_motions(crossing, [a, b, a])
    assert twice.value.evidence["joint"] == "a::x"
    with pytest.raises(ProblemInvalid, match=r"motions\.1\.begin"):
        planning.combine_motions(crossing, [a, GroupMotion("b", b.trajectory, -0.1)])
    with pytest.raises(ProblemInvalid, match=r"motions\.0\.trajectory"):
        planning.combine_motions(crossing, [GroupMotion("a", b.trajectory)])
    with pytest.raises(UnknownName) as unknown:
        planning.combine_motions(crossing, [a, GroupMotion("c", b.trajectory)])
    assert unknown.value.evidence["name"] == "c"
