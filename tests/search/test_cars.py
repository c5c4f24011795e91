"""Paths of cars among walls: drivable, free and within bounds by an independent check."""

from contextlib import contextmanager
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from planning.domain.curves.motion_samples import steps_of
from planning.domain.request.options import SearchOptions
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.domain.robot.steering import Steering, manifold_of, steered
from planning.domain.robot.steering_request import validate_forward_planners
from planning.errors import DeadlineExceeded, ProblemInvalid, UnknownName
from planning.search.cars.steering_edges import SteeringEdgeChecker
from planning.search.cars.steering_paths import SteeringPaths
from planning.search.cars.steering_shortcut import shortcut_steering_path
from planning.search.collision_oracle import WatchedOracle
from planning.search.ompl.planner_list import planner_names
from planning.search.shortcut.polyline import path_length
from planning.search.solver import SearchTask, search
from tests.clocks import FakeClock, after_looks, no_hurry
from tests.profiles import PROFILE, num_cases, pairs, seeds
from tests.search.conftest import Oracle, group_of, limits_of

PLANE = (JointType.PLANAR,)
WITH_ARM = (JointType.PLANAR, JointType.REVOLUTE, JointType.CONTINUOUS)
RADIUS = 0.15


def directed():
    """Return the planners that a car without reverse may ask for, as the refusal names them."""
    with pytest.raises(ProblemInvalid) as refusal:
        validate_forward_planners(["PRM"], {"r::j0": Steering(RADIUS, reverse=False)})
    return refusal.value.evidence["known"]


DIRECTED = directed()


def car(kinds=PLANE, *, reverse=True, radius=RADIUS):
    group = group_of(*kinds)
    return steered(group, {"r::j0": Steering(radius, reverse)})


def arms(count, *values):
    return np.array([*values, *np.linspace(-0.5, 0.5, count)])


def beyond_disc(qs):
    """A disc about the origin."""
    return np.hypot(qs[:, 0], qs[:, 1]) > 0.2


def beyond_wall(qs):
    """A wall across x = 0 with an end at y = 0.1."""
    return ~((np.abs(qs[:, 0]) < 0.06) & (qs[:, 1] < 0.1))


def task_of(group, seed=0, start=(-0.6, -0.1, 0.0), end=(0.6, 0.1, 0.0), **options):
    extra = group.num_positions - 3
    return SearchTask(
        start=arms(extra, *start),
        goals=arms(extra, *end)[None] * np.array([1, 1, 1, *[-1] * extra]),
        options=SearchOptions(**options),
        resolution=0.05,
        padding=0.0,
        seed=seed,
    )


def found(group, seed=0, oracle=beyond_disc, deadline=None, **more):
    task = task_of(group, seed, **more)
    return search(group, limits_of(group), Oracle(oracle), task, deadline or no_hurry())


def assert_drivable(group, waypoints, oracle, lower=-1.0, upper=1.0):
    """Every piece is an arc that the car can drive, free and inside ten times as finely."""
    steering = group.steering["r::j0"]
    manifold = manifold_of(group)
    deltas = manifold.minus(waypoints[1:], waypoints[:-1])
    ahead, aside, turn = deltas[:, :3].T
    assert (np.abs(aside) <= 1e-6 * np.abs(ahead)).all()
    assert (np.abs(turn) * steering.turning_radius <= (1 + 1e-6) * np.abs(ahead)).all()
    if not steering.reverse:
        assert (ahead >= -1e-12).all()
    for q0, q1 in pairwise(waypoints):
        count = 2 + int(manifold.distance(q1, q0) / (0.05 / 4 / 10))
        qs = manifold.interpolate(q0, q1, np.linspace(0, 1, count))
        # To be free at samples is to be at most half a step of them in the wall.
        shrunk = qs[oracle(qs)]
        assert len(qs) - len(shrunk) <= 10
        assert (qs[:, :2] >= lower - 1e-8).all()
        assert (qs[:, :2] <= upper + 1e-8).all()


@pytest.mark.parametrize(("kinds", "reverse"), pairs([PLANE, WITH_ARM], [True, False]))
@pytest.mark.parametrize("seed", seeds(1, 20))
@pytest.mark.campaign
def test_rrtconnect_drives_around_a_wall(kinds, reverse, seed):
    group = car(kinds, reverse=reverse)
    poses = {"start": (-0.6, -0.6, 0.0), "end": (0.6, -0.6, 0.0)}
    result = found(group, seed, beyond_wall, **poses)
    assert not result.report.direct
    assert_drivable(group, result.path.waypoints, beyond_wall)
    assert result.path.waypoints[0].tobytes() == arms(len(kinds) - 1, -0.6, -0.6, 0).tobytes()
    assert result.report.length <= result.report.raw_length
    assert found(group, seed, beyond_wall, **poses).path == result.path


