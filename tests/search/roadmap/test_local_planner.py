"""Roadmaps without straight edges: of cars, and along sets too thin to be sampled."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RoadmapOptions, SearchOptions
from planning.domain.robot.joints import JointType
from planning.domain.robot.steering import Steering, steered
from planning.errors import DeadlineExceeded
from planning.search.projection import project
from planning.search.request import SearchTask
from planning.search.roadmap.build import RoadmapBuildRequest, grow_roadmap
from planning.search.solver import search
from tests.clocks import no_hurry
from tests.profiles import num_cases
from tests.search.conftest import Oracle, group_of, limits_of
from tests.search.test_cars import assert_drivable, beyond_disc

FEW = RoadmapOptions(states=24, neighbours=4)
RADIUS, WIDTH = 0.7, 0.01


@dataclass(frozen=True)
class Ring:
    """Distance of a point of the plane from a ring of half the allowed width."""

    size = 1

    def residual(self, q):
        off = np.linalg.norm(q) - RADIUS
        return np.array([np.sign(off) * max(abs(off) - WIDTH / 2, 0.0)])

    def jacobian(self, q):
        return (q / np.linalg.norm(q) if self.residual(q)[0] else 0 * q)[None]


def on_open_ring(qs):
    """The ring, but for a gap where it crosses the x axis on the left."""
    off = np.abs(np.linalg.norm(qs, axis=1) - RADIUS)
    return (off <= WIDTH) & ~((qs[:, 0] < 0) & (np.abs(qs[:, 1]) < 0.1))


def ring_roadmap(soon, states=40, seed=0):
    group = group_of(JointType.PRISMATIC, JointType.PRISMATIC)
    options = SearchOptions(roadmap=RoadmapOptions(states, 6, seed), resolution=0.1)
    request = RoadmapBuildRequest.from_search(group, limits_of(group), np.zeros(2), options)
    return group, grow_roadmap(request, Oracle(on_open_ring), "key", soon, Ring())


@settings(max_examples=num_cases(6))
@given(st.floats(-1, 1), st.floats(-1, 1))
def test_a_projection_is_on_the_set_and_about_the_nearest_point(x, y):
    q = np.array([x, y])
    length = float(np.linalg.norm(q))
    if length < 1e-3:
        return
    found = project(Ring(), q)
    assert abs(np.linalg.norm(found) - RADIUS) <= WIDTH / 2 + 1e-5
    assert np.linalg.norm(found - q) <= max(0.0, abs(length - RADIUS) - WIDTH / 2) + 1e-5


def test_every_edge_of_a_roadmap_follows_a_thin_set(soon):
    _, roadmap = ring_roadmap(soon)
    assert on_open_ring(roadmap.states).all()
    assert len(roadmap.states) > 40  # edges bend: their waypoints are states too
    for i, j in roadmap.edges:
        steps = np.linspace(0.0, 1.0, 200)[:, None]
        between = roadmap.states[i] + steps * (roadmap.states[j] - roadmap.states[i])
        off = np.abs(np.linalg.norm(between, axis=1) - RADIUS)
        assert off.max() <= WIDTH + 1e-4
    assert ring_roadmap(soon)[1] == roadmap
    assert ring_roadmap(soon, seed=1)[1].digest != roadmap.digest


def test_a_query_is_joined_along_the_set_and_goes_around_the_gap(soon):
    group, roadmap = ring_roadmap(soon, states=12)
    ends = [RADIUS * np.array([np.cos(a), np.sin(a)]) for a in (2.9, -2.9)]
    rough = SearchOptions(shortcut_time=0.0)
    task = SearchTask(
        ends[0], np.array(ends[1:]), rough, 0.05, 0.0, 0, residual=Ring(), roadmap=roadmap
    )
    found, again = (
        search(group, limits_of(group), Oracle(on_open_ring), task, soon) for _ in range(2)
    )
    assert found.report.roadmap.used
    assert found.path.waypoints.tobytes() == again.path.waypoints.tobytes()
    waypoints = found.path.waypoints
    assert (waypoints[0] == ends[0]).all()
    assert (waypoints[-1] == ends[1]).all()
    steps = np.linspace(0.0, 1.0, 50)[:, None]
    for a, b in pairwise(waypoints):
        assert np.abs(np.linalg.norm(a + steps * (b - a), axis=1) - RADIUS).max() <= WIDTH + 1e-4
    assert found.report.length == pytest.approx(2 * 2.9 * RADIUS, rel=0.05)


def test_growing_along_a_thin_set_minds_its_deadline():
    now = [0.0]

    def clock():
        now[0] += 0.01
        return now[0]

    with pytest.raises(DeadlineExceeded):
        ring_roadmap(Deadline.after(0.5, clock))


@pytest.mark.parametrize("arm", [(), (JointType.REVOLUTE,)])
def test_a_car_finds_a_path_in_a_roadmap_of_steering_paths(arm):
    group = steered(group_of(JointType.PLANAR, *arm), {"r::j0": Steering(0.3, reverse=True)})
    start = np.array([-0.8, 0.0, 0.0, *([0.1] * len(arm))])
    goal = np.array([0.8, 0.0, 0.0, *([-0.4] * len(arm))])
    oracle, limits = Oracle(beyond_disc, group), limits_of(group)
    options = SearchOptions(roadmap=FEW)
    deadline = no_hurry(30.0)
    request = RoadmapBuildRequest.from_search(group, limits, start, options)
    roadmap = grow_roadmap(request, oracle, "key", deadline)
    assert grow_roadmap(request, oracle, "key", deadline) == roadmap
    task = SearchTask(start, goal[None], options, 0.05, 0.0, 0, roadmap=roadmap)
    found = search(group, limits, oracle, task, deadline)
    assert found.report.roadmap.used, found.report.roadmap.reason
    assert_drivable(group, found.path.waypoints, beyond_disc)
    other = search(group, limits, oracle, replace(task, seed=9), deadline)
    assert other.path.waypoints.tobytes() == found.path.waypoints.tobytes()
    assert (found.path.waypoints[0] == start).all()
    assert (found.path.waypoints[-1] == goal).all()


def test_every_steering_path_of_a_roadmap_is_free_in_reverse_too():
    group = steered(group_of(JointType.PLANAR), {"r::j0": Steering(0.3, reverse=True)})
    oracle, limits = Oracle(beyond_disc, group), limits_of(group)
    request = RoadmapBuildRequest.from_search(
        group, limits, np.zeros(3), SearchOptions(roadmap=FEW)
    )
    deadline = no_hurry(30.0)
    roadmap = grow_roadmap(request, oracle, "key", deadline)
    assert len(roadmap.edges) > 20
    steering_paths = request.space.steering_paths
    for i, j in roadmap.edges:
        for a, b in ((i, j), (j, i)):
            waypoints = steering_paths.steer(roadmap.states[a], roadmap.states[b]).waypoints
            assert_drivable(group, waypoints, beyond_disc)
