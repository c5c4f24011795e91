"""Regions of analytic worlds: free, convex, large and reproducible."""

import numpy as np
import pytest

from planning.errors import Canceled, DeadlineExceeded
from planning.regions.hit_and_run import hit_and_run
from planning.regions.iris_zo import IrisZo
from planning.regions.portals import portals_of, without_redundant_faces
from tests.clocks import after_looks, no_hurry
from tests.regions.conftest import Plane, in_triangle, off_wall

SEED = np.array([-0.7, -0.3])


def forever():
    return no_hurry(60.0)


def inflater(plane, seed=0, deadline=None, num_free=3000):
    generator = np.random.default_rng(seed)
    limit = deadline or forever()
    return IrisZo(plane, plane.lower, plane.upper, num_free, 3, generator, limit)


def test_a_region_is_free_and_holds_its_seed(plane):
    region = inflater(plane).inflate(SEED)
    grid = plane.grid()
    inside = grid[region.contains(grid)]
    assert len(inside) > 400
    assert plane.are_free(inside).mean() > 1 - 3 / 3000
    assert region.contains(SEED[None])[0]
    assert region.num_free >= 3000


def test_a_convex_free_set_is_found_almost_whole():
    plane = Plane(in_triangle)
    region = inflater(plane).inflate(SEED)
    grid = plane.grid()
    free = plane.are_free(grid)
    assert region.contains(grid)[free].mean() > 0.9
    assert not region.contains(grid)[~free].any()


def test_without_obstacles_a_region_is_the_domain():
    plane = Plane(lambda qs: np.ones(len(qs), dtype=bool))
    region = without_redundant_faces(inflater(plane).inflate(SEED))
    assert len(region.offsets) == 4
    assert region.contains(plane.grid()).all()


def test_the_same_seed_gives_the_same_bytes(plane):
    first, again = (inflater(plane, seed=4).inflate(SEED) for _ in range(2))
    assert first == again
    assert first != inflater(plane, seed=5).inflate(SEED)


def test_trimming_changes_no_point(plane):
    region = inflater(plane).inflate(SEED)
    less = without_redundant_faces(region)
    grid = plane.grid(100)
    assert len(less.offsets) <= len(region.offsets)
    np.testing.assert_array_equal(less.contains(grid), region.contains(grid))


def test_portals_are_balls_inside_both():
    plane = Plane(off_wall)
    seeds = np.array([[-0.6, 0.0], [0.0, 0.8], [0.6, 0.0]])
    regions = [inflater(plane, seed=k).inflate(q) for k, q in enumerate(seeds)]
    portals = [portal for row in range(3) for portal in portals_of(regions, row)]
    assert {portal.regions for portal in portals} == {(0, 1), (1, 2)}
    around = np.linspace(0, 2 * np.pi, 50)
    for portal in portals:
        ball = portal.point + 0.999 * portal.radius * np.stack([np.cos(around), np.sin(around)], 1)
        for row in portal.regions:
            assert regions[row].contains(ball).all()


def test_deadline_and_cancellation_end_growth():
    plane = Plane(off_wall)
    for looks in (1, 2, 4):
        with pytest.raises(DeadlineExceeded):
            inflater(plane, deadline=after_looks(looks)).inflate(SEED)
    with pytest.raises(Canceled):
        inflater(plane, deadline=no_hurry(9.0, lambda: True)).inflate(SEED)


def test_walks_are_uniform():
    """On a triangle the mean is the centroid, and a half of the area gets half of the walkers."""
    faces = np.array([[-1.0, 0.0], [0.0, -1.0], [1.0, 1.0]]), np.array([0.0, 0.0, 1.0])
    begin = np.full((4000, 2), 0.1)
    qs = hit_and_run(begin, faces, np.eye(2), 30, np.random.default_rng(0))
    assert (qs @ faces[0].T <= faces[1] + 1e-12).all()
    np.testing.assert_allclose(qs.mean(axis=0), [1 / 3, 1 / 3], atol=0.02)
    assert abs((qs[:, 0] > qs[:, 1]).mean() - 0.5) < 0.03