@pytest.mark.parametrize("name", ["BKPIECE1", "LBKPIECE1", "PRM"])
def test_other_planners_drive_a_car_that_reverses(name):
    group = car()
    result = found(group, planner=name)
    assert not result.report.direct
    assert_drivable(group, result.path.waypoints, beyond_disc)


# A usual batch would take too long for a test.
_SMALL = {"BITstar": {"samples_per_batch": 20}}


class Solving(Stopwatch):
    """Oracle that distinguishes the checks of a planner from those of its path."""

    def __init__(self):
        super().__init__(FakeClock())
        self.is_on = False

    @contextmanager
    def measure(self, name):
        self.is_on = name == "solve"
        with super().measure(name):
            yield
        self.is_on = False


@pytest.mark.campaign
@pytest.mark.parametrize(
    "name", DIRECTED if PROFILE.is_campaign else ["BITstar", "KPIECE1", "RRTConnect", "RRTstar"]
)
def test_one_way_planners_check_in_the_direction_of_motion(name):
    """Every sample of the planner's path was checked in the direction of driving."""
    group, watch, asked = car(reverse=False), Solving(), []

    def are_free(qs):
        if watch.is_on:
            asked.append(qs)
        return beyond_disc(qs)

    def placed(qs):
        return np.column_stack([qs[:, :2], np.cos(qs[:, 2]), np.sin(qs[:, 2])])

    task = task_of(
        group, 1, planner=name, parameters=_SMALL.get(name, {}), shortcut_time=0.0, attempts=1
    )
    limits = limits_of(group)
    path = search(group, limits, Oracle(are_free), task, no_hurry(), watch).path.waypoints
    assert_drivable(group, path, beyond_disc)
    manifold = manifold_of(group)
    deltas = manifold.minus(path[1:], path[:-1])
    samples = [
        manifold.plus(q, np.arange(1, n + 1)[:, None] / n * delta)
        for q, delta, n in zip(path, deltas, steps_of(deltas, 0.05), strict=False)
    ]
    gaps, _ = cKDTree(placed(np.concatenate(asked))).query(placed(np.concatenate(samples)))
    assert gaps.max() < 1e-6


@pytest.mark.parametrize("name", sorted(set(planner_names()) - set(DIRECTED)))
def test_other_planners_are_refused_for_one_way(name):
    with pytest.raises(ProblemInvalid, match="RRTConnect") as refusal:
        found(car(reverse=False), planner=("RRT", name))
    assert refusal.value.evidence["field"] == "search.planner"


OPTIONS = {
    "weights": {"weights": {"r::j0": 3.0, "r::j1": 0.2}},
    "weighted length": {"weights": {"r::j0.linear": 2.0}, "objective": "weighted_length"},
    "duration": {"objective": "duration", "attempts": 2},
    "clearance": {"objective": "clearance"},
    "no shortcut": {"shortcut_time": 0.0},
    "many states": {"num_states": 300, "keep_graph": True},
    "asked for": {"spaces": {"r::j0": Steering(0.2, reverse=False)}},
}


@pytest.mark.parametrize("name", OPTIONS)
def test_options_hold(name):
    group = car(WITH_ARM)
    result = found(group, 2, **OPTIONS[name])
    if name == "asked for":
        group = car(WITH_ARM, reverse=False, radius=0.2)
    assert_drivable(group, result.path.waypoints, beyond_disc)
    assert len(result.path.waypoints) >= OPTIONS[name].get("num_states", 2)


@pytest.mark.parametrize("reverse", [True, False])
def test_bounds_hold_on_the_whole_way(reverse):
    group = car(reverse=reverse)
    box = {"bounds": {"r::j0.x": (-0.65, 0.65), "r::j0.y": (-0.5, 0.35)}}
    result = found(group, 1, **box)
    low, high = np.array(list(box["bounds"].values())).T
    assert_drivable(group, result.path.waypoints, beyond_disc, low, high)


def test_a_car_that_cannot_turn_within_the_bounds_has_no_path():
    """Nose against the bound, and no reverse."""
    poses = {"start": (0.99, 0.9, 0.0), "end": (0.3, 0.9, 0.0)}
    with pytest.raises(DeadlineExceeded):
        found(car(reverse=False), deadline=after_looks(2_000), **poses)
    result = found(car(), **poses)
    assert_drivable(car(), result.path.waypoints, beyond_disc)


