"""Proofs whatever the timing: never proven where two instants of the motions violate a margin."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform

from planning.certify.beside import drake_beside
from planning.certify.beside.beside_check import check_beside
from planning.certify.beside.beside_request import BesideRequest, BesideResult, moved_bodies
from planning.certify.beside.drake_beside import DrakeBeside
from planning.certify.clearance.pair_distances import PairDistances
from planning.certify.intervals.joint_deviation import Segment
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup, JointType
from planning.kernel.native import native
from planning.world.collision.margins import PairMargins
from planning.world.drake_model import DrakeModel
from tests.certify.chains import (
    FLOATING,
    KINDS,
    Builder,
    P,
    R,
    Robot,
    random_pose,
    random_shape,
    random_trajectory,
)
from tests.certify.conftest import quintic
from tests.certify.oracles import for_oracle, without_kernel
from tests.clocks import no_hurry
from tests.profiles import num_cases, rng_of

# Spheres of the arms: their radius, and their places along each link [m].
RADIUS, LENGTH, PLACES = 0.06, 0.4, (0.2, 0.4)
# Names of their bodies, in the order of `centers`.
SPHERES = [
    [f"robot::{kind}{link}" for link in links for kind in ("link", "end")]
    for links in ((0, 1), (2, 3))
]
# Distance of the arms' first axes [m].
APART = 1.0


def arms() -> Robot:
    """Return two planar arms of two links each, covered with spheres."""
    builder = Builder()
    for x in (0.0, APART):
        parent, at = None, RigidTransform(np.array([x, 0.0, 0.0]))
        for _ in range(2):
            ball = RigidTransform(np.array([PLACES[0], 0.0, 0.0]))
            number = builder.link(R, Sphere(RADIUS), parent, at, x_bg=ball)
            end = builder.body(f"robot::end{number}", Sphere(RADIUS))
            link = builder.links[number]
            x_le = RigidTransform(np.array([PLACES[1], 0.0, 0.0]))
            builder.plant.WeldFrames(link.body_frame(), end.body_frame(), x_le)
            parent, at = number, RigidTransform(np.array([LENGTH, 0.0, 0.0]))
    return builder.build()


def centers(q: np.ndarray, base: float) -> np.ndarray:
    """Return the centres of an arm's spheres, shape (n, 4, 2), by trigonometry alone."""
    a, b = q[:, 0], q[:, 0] + q[:, 1]
    first, second = np.stack([np.cos(a), np.sin(a)], 1), np.stack([np.cos(b), np.sin(b)], 1)
    origin = np.array([base, 0.0])
    return np.stack(
        [
            *(origin + place * first for place in PLACES),
            *(origin + LENGTH * first + place * second for place in PLACES),
        ],
        axis=1,
    )


