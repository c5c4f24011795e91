"""Roadmaps under path constraints: they satisfy them; other constraints have other roadmaps."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import ConfigurationGoal, JointGoal
from planning.domain.request.constraint import (
    DistanceBand,
    KeepIn,
    KeepOut,
    LockedJoints,
    OrientationCone,
    PathPredicate,
    PlacedBox,
    PositionBand,
    TightLimits,
)
from planning.domain.request.options import RefineOptions, RoadmapOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.errors import NoPathFound, ProblemInvalid
from planning.roadmaps.roadmap_cache import RoadmapCache
from planning.roadmaps.roadmap_context import RoadmapContext
from planning.world.constraints.path_constraints import PathConstraints
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.pipeline.test_constraints import DOWN, TOOL, beside_the_pillar, hand_at, pillar
from tests.profiles import num_cases

FRAME, JOINT = "body::body", "body::base_joint"
EVERYWHERE = np.array([0.9, 0.9, 4.0])
FEW = RoadmapOptions(states=600, neighbours=8)
FEWER = RoadmapOptions(states=250, neighbours=8)


def boxed(*size, at=(0.0, 0.0, 0.0), reference="world"):
    return PlacedBox(np.array(size), Pose.from_parts(list(at)), reference)


# What the L keeps in the maze, and by how much some configurations do not, by hand: its origin is
# (x, y).
RULES = {
    "limits": (TightLimits({f"{JOINT}.x": (-0.45, 0.45)}), lambda qs: np.abs(qs[:, 0]) - 0.45),
    "keep in": (
        KeepIn(FRAME, boxed(0.9, 0.94, 4.0)),
        lambda qs: np.maximum(np.abs(qs[:, 0]) - 0.45, np.abs(qs[:, 1]) - 0.47),
    ),
    "keep out": (
        KeepOut(FRAME, boxed(0.1, 0.1, 4.0, at=(0.4, 0.4, 0.0))),
        lambda qs: 0.05 - np.abs(qs[:, :2] - 0.4).max(axis=1),
    ),
}


def problem_of(*constraints, seed=0, **options):
    search = {"allowed_planning_time": 30.0, "roadmap": FEW, **options}
    return PlanningProblem(
        "body",
        ConfigurationGoal("exit"),
        search=SearchOptions(**search),
        refine=RefineOptions("none"),
        constraints=constraints,
        seed=seed,
    )


def solve(world, problem, roadmaps=None):
    deadline = no_hurry(60.0)
    return planning.plan(problem, world, deadline=deadline, roadmaps=roadmaps)


def built(world, problem):
    deadline = no_hurry(60.0)
    return planning.build_roadmap(problem, world, deadline=deadline)


@cache
def maze():
    return bundled_world("maze_2d")


@pytest.mark.parametrize("name", RULES)
def test_every_way_of_a_roadmap_keeps_the_rules(name):
    constraint, excess = RULES[name]
    roadmap = built(maze(), problem_of(constraint, roadmap=FEWER))
    assert len(roadmap.edges) > 100
    for i, j in roadmap.edges[::5]:
        steps = np.linspace(0.0, 1.0, 100)[:, None]
        between = roadmap.states[i] + steps * (roadmap.states[j] - roadmap.states[i])
        assert excess(between).max() <= 1e-6
    # The rules leave something out: else they would prove nothing.
    assert built(maze(), problem_of(roadmap=FEWER)).digest != roadmap.digest


@pytest.mark.parametrize("name", RULES)
def test_cold_and_warm_give_the_same_bytes_and_a_motion_that_keeps_the_rules(name, tmp_path):
    constraint, excess = RULES[name]
    shelf = RoadmapCache(folder=tmp_path)
    problem = problem_of(constraint, seed=3)
    cold, warm = solve(maze(), problem, shelf), solve(maze(), problem, shelf)
    disk = solve(maze(), problem, RoadmapCache(folder=tmp_path))
    assert [("roadmap_build" in f.timings) for f in (cold, warm, disk)] == [True, False, False]
    assert len({found.digest for found in (cold, warm, disk)}) == 1
    assert cold.stages.search == warm.stages.search == disk.stages.search
    assert cold.certificate.proven
    assert cold.stages.search.roadmap.used
    times = np.linspace(0.0, cold.trajectory.duration, 2_000)
    assert excess(cold.trajectory.positions(times)).max() <= 1e-6


def key_of(world, group, constraints, start, **options):
    problem = replace(problem_of(*constraints, **options), group=group)
    joints = world.group(group)
    rules = (
        PathConstraints.compiled(world, joints, tuple(constraints), start) if constraints else None
    )
    return RoadmapContext.from_problem(problem, world, start, rules).key


def panda_variants():
    """Rules of which no two are the same."""
    cone = OrientationCone(TOOL, np.array([0.0, 0.0, 1.0]), DOWN, 0.3)
    lever = "panda::panda_link7"
    return [
        [],
        [cone],
        [replace(cone, tolerance=0.30001)],
        [replace(cone, direction=np.array([0.0, 1e-3, -1.0]))],
        [replace(cone, axis=np.array([0.0, 1e-3, 1.0]))],
        [replace(cone, frame=lever)],
        [cone, cone],
        [KeepIn(TOOL, boxed(1.0, 1.0, 1.0))],
        [KeepIn(lever, boxed(1.0, 1.0, 1.0))],
        [KeepOut(TOOL, boxed(1.0, 1.0, 1.0))],
        [KeepIn(TOOL, boxed(1.0, 1.0, 1.00001))],
        [KeepIn(TOOL, boxed(1.0, 1.0, 1.0, at=(0.0, 0.0, 1e-5)))],
        [KeepIn(TOOL, boxed(1.0, 1.0, 1.0, reference=lever))],
        [PositionBand(TOOL, boxed(np.inf, np.inf, 0.02))],
        [DistanceBand(None, ("pillar",), 0.01, 0.5)],
        [DistanceBand(None, ("pillar",), 0.01, np.inf)],
        [DistanceBand(("panda::panda_hand",), ("pillar",), 0.01, 0.5)],
        [LockedJoints(("panda::panda_joint1",))],
        [LockedJoints(("panda::panda_joint2",))],
        [TightLimits({"panda::panda_joint1": (-1.0, 1.0)})],
        [TightLimits({"panda::panda_joint1": (-1.0, 1.1)})],
        [TightLimits({"panda::panda_joint2": (-1.0, 1.0)})],
    ]


def test_rules_that_differ_never_share_a_roadmap():
    keys = [key_of(pillar(), "panda", rules, beside_the_pillar()) for rules in panda_variants()]
    assert len(set(keys)) == len(keys)


@settings(max_examples=num_cases(6))
@given(st.sampled_from(panda_variants()), st.integers(0, 6), st.floats(0.01, 0.3))
def test_of_the_start_only_what_rules_take_from_it_counts(rules, joint, shift):
    start = beside_the_pillar()
    moved = start.copy()
    moved[joint] += shift
    # A box that a link carries is where all joints before that link put it.
    takes_all = any(isinstance(rule, KeepIn) and rule.box.reference != "world" for rule in rules)
    locked = {name for r in rules if isinstance(r, LockedJoints) for name in r.joints}
    counts = f"panda::panda_joint{joint + 1}" in locked or takes_all
    keys = {key_of(pillar(), "panda", rules, q) for q in (start, moved)}
    assert len(keys) == 1 + counts
    assert key_of(pillar(), "panda", rules, start, seed=5, attempts=3) in keys


def test_a_thin_set_is_kept_from_end_to_end():
    cone = OrientationCone(TOOL, np.array([0.0, 0.0, 1.0]), DOWN, 0.3)
    problem = PlanningProblem(
        "panda",
        hand_at(0.45, 0.35, 0.4),
        start=beside_the_pillar(),
        constraints=(cone,),
        search=SearchOptions(allowed_planning_time=60.0, roadmap=RoadmapOptions(20, 6)),
        refine=RefineOptions("none"),
    )
    shelf = RoadmapCache()
    found, again = solve(pillar(), problem, shelf), solve(pillar(), problem, shelf)
    assert found.digest == again.digest
    assert found.stages.search.roadmap.used, found.stages.search.roadmap.reason
    assert "roadmap_build" not in again.timings
    times = np.linspace(0.0, found.trajectory.duration, 1_000)
    world = pillar()
    full = world.embed(world.group("panda"), found.trajectory.positions(times))
    placed = world.frame_poses(TOOL, full)
    assert np.arccos(np.clip(-placed[:, 2, 2], -1.0, 1.0)).max() <= 0.3 + 1e-6


def test_locked_joints_are_no_part_of_a_roadmap_and_do_not_move():
    lock = LockedJoints(("panda::panda_joint1", "panda::panda_joint5"))
    start = beside_the_pillar()
    goal = start.copy()
    goal[[1, 3, 6]] += [-0.3, 0.25, 0.5]
    problem = PlanningProblem(
        "panda",
        JointGoal(goal[None]),
        start=start,
        constraints=(lock,),
        search=SearchOptions(allowed_planning_time=30.0, roadmap=RoadmapOptions(60, 6)),
        refine=RefineOptions("none"),
    )
    roadmap = built(pillar(), problem)
    assert roadmap.states.shape[1] == len(start) - 2
    found = solve(pillar(), problem, RoadmapCache([roadmap]))
    assert "roadmap_build" not in found.timings
    assert np.ptp(found.trajectory.positions(np.linspace(0, 1, 99))[:, [0, 4]], axis=0).max() == 0
    elsewhere = built(pillar(), replace(problem, start=goal + np.array([0.1] + [0.0] * 6)))
    assert elsewhere.key != roadmap.key
    assert built(pillar(), replace(problem, start=goal)) == roadmap


def test_what_cannot_be_known_or_cannot_move_is_refused():
    predicate = PathPredicate(lambda _: True, 0.1, "mine")
    for ask in (solve, built):
        with pytest.raises(ProblemInvalid, match="constraint 0: predicate") as caught:
            ask(maze(), problem_of(predicate))
        assert caught.value.evidence["field"] == "search.roadmap"
    with pytest.raises(NoPathFound):
        built(maze(), problem_of(LockedJoints((JOINT,))))
