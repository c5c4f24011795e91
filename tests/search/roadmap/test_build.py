"""Roadmap construction: by the build request alone, every edge free, on every kind of space."""

from dataclasses import replace

import numpy as np
import pytest

from planning.domain.request.options import RoadmapOptions, SearchOptions
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import Canceled, DeadlineExceeded, NoPathFound
from planning.search.roadmap.build import RoadmapBuildRequest, grow_roadmap
from planning.search.solver import search
from tests.clocks import after_looks, no_hurry
from tests.search.conftest import beyond_wall, l_in_slit

SMALL = RoadmapOptions(states=100, neighbours=6)


def request_of(group, limits, start=None, **options):
    options.setdefault("roadmap", SMALL)
    at = np.zeros(group.num_positions) if start is None else start
    return RoadmapBuildRequest.from_search(group, limits, at, SearchOptions(**options))


def grown(group, limits, oracle, deadline, **options):
    return grow_roadmap(request_of(group, limits, **options), oracle, "key", deadline)


@pytest.mark.parametrize(
    "kinds",
    [
        (JointType.REVOLUTE, JointType.PRISMATIC),
        (JointType.CONTINUOUS, JointType.REVOLUTE),
        (JointType.PLANAR,),
        (JointType.FLOATING,),
        (JointType.FLOATING, JointType.REVOLUTE, JointType.CONTINUOUS),
    ],
)
def test_every_state_and_edge_is_free_on_every_space(kinds, make_group, make_limits, make_oracle):
    group = make_group(*kinds)
    limits = make_limits(group)
    manifold = Manifold(group.joints)

    def is_far(qs):  # a ball of what is forbidden, by the manifold's own metric
        return manifold.distance(qs, middle) > 0.8

    middle = manifold.normalized(np.full(group.num_positions, 0.3))
    deadline = no_hurry(20.0)
    few = RoadmapOptions(states=40, neighbours=4)
    roadmap = grown(group, limits, make_oracle(is_far, group), deadline, roadmap=few)
    assert len(roadmap.states) == 40
    assert len(roadmap.edges) > 40
    bounded = np.isfinite(limits.upper)
    assert (np.abs(roadmap.states[:, bounded]) <= 1.0).all()
    steps = np.linspace(0.0, 1.0, 300)
    for i, j in roadmap.edges[:: max(1, len(roadmap.edges) // 60)]:
        between = manifold.interpolate(roadmap.states[i], roadmap.states[j], steps)
        # Between two samples a ball of this size is entered by no more than this.
        assert manifold.distance(between, middle).min() > 0.8 - 0.0125
    assert (roadmap.edges[:, 0] < roadmap.edges[:, 1]).all()
    assert len(np.unique(roadmap.edges, axis=0)) == len(roadmap.edges)


def test_the_request_alone_determines_the_roadmap(plane, make_oracle, soon):
    a, b = (grown(*plane, make_oracle(beyond_wall), soon) for _ in range(2))
    assert a.digest == b.digest
    assert a.num_states_checked == b.num_states_checked > 0
    variants = [
        {"roadmap": replace(SMALL, seed=1)},
        {"roadmap": replace(SMALL, states=101)},
        {"roadmap": replace(SMALL, neighbours=7)},
        {"weights": {"r::j0": 5.0}},
        {"bounds": {"r::j0": (-0.9, 0.9)}},
    ]
    digests = {grown(*plane, make_oracle(beyond_wall), soon, **v).digest for v in variants}
    assert len(digests | {a.digest}) == 1 + len(variants)


def test_a_held_rotation_is_the_same_in_every_state(make_group, make_limits, make_oracle, soon):
    group = make_group(JointType.PLANAR)
    start = np.array([0.0, 0.0, 0.7])
    request = request_of(group, make_limits(group), start, spaces={"r::j0": "position"})
    roadmap = grow_roadmap(request, make_oracle(l_in_slit), "key", soon)
    assert (roadmap.states[:, 2] == 0.7).all()
    elsewhere = request_of(
        group, make_limits(group), np.array([0.5, 0.5, 0.7]), spaces={"r::j0": "position"}
    )
    assert elsewhere == request


def test_where_nothing_is_free_there_are_no_states(plane, make_oracle, soon, crossing):
    blocked = make_oracle(lambda qs: np.zeros(len(qs), bool))
    empty = grown(*plane, blocked, soon)
    assert len(empty.states) == len(empty.edges) == 0
    task = replace(crossing(3, planner="RRTConnect"), roadmap=empty)
    found = search(*plane, make_oracle(beyond_wall), task, soon)
    assert found.report.roadmap.reason == "start_not_joined"
    assert found.report.planner == "RRTConnect"


def test_a_path_through_the_roadmap_needs_few_checks(plane, make_oracle, soon, crossing):
    oracle = make_oracle(beyond_wall)
    roadmap = grown(*plane, oracle, soon)
    task = crossing(3, keep_graph=True)
    found = search(*plane, oracle, replace(task, roadmap=roadmap), soon)
    assert found.report.roadmap.used
    assert found.report.planner == "roadmap"
    assert (found.path.waypoints[0] == task.start).all()
    assert (found.path.waypoints[-1] == task.goals[found.goal_row]).all()
    assert found.report.num_states_checked < roadmap.num_states_checked
    graph = found.graph
    assert graph.num_vertices >= len(roadmap.states) + 2
    assert (graph.vertices[graph.path[0]] == task.start).all()
    pairs = set(graph.edges)
    assert all(
        (min(i, j), max(i, j)) in pairs for i, j in zip(graph.path, graph.path[1:], strict=False)
    )


@pytest.mark.parametrize("objective", ["length", "weighted_length", "duration", "clearance"])
def test_the_path_is_the_cheapest_of_the_graph(plane, make_oracle, soon, crossing, objective):
    """A* and the Bellman-Ford algorithm find paths of the same cost."""
    from planning.search.query import make_query
    from planning.search.roadmap import shortest_roadmap_path as roadmap_way
    from planning.search.verified_path import fine_checker

    oracle = make_oracle(beyond_wall)
    roadmap = grown(*plane, oracle, soon)
    task = crossing(3, objective=objective, weights={"r::j1": 3.0})
    query, _ = make_query(*plane, oracle, task, soon, None)
    way = roadmap_way.shortest_roadmap_path(roadmap, query, fine_checker(query, 0.05))
    assert not way.reason
    graph, cost = way.graph, query.objective.edge_costs
    best = np.full(len(graph.qs), np.inf)
    best[graph.starts] = 0.0
    for _ in range(len(graph.qs)):
        before = best.copy()
        for i in np.flatnonzero(np.isfinite(before)):
            rows = graph.neighbours(int(i))
            if rows:
                best[rows] = np.minimum(best[rows], best[i] + cost(graph.qs[rows], graph.qs[i]))
        if (best == before).all():
            break
    given = cost(way.waypoints[1:], way.waypoints[:-1]).sum()
    assert given == pytest.approx(min(best[graph.goals]))


def test_goals_that_cannot_be_joined_are_left_to_the_planner(plane, make_oracle, soon, crossing):
    task = crossing(3)

    def are_free(qs):  # the roadmap's world: nothing free near the goals
        return beyond_wall(qs) & (qs[:, 0] < 0.05)

    roadmap = grown(*plane, make_oracle(are_free), soon)
    found = search(*plane, make_oracle(beyond_wall), replace(task, roadmap=roadmap), soon)
    plain = search(*plane, make_oracle(beyond_wall), task, soon)
    assert not found.report.roadmap.used
    assert found.report.roadmap.reason == "goal_not_joined"
    assert found.path.waypoints.tobytes() == plain.path.waypoints.tobytes()


def test_a_roadmap_of_another_world_delivers_no_collision(plane, make_oracle, soon, crossing):
    """A roadmap of another world costs time, but its path is checked."""
    roadmap = grown(*plane, make_oracle(lambda qs: np.ones(len(qs), bool)), soon)
    found = search(*plane, make_oracle(beyond_wall), replace(crossing(3), roadmap=roadmap), soon)
    manifold = Manifold(plane[0].joints)
    for a, b in zip(found.path.waypoints, found.path.waypoints[1:], strict=False):
        steps = np.arange(0.0, 1.0, 0.0125 / max(1e-9, float(manifold.distance(b, a))))
        assert beyond_wall(manifold.interpolate(a, b, steps)).all()


def test_failures_tell_of_the_roadmap(plane, closed, soon, crossing, make_oracle):
    roadmap = grown(*plane, closed, soon)
    task = crossing(3, planner=("BFMT", "BFMT"), parameters={"num_samples": 60})
    with pytest.raises(NoPathFound) as caught:
        search(*plane, closed, replace(task, roadmap=roadmap), soon)
    assert caught.value.evidence["roadmap"]["reason"] == "no_way"


def test_growing_heeds_deadline_and_cancel(plane, wall):
    with pytest.raises(DeadlineExceeded):
        grown(*plane, wall, after_looks(5))
    with pytest.raises(Canceled):
        grown(*plane, wall, no_hurry(9.0, lambda: True))