def distances(request: BesideRequest, t: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return the distances of spheres at every t and every s, shape (len(t), len(s), 4, 4)."""
    first, second = request.trajectories
    a, b = centers(first.positions(t), 0.0), centers(second.positions(s), APART)
    away = a[:, None, :, None] - b[None, :, None, :]
    return np.linalg.norm(away, axis=-1) - 2 * RADIUS


def halves_of(robot: Robot, count: int) -> tuple[JointGroup, JointGroup]:
    """Return two groups: the first `count` joints, and the others."""
    joints = robot.group.joints
    return JointGroup("first", joints[:count], ()), JointGroup("second", joints[count:], ())


def random_arm_request(robot: Robot, rng: np.random.Generator) -> BesideRequest:
    groups = halves_of(robot, 2)
    trajectories = tuple(
        random_trajectory(rng, group, int(rng.integers(1, 4)), 0.8) for group in groups
    )
    turned = replace(
        trajectories[1], bases=trajectories[1].bases + np.array([rng.uniform(2.0, 4.0), 0.0])
    )
    between = {pair: rng.uniform(0.0, 0.1) for pair in _pairs_between(robot, groups)}
    margins = PairMargins(0.0, dict.fromkeys(between, min(between.values())))
    return BesideRequest(groups, (trajectories[0], turned), robot.state, margins)


def _pairs_between(
    robot: Robot, groups: tuple[JointGroup, JointGroup]
) -> Iterator[tuple[str, str]]:
    first, second = (moved_bodies(robot.model, group) for group in groups)
    for a in sorted(first):
        for b in sorted(second):
            yield min(a, b), max(a, b)


def is_contradicted(request: BesideRequest, result: BesideResult) -> bool:
    """Whether the formula of the arms contradicts a result: dense samples, and its own instants."""
    margin = next(iter(request.margins.by_pair.values()))
    first, second = request.trajectories
    dense = distances(
        request, np.linspace(0, first.duration, 250), np.linspace(0, second.duration, 250)
    )
    if result.outcome == "PROVEN":
        return bool(dense.min() < margin - 2e-6)
    t, s = result.times
    i, j = (index for name in SPHERES for index, own in enumerate(name) if own in result.bodies)
    there = float(distances(request, np.array([t]), np.array([s]))[0, 0, i, j])
    if result.outcome == "TOO_NEAR":
        return there > margin + 1e-6 or abs(there - result.distance) > 1e-6
    return bool(abs(dense.min() - margin) > 1e-3)


@given(seed=st.integers(0, 100_000))
@settings(max_examples=num_cases(12))
@pytest.mark.usefixtures("implementation")
def test_verdicts_on_arms_are_those_of_dense_samples(seed: int) -> None:
    robot = arms()
    request = random_arm_request(robot, np.random.default_rng(seed))
    result = check_beside(for_oracle(robot.model), request, no_hurry())
    assert not is_contradicted(request, result)


MAX_APPROACHES = PairDistances.max_approaches


def _first_alone(self: PairDistances, segment: Segment, pairs: np.ndarray) -> np.ndarray:
    """Return approaches by the first motion; of the second, as if it did not move."""
    approaches = MAX_APPROACHES(self, segment, pairs)
    return approaches if segment.max_rotation[:2].any() else np.zeros(len(pairs))


def _frozen(request: BesideRequest) -> BesideRequest:
    """Return the request with the other robot at rest at the middle of its motion."""
    first, second = request.trajectories
    middle = second.positions(np.array([second.duration / 2]))[0]
    rest = TimedTrajectory.at_rest(request.groups[1].joints, middle)
    return replace(request, trajectories=(first, rest))


def _contradictions(check: Callable[[Robot, BesideRequest], BesideResult]) -> int:
    robot, found = arms(), 0
    for seed in range(12):
        request = random_arm_request(robot, rng_of(seed))
        found += is_contradicted(request, check(robot, request))
    return found


def test_a_proof_that_forgets_the_other_motion_is_contradicted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The samples of these tests tell a wrong proof from a right one."""

    def check(robot: Robot, request: BesideRequest) -> BesideResult:
        return DrakeBeside(without_kernel(robot.model), request, no_hurry()).run()

    assert _contradictions(check) == 0
    monkeypatch.setattr(PairDistances, "max_approaches", _first_alone)
    assert _contradictions(check) > 0


@pytest.mark.skipif(native() is None, reason="the native code is not built")
def test_another_robot_at_rest_in_the_middle_of_its_motion_is_not_enough() -> None:
    def check(robot: Robot, request: BesideRequest) -> BesideResult:
        return check_beside(robot.model, _frozen(request), no_hurry())

    assert _contradictions(check) > 0


def random_trees(rng: np.random.Generator) -> tuple[Robot, int]:
    """Return two trees of random joints, and the number of joints of the first."""
    builder, count = Builder(), int(rng.integers(1, 4))
    for i in range(count + int(rng.integers(1, 4))):
        parent = None if i in (0, count) else int(rng.integers(0 if i < count else count, i))
        axis = rng.normal(size=3)
        builder.link(
            KINDS[int(rng.integers(len(KINDS)))],
            random_shape(rng, 0.1),
            parent,
            random_pose(rng, 0.25),
            axis / np.linalg.norm(axis),
            random_pose(rng, 0.1),
            random_pose(rng, 0.05),
        )
    return builder.build(), count


def random_tree_request(rng: np.random.Generator) -> tuple[Robot, BesideRequest]:
    robot, count = random_trees(rng)
    groups = halves_of(robot, count)
    first, second = (random_trajectory(rng, group, 2, 0.12) for group in groups)
    margins = {pair: rng.uniform(0.0, 0.03) for pair in _pairs_between(robot, groups)}
    return robot, BesideRequest(groups, (first, second), robot.state, PairMargins(0.0, margins))


def smallest_reserve(robot: Robot, request: BesideRequest, rng: np.random.Generator) -> float:
    """Return the smallest distance over a margin at random instants, by Drake's queries alone."""
    model, scene_graph = robot.model, robot.model.scene_graph
    context = model.diagram.CreateDefaultContext()
    plant_context = model.plant.GetMyMutableContextFromRoot(context)
    inspector: Any = scene_graph.model_inspector()
    smallest = np.inf
    first, second = request.trajectories
    for t, s in rng.uniform(0.0, 1.0, (60, 2)):
        q = [
            trajectory.positions(np.array([share * trajectory.duration]))[0]
            for trajectory, share in ((first, t), (second, s))
        ]
        full = model.embed(request.group, np.concatenate(q), request.state)
        model.plant.SetPositions(plant_context, full)
        query: Any = scene_graph.get_query_output_port().Eval(
            scene_graph.GetMyContextFromRoot(context)
        )
        for found in query.ComputeSignedDistancePairwiseClosestPoints(0.1):
            a, b = (
                model.plant.GetBodyFromFrameId(inspector.GetFrameId(i)).name()
                for i in (found.id_A, found.id_B)
            )
            margin = request.margins.by_pair.get((min(a, b), max(a, b)))
            if margin is not None:
                smallest = min(smallest, found.distance - margin)
    return smallest


def at_instants(request: BesideRequest, times: tuple[float, float]) -> BesideRequest:
    """Return both groups at rest where their motions are at some instants."""
    rests = tuple(
        TimedTrajectory.at_rest(group.joints, trajectory.positions(np.array([time]))[0])
        for group, trajectory, time in zip(request.groups, request.trajectories, times, strict=True)
    )
    return replace(request, trajectories=rests)


@given(seed=st.integers(0, 100_000))
@settings(max_examples=num_cases(8))
@pytest.mark.skipif(native() is None, reason="the native code is not built")
def test_both_proofs_agree_on_random_trees_and_no_sample_contradicts(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot, request = random_tree_request(rng)
    drake = without_kernel(robot.model)
    ours, theirs = (check_beside(model, request, no_hurry()) for model in (robot.model, drake))
    outcomes = {ours.outcome, theirs.outcome}
    assert len(outcomes - {"UNPROVEN"}) <= 1
    if "PROVEN" in outcomes:
        assert smallest_reserve(robot, request, rng) >= -2e-6
    for result, judge in ((ours, drake), (theirs, robot.model)):
        if result.outcome == "TOO_NEAR":
            there = check_beside(judge, at_instants(request, result.times), no_hurry())
            assert there.outcome != "PROVEN" or there.distance - there.margin < 2e-6


def there_and_back(group: JointGroup, largest: float) -> TimedTrajectory:
    """Return a motion of one joint from 0 to a position, at an instant that no halving meets."""
    there = quintic(group, np.array([0.0]), np.array([largest]), 0.7)
    back = quintic(group, np.array([largest]), np.array([0.0]), 1.1)
    return TimedTrajectory.joined([there, back])


def meeting(
    kind: JointType, gap: float, reaches: tuple[float, float]
) -> tuple[Robot, BesideRequest]:
    """Return two balls that are nearest where both reach farthest, with a gap between them [m].

    They slide along one line, or swing on levers of 1 m about axes above each other.
    """
    builder, radius, place = Builder(), 0.05, np.array([1.0, 0.0, 0.0])
    advance = sum(reaches) if kind is P else float(np.sin(reaches).sum())
    apart = np.array([0.0, 2 * radius + gap + advance, 0.0])
    if kind is P:
        builder.link(P, Sphere(radius), axis=np.array([0.0, 1.0, 0.0]))
        builder.link(P, Sphere(radius), x_pf=RigidTransform(apart), axis=-np.array([0.0, 1.0, 0.0]))
    else:
        ball = RigidTransform(place)
        builder.link(R, Sphere(radius), x_bg=ball)
        axis = -np.array([0.0, 0.0, 1.0])
        builder.link(R, Sphere(radius), None, RigidTransform(apart), axis, x_bg=ball)
    robot = builder.build()
    groups = halves_of(robot, 1)
    motions = there_and_back(groups[0], reaches[0]), there_and_back(groups[1], reaches[1])
    return robot, BesideRequest(groups, motions, robot.state, PairMargins(0.0))


@pytest.mark.usefixtures("implementation")
@pytest.mark.parametrize(
    ("kind", "reaches"),
    [(P, (0.1, 0.1)), (P, (0.0, 0.2)), (P, (0.2, 0.0)), (P, (0.02, 0.15)), (R, (0.1, 0.1))],
)
def test_the_nearest_of_two_approaches_decides(
    kind: JointType, reaches: tuple[float, float]
) -> None:
    for gap, outcome in ((1e-4, "PROVEN"), (-1e-4, "TOO_NEAR")):
        robot, request = meeting(kind, gap, reaches)
        result = check_beside(for_oracle(robot.model), request, no_hurry())
        assert result.outcome == outcome


@pytest.mark.usefixtures("implementation")
@pytest.mark.parametrize("highest", [2, 6, 10, 14, 18, 22])
def test_every_tooth_of_a_zigzag_counts(highest: int) -> None:
    """A ball moves along a beam in zigzags, one of which comes nearer than the others."""
    builder, radius = Builder(), 0.05
    slide = builder.link(P, Sphere(0.001), axis=np.array([1.0, 0.0, 0.0]))
    builder.link(P, Sphere(radius), slide, axis=np.array([0.0, 1.0, 0.0]))
    builder.link(P, Box(2.0, 0.1, 0.1), axis=np.array([0.0, 1.0, 0.0]))
    robot = builder.build()
    groups = halves_of(robot, 2)
    heights = [0.005 if i == highest else -0.06 * (i % 2) for i in range(25)]
    corners = [np.array([0.005 * i, height]) for i, height in enumerate(heights)]
    legs = [quintic(groups[0], a, b, 0.3) for a, b in pairwise(corners)]
    for gap, outcome in ((1e-4, "PROVEN"), (-1e-4, "TOO_NEAR")):
        place = np.array([0.005 + radius + 0.05 + gap])
        rest = TimedTrajectory.at_rest(groups[1].joints, place)
        motions = TimedTrajectory.joined(legs), rest
        request = BesideRequest(groups, motions, robot.state, PairMargins(0.0))
        for order in (request, swapped(request)):
            assert check_beside(for_oracle(robot.model), order, no_hurry()).outcome == outcome


def swapped(request: BesideRequest) -> BesideRequest:
    (a, b), (x, y) = request.groups, request.trajectories
    return replace(request, groups=(b, a), trajectories=(y, x))


@pytest.mark.usefixtures("implementation")
def test_a_floating_body_that_turns_is_bounded() -> None:
    """A beam turns by half a turn in place; a ball that slides by is hit at some s alone."""
    builder = Builder()
    builder.link(FLOATING, Box(1.0, 0.05, 0.05))
    builder.link(P, Sphere(0.05), axis=np.array([0.0, 0.0, 1.0]))
    robot = builder.build()
    groups = halves_of(robot, 1)
    upright = np.array([1.0, 0, 0, 0, 0, 0, 0])
    half_turn = np.array([0.0, 0, 0, 1.0, 0, 0, 0])
    turn = quintic(groups[0], upright, half_turn, 1.0)
    for distance, lowest, outcome in (
        (0.6, -0.3, "PROVEN"),
        (0.4, 0.08, "PROVEN"),
        (0.4, 0.05, "TOO_NEAR"),
    ):
        slide = quintic(groups[1], np.array([0.5]), np.array([lowest]), 1.0)
        aside = replace(turn, bases=turn.bases + np.array([0, 0, 0, 0, distance, 0, 0]))
        request = BesideRequest(groups, (aside, slide), robot.state, PairMargins(0.0))
        result = check_beside(for_oracle(robot.model), request, no_hurry())
        assert result.outcome == outcome


def test_the_drake_proof_counts_what_its_groups_move(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the bodies that are welded to the last links, a wrong proof is contradicted."""

    def without_ends(model: DrakeModel, group: JointGroup) -> frozenset[str]:
        return frozenset(name for name in moved_bodies(model, group) if "end" not in name)

    monkeypatch.setattr(drake_beside, "moved_bodies", without_ends)

    def check(robot: Robot, request: BesideRequest) -> BesideResult:
        return DrakeBeside(without_kernel(robot.model), request, no_hurry()).run()

    assert _contradictions(check) > 0
