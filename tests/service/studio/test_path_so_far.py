"""The best path of a search as the studio draws it, before there is one that is proven."""

from contextlib import closing, nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from service.studio.api import Api
from service.studio.plans.path_so_far import PathSoFar, along
from tests.profiles import rng_of, seeds
from tests.service.servers import until

PICKUP = (Path(__file__).parents[3] / "scenes" / "ur5e_pickup.scene.yaml").read_text()


@pytest.mark.campaign
@pytest.mark.parametrize("seed", seeds(3))
def test_points_lie_on_the_path_and_as_far_from_each_other_along_it(seed):
    rng = rng_of(seed)
    waypoints = rng.normal(size=(int(rng.integers(2, 9)), 4))
    rows = along(waypoints, ["a", "b", "c", "d"], 201)
    np.testing.assert_allclose(rows[[0, -1]], waypoints[[0, -1]], atol=1e-12)
    length = np.linalg.norm(np.diff(waypoints, axis=0), axis=1).sum()
    steps = np.linalg.norm(np.diff(rows, axis=0), axis=1)
    # a step over a corner is shorter
    assert steps.max() <= length / 200 + 1e-9
    assert np.sum(steps < length / 200 - 1e-9) <= len(waypoints) - 2
    first, edge = waypoints[:-1], np.diff(waypoints, axis=0)
    share = np.einsum("rek,ek->re", rows[:, None] - first, edge) / (edge**2).sum(axis=1)
    nearest = first + np.clip(share, 0, 1)[..., None] * edge
    assert np.linalg.norm(rows[:, None] - nearest, axis=2).min(axis=1).max() < 1e-9


def test_quaternions_between_waypoints_have_length_1():
    turn = np.sqrt(0.5)
    waypoints = np.array([[0.3, 1, 0, 0, 0, 5.0], [0.4, turn, turn, 0, 0, 7.0]])
    names = ["arm", *(f"body.{name}" for name in ("qw", "qx", "qy", "qz", "x"))]
    rows = along(waypoints, names, 7)
    np.testing.assert_allclose(np.linalg.norm(rows[:, 1:5], axis=1), 1.0)
    np.testing.assert_allclose(rows[[0, -1]], waypoints, atol=1e-12)


def test_a_path_that_stands_still_is_drawn_as_a_point():
    rows = along(np.ones((2, 3)), ["a", "b", "c"], 5)
    np.testing.assert_array_equal(rows, np.ones((5, 3)))


class Drawn:
    """A view and a browser that note what is drawn in them."""

    def __init__(self, moving):
        self.moving, self.traces, self.ghosts, self.client = moving, {}, [], self

    atomic = staticmethod(nullcontext)

    def show_others(self, ghosts):
        self.ghosts = list(ghosts)

    def draw_trace(self, name, points, colors):
        assert points.shape == colors.shape
        self.traces[name] = points
        return SimpleNamespace(remove=lambda: self.traces.pop(name))


@pytest.fixture
def api(real_server):
    with closing(Api(real_server.url)) as opened:
        yield opened


def cell_of(api):
    scene = api.add_scene(PICKUP).id
    shown = api.shown(scene)
    drawn = Drawn(["arm::hand_base", "arm::forearm_link"])
    cell = SimpleNamespace(api=api, scene=shown, group=shown.groups[0], view=drawn, client=drawn)
    return cell, drawn


def test_the_newest_path_is_drawn_with_ghosts_and_taken_away_at_the_end(api):
    cell, drawn = cell_of(api)
    faults = []
    best = PathSoFar(faults.append)
    best.show([[0.0] * 6, [0.1] * 6])  # of no plan: nothing
    best.begin(cell)
    assert drawn.traces == {}
    start = cell.group.positions
    tools = cell.group.tool_frames[:1]
    for share in (0.2, 0.4):
        goal = [q + share for q in start]
        best.show([start, goal])
        ends = cell.api.poses(cell.scene.id, "arm", np.array([start, goal]), tools)[tools[0]]
        until(
            lambda ends=ends: (
                faults
                or [
                    points
                    for points in [*drawn.traces.values()]
                    if np.allclose(points[[0, -1]], ends[:, :3])
                ]
            )
        )
        assert len(drawn.traces) == 1
        assert len(drawn.ghosts) == 4
        assert all(set(ghost) == set(drawn.moving) for ghost in drawn.ghosts)
    best.show(None)
    best.end()
    assert (drawn.traces, drawn.ghosts, faults) == ({}, [], [])
    best.show([start, start])
    best.close()
    assert drawn.traces == {}
