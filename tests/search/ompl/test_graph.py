"""Exported graphs are those that planners explored; approximate solutions are no solutions."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import DeadlineExceeded, NoPathFound
from planning.search.ompl.graph import Graph, export_graph
from planning.search.ompl.planner_list import planner_names
from planning.search.ompl.spaces import SearchSpace
from planning.search.solver import search
from tests.clocks import after_looks
from tests.search.conftest import each_kind_of_planner
from tests.search.test_solver import fine_samples

SILENT = {"AORRTC", "BITstar"}
TELLING = [name for name in planner_names() if name not in SILENT]


@pytest.mark.parametrize("name", TELLING)
def test_a_graph_leads_from_start_to_goal(plane, wall, soon, crossing, name):
    few = {"num_samples": 200} if name in {"FMT", "BFMT"} else {}
    task = crossing(1, planner=name, parameters=few, keep_graph=True)
    found = search(*plane, wall, task, soon)
    kept = found.graph
    assert kept.planner == name
    vertices, edges = kept.vertices, set(kept.edges)
    assert len(vertices) <= kept.num_vertices
    assert all(0 <= i < j < len(vertices) for i, j in edges)
    assert vertices[kept.starts[0]].tolist() == pytest.approx(task.start.tolist())
    if name != "LBKPIECE1":  # it checks late, and keeps what it never looked at
        assert wall.are_free(vertices).all()
    assert kept.path[0] in kept.starts
    assert kept.path[-1] in kept.goals
    plain = kept.as_json
    assert plain["vertices"] == vertices.tolist()
    assert [tuple(edge) for edge in plain["edges"]] == list(kept.edges)


@pytest.mark.parametrize("name", ["RRT", "PRM", "KPIECE1"])
def test_the_path_follows_edges(plane, wall, soon, crossing, name):
    kept = search(*plane, wall, crossing(1, planner=name, keep_graph=True), soon).graph
    assert len(kept.path) > 2
    steps = zip(kept.path[:-1], kept.path[1:], strict=True)
    assert {(min(step), max(step)) for step in steps} <= set(kept.edges)


def test_a_large_graph_is_cut_but_not_its_path(plane):
    """To 2,000 vertices and 10,000 edges; here each of 3,000 leads on to the next six."""
    qs = np.random.default_rng(0).uniform(-1, 1, (3_000, 2))
    way = [*range(0, 3_000, 60), 2_999]
    graph = Graph(qs, [0], [2_999], lambda i: list(range(i + 1, min(i + 7, 3_000))))
    cut = export_graph("PRM", graph, SearchSpace(*plane, qs[:1]), qs[way])
    assert (len(cut.vertices), len(cut.edges)) == (2_000, 10_000)
    assert (cut.num_vertices, cut.num_edges) == (3_000, 6 * 3_000 - 21)
    assert cut.vertices[list(cut.path)].tolist() == qs[way].tolist()
    assert cut.vertices[[*cut.starts, *cut.goals]].tolist() == qs[[0, -1]].tolist()
    for i, j in cut.edges[::97]:
        rows = [np.flatnonzero((qs == cut.vertices[k]).all(axis=1))[0] for k in (i, j)]
        assert 0 < rows[1] - rows[0] <= 6


@pytest.mark.parametrize("name", ["RRTConnect", "PRM", "FMT"])
def test_a_graph_that_is_not_wanted_is_not_kept(plane, wall, soon, crossing, name):
    few = {"num_samples": 200} if name == "FMT" else {}
    assert search(*plane, wall, crossing(1, planner=name, parameters=few), soon).graph is None


def test_a_straight_line_is_a_graph_of_two(plane, make_oracle, soon, crossing):
    empty = make_oracle(lambda qs: np.ones(len(qs), dtype=bool))
    found = search(*plane, empty, crossing(keep_graph=True), soon)
    assert found.report.direct
    assert found.graph.edges == ((0, 1),)
    assert found.graph.vertices.tolist() == found.path.waypoints.tolist()


# One that ends by itself, and one that keeps to itself how far it came.
@partial(each_kind_of_planner, among=("RRTConnect", "PRM", "BFMT", "BITstar"))
def test_the_nearest_that_was_reached_can_be_reached(plane, closed, crossing, name):
    parameters = {"num_samples": 60} if name == "BFMT" else {}
    options = {"planner": name, "parameters": parameters}
    task = crossing(**options, approximate=True, keep_graph=True)
    # Only BFMT ends by itself.
    with pytest.raises(NoPathFound if name == "BFMT" else DeadlineExceeded) as caught:
        search(*plane, closed, task, after_looks(2_000, seconds=60.0))
    near = caught.value.evidence["approximate"]
    if name in SILENT:
        assert near is None
        return
    assert len(caught.value.evidence["graph"]["vertices"]) > 1
    path = np.array(near["path"])
    assert path[0].tolist() == pytest.approx(task.start.tolist())
    assert path[-1].tolist() == near["positions"]
    for qs in fine_samples(plane[0], path, task.resolution / 4):
        assert closed.are_free(qs).all()
    goal = np.array(near["goal"])
    assert goal.tolist() in task.goals.tolist()
    assert near["goal_distance"] == pytest.approx(np.linalg.norm(goal - path[-1]))
    distances = np.linalg.norm(task.goals - task.start, axis=1)
    assert near["goal_distance"] <= distances.min()
    assert path[-1][0] < -0.1


def test_the_nearest_of_all_attempts_is_told(plane, closed, soon, crossing):
    options = {"planner": "BFMT", "parameters": {"num_samples": 60}, "approximate": True}
    reached = []
    for attempts in (1, 4):
        with pytest.raises(NoPathFound) as caught:
            search(*plane, closed, crossing(attempts=attempts, **options), soon)
        reached.append(caught.value.evidence["approximate"]["goal_distance"])
    assert reached[1] <= reached[0]


def test_graphs_of_bodies_hold_configurations(make_group, make_limits, make_oracle, soon, crossing):
    group = make_group(JointType.FLOATING)
    oracle = make_oracle(lambda qs: ~((np.abs(qs[:, 4]) < 0.1) & (qs[:, 5] < 0.2)), group)
    ends = np.array([[1, 0, 0, 0, -0.4, 0, 0], [0.8, 0.6, 0, 0, 0.4, 0, 0]])
    task = replace(crossing(keep_graph=True, resolution=0.2), start=ends[0], goals=ends[1:])
    kept = search(group, make_limits(group), oracle, task, soon).graph
    assert np.abs(np.linalg.norm(kept.vertices[:, :4], axis=1) - 1).max() < 1e-9
    manifold = Manifold(group.joints)
    assert float(manifold.distance(kept.vertices[kept.goals[0]], ends[1])) < 1e-9
