"""The kernel's RRTConnect is OMPL's: the same trees, edges and path from the same seed."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planning.domain.request.options import SearchOptions
from planning.errors import DeadlineExceeded
from planning.kernel.native import native
from planning.search.edges import EdgeChecker
from planning.search.ompl import run_planner as module
from planning.search.ompl.native_trees import native_trees
from planning.search.ompl.run_planner import Attempt, run_planner
from planning.search.query import Query, make_query
from planning.search.request import SearchTask
from planning.search.verified_path import coarse_checker, fine_checker
from planning.world.documents.scene_file import parse_scene
from planning.world.loading.load_world import load_world
from planning.world.world import World
from tests.clocks import after_looks, no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases, rng_of

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel is not built")

# Groups of 6, 7 and more joints; the groups of two robots move together.
SCENES = ("ur5e_pickup", "panda_shelf", "two_arms")
RESOLUTION = 0.1

type Both = Callable[[Query, int], list[tuple[Attempt, int, int]]]


# A ball on slides, and one of its slides.
SLIDES = """<robot name="slides"><link name="link0"/>{slides}</robot>"""
SLIDE = """<link name="link{i}"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>{ball}</link>
<joint name="joint{i}" type="prismatic"><parent link="link{before}"/><child link="link{i}"/>
<axis xyz="{axis}"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>"""
BALL = '<collision><geometry><sphere radius="0.05"/></geometry></collision>'
AXES = ("1 0 0", "0 1 0", "0 0 1")
WALLS = (([0.2, 1.2, 9.0], [0.0, -0.4, 0.0]), ([0.8, 0.1, 0.6], [0.6, 0.3, 0.1]))


def slides(folder: Path, count: int) -> World:
    """Return a ball on some slides, one on another, among walls."""
    links = [
        SLIDE.format(i=i, before=i - 1, axis=AXES[i % 3], ball=BALL if i == count else "")
        for i in range(1, count + 1)
    ]
    file = folder / "slides.urdf"
    file.write_text(SLIDES.format(slides="".join(links)))
    objects = [
        {"name": f"wall{i}", "shape": {"box": size}, "pose": {"position": centre}}
        for i, (size, centre) in enumerate(WALLS)
    ]
    robots = [{"name": "slides", "model": str(file)}]
    return load_world(parse_scene({"robots": robots, "objects": objects}))


def query_of(scene: str | World, seed: int, num_goals: int, **changes: Any) -> Query:
    """Return a search between random free configurations."""
    world = bundled_world(scene) if isinstance(scene, str) else scene
    group = world.group("left+right") if scene == "two_arms" else world.groups[0]
    limits, oracle = world.limits(group), world.collision_oracle(group, world.margins())
    rng, free = rng_of(seed), list[np.ndarray]()
    while len(free) <= num_goals:
        q = rng.uniform(limits.lower, limits.upper)
        free += [q] if oracle.is_free(q) else []
    options = SearchOptions(**changes)
    task = SearchTask(free[0], np.array(free[1:]), options, RESOLUTION, 0.0, seed)
    return make_query(group, limits, oracle, task, no_hurry(), None)[0]


def attempt(query: Query, seed: int) -> tuple[Attempt, int, int]:
    """Return what the planner finds, and its edges and states."""
    edges: EdgeChecker = coarse_checker(query, RESOLUTION)
    before = query.oracle.num_states
    found = run_planner(query, edges, fine_checker(query, RESOLUTION), seed)
    return found, edges.num_motions, query.oracle.num_states - before


@pytest.fixture
def both(monkeypatch: pytest.MonkeyPatch) -> Both:
    """Run an attempt by the kernel, then by OMPL."""

    def run(query: Query, seed: int) -> list[tuple[Attempt, int, int]]:
        assert native_trees(query, coarse_checker(query, RESOLUTION), seed) is not None
        ours = attempt(query, seed)
        with monkeypatch.context() as patch:
            patch.setattr(module, "native_trees", lambda *_: None)
            return [ours, attempt(query, seed)]

    return run


@pytest.mark.campaign
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("num_goals", [1, 12])
def test_the_path_is_the_one_of_ompl(both: Both, scene: str, num_goals: int) -> None:
    for seed in range(num_cases(3)):
        query = query_of(scene, seed, num_goals)
        (ours, *counts), (theirs, *their_counts) = both(
            replace(query, max_checked_states=20_000), seed + 1
        )
        assert counts == their_counts
        assert ours.status == theirs.status
        assert ours.goal_row == theirs.goal_row
        assert ours.has_given_up == theirs.has_given_up
        assert ours.failure_evidence == theirs.failure_evidence
        assert ours.waypoints.tobytes() == theirs.waypoints.tobytes()


@pytest.mark.campaign
@pytest.mark.parametrize("num_joints", range(1, 6))
def test_the_path_is_the_one_of_ompl_in_few_dimensions(
    both: Both, tmp_path: Path, num_joints: int
) -> None:
    """OMPL uses more random numbers for a space of more than two."""
    world = slides(tmp_path, num_joints)
    for seed in range(num_cases(4)):
        query = replace(query_of(world, seed, 1 + seed), max_checked_states=2_000)
        (ours, *counts), (theirs, *their_counts) = both(query, seed + 1)
        assert counts == their_counts
        assert ours.failure_evidence == theirs.failure_evidence
        assert ours.waypoints.tobytes() == theirs.waypoints.tobytes()


@pytest.mark.parametrize("max_step", [0, 0.3, "0.8"])
def test_a_range_of_ones_own_is_kept(both: Both, max_step: float | str) -> None:
    query = query_of("panda_shelf", 3, 2, parameters={"range": max_step})
    (ours, *counts), (theirs, *their_counts) = both(query, 4)
    assert counts == their_counts
    assert ours.waypoints.tobytes() == theirs.waypoints.tobytes()


@pytest.mark.parametrize("most", [1, 40, 3_000])
def test_a_budget_ends_both_with_the_same_trees(both: Both, most: int) -> None:
    """More vertices than one bucket of the nearest neighbours has; goals that join one by one."""
    query = replace(query_of("panda_shelf", 5, 12), max_checked_states=most)
    query = replace(query, goals=query.goals[:, ::-1].copy())
    (ours, *counts), (theirs, *their_counts) = both(query, 3)
    assert counts == their_counts
    assert ours.failure_evidence == theirs.failure_evidence
    assert ours.status == theirs.status


def test_a_deadline_ends_the_trees_and_their_size_is_told() -> None:
    query = query_of("two_arms", 1, 1)
    late = after_looks(3)
    slow = replace(query, deadline=late, max_checked_states=np.inf)
    slow = replace(slow, goals=slow.goals * 0 + 1e3)
    with pytest.raises(DeadlineExceeded) as caught:
        attempt(slow, 1)
    assert caught.value.evidence["num_vertices"] >= 2


def test_a_deadline_ends_samples_that_need_no_edge() -> None:
    """Steps so short that rounding makes them none."""
    query = query_of("panda_shelf", 1, 1, parameters={"range": 1e-300})
    with pytest.raises(DeadlineExceeded):
        attempt(replace(query, deadline=after_looks(5)), 1)


@pytest.mark.parametrize(
    "changes",
    [
        {"planner": "RRT"},
        {"parameters": {"intermediate_states": True}},
        {"keep_graph": True},
        {"approximate": True},
        {"setup_time": 1.0},
    ],
)
def test_what_the_kernel_does_not_have_is_left_to_ompl(changes: dict[str, Any]) -> None:
    query = query_of("panda_shelf", 0, 1, **changes)
    assert native_trees(query, coarse_checker(query, RESOLUTION), 1) is None