@pytest.mark.parametrize(
    ("spaces", "error"),
    [
        ({"r::j1": Steering(0.2)}, UnknownName),
        ({"r::j0": Steering(0.0)}, ProblemInvalid),
        ({"r::j0": Steering(float("nan"))}, ProblemInvalid),
        ({"r::j0": Steering(RADIUS / 2)}, ProblemInvalid),
        ({"r::j0": "position"}, ProblemInvalid),
    ],
)
def test_steering_beyond_the_robot_s_is_refused(spaces, error):
    with pytest.raises(error):
        found(car(WITH_ARM), spaces=spaces)


def test_two_cars_at_once_are_refused():
    group = group_of(JointType.PLANAR, JointType.PLANAR)
    both = {"r::j0": Steering(0.2), "r::j1": Steering(0.3)}
    with pytest.raises(ProblemInvalid, match="may have one car"):
        SteeringPaths(steered(group, both))


@given(seed=st.integers(0, 10_000), reverse=st.booleans())
def test_a_steering_path_ends_at_its_goal_with_the_arm_in_proportion(seed, reverse):
    group = car(WITH_ARM, reverse=reverse)
    drives = SteeringPaths(group)
    q0, q1 = np.random.default_rng(seed).uniform(-1, 1, (2, 5)) * [1, 1, 3, 1, 1]
    way = drives.steer(q0, q1).waypoints
    assert_drivable(group, way, lambda qs: np.ones(len(qs), bool), -9.0, 9.0)
    assert way[0].tobytes() == q0.tobytes()
    assert way[-1].tobytes() == q1.tobytes()
    deltas = drives.manifold.minus(way[1:], way[:-1])
    driven = np.cumsum(np.hypot(deltas[:, 0], deltas[:, 1]))
    arm = np.cumsum(np.abs(deltas[:, 3]))
    assert arm / arm[-1] == pytest.approx(driven / driven[-1])
    length = np.linalg.norm(deltas, axis=1).sum()
    summed = np.linalg.norm(drives.tangents(q0[None], q1[None]), axis=2).sum()
    assert length == pytest.approx(summed)
    for a, b in pairwise(way):
        assert len(drives.steer(a, b).waypoints) == 2
    if reverse:
        assert drives.steer(q1, q0).waypoints[::-1].tobytes() == way.tobytes()


@given(seed=st.integers(0, 10_000))
@settings(max_examples=num_cases(4))
def test_shortcuts_only_shorten_and_stay_free(seed):
    group = car(reverse=bool(seed % 2))
    limits = limits_of(group)
    oracle = Oracle(lambda qs: np.hypot(qs[:, 0], qs[:, 1]) > 0.35)
    soon = no_hurry(10.0)
    watched = WatchedOracle(oracle, group, limits, soon)
    drives = SteeringPaths(group)
    edges = SteeringEdgeChecker(
        drives, watched, 0.02, lambda d: np.linalg.norm(d, axis=-1), (limits.lower, limits.upper)
    )
    rng = np.random.default_rng(seed)
    path = [np.array([-0.7, -0.6, 0.0])]
    while len(path) < 4:
        q = rng.uniform(-0.9, 0.9, 3) * [1, 1, 3]
        if edges.is_whole_edge_free(path[-1].tolist(), q.tolist()):
            path.append(q)
    raw = drives.waypoints_through(np.array(path))
    shorter = shortcut_steering_path(raw, edges, lambda: False)
    assert path_length(shorter, drives.manifold) <= path_length(raw, drives.manifold) + 1e-9
    assert edges.are_free(shorter[:-1], shorter[1:]).all()
    assert_drivable(group, shorter, lambda qs: np.hypot(qs[:, 0], qs[:, 1]) > 0.34)
    over = shortcut_steering_path(raw, edges, lambda: True)
    assert path_length(over, drives.manifold) <= path_length(raw, drives.manifold) + 1e-9


def test_a_blocked_drive_is_none():
    group = car()
    limits = limits_of(group)
    soon = no_hurry(10.0)
    oracle = WatchedOracle(Oracle(lambda qs: np.abs(qs[:, 0]) > 0.1), group, limits, soon)
    drives = SteeringPaths(group)
    edges = SteeringEdgeChecker(
        drives, oracle, 0.02, lambda d: np.linalg.norm(d, axis=-1), (limits.lower, limits.upper)
    )
    raw = drives.waypoints_through(np.array([[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]))
    assert shortcut_steering_path(raw, edges, lambda: False) is None


def test_a_straight_line_in_the_plane_is_no_path_of_a_car():
    """A position beside the car is farther than its Euclidean distance."""
    group = car()
    aside = SteeringPaths(group).steer(np.zeros(3), np.array([0.0, 0.1, 0.0])).waypoints
    manifold = manifold_of(group)
    assert path_length(aside, manifold) > 3 * Manifold(group.joints).distance(aside[-1], aside[0])
