"""Region growth in analytic worlds: estimated coverage, and the reasons why growth ends."""

from itertools import combinations, pairwise

import numpy as np

from planning.domain.planner.regions import RegionOptions
from planning.domain.request.deadline import Deadline
from planning.regions.cliques import cliques
from planning.regions.grow import GrowRequest, grow
from tests.clocks import no_hurry
from tests.regions.conftest import Plane, off_disc, off_wall


def grown(plane, *, paths=(), deadline=None, coverages=None, **options):
    coverages = [] if coverages is None else coverages
    chosen = RegionOptions(num_free=1000, **options)
    request = GrowRequest(plane, plane.lower, plane.upper, paths, chosen, 3)
    growth = grow(request, deadline or no_hurry(), lambda g: coverages.append(g.coverage))
    return growth, coverages


def test_coverage_is_true_to_its_error():
    plane = Plane(off_disc)
    growth, coverages = grown(plane, num_regions=3)
    grid = plane.grid()
    free = grid[plane.are_free(grid)]
    truly = np.any([region.contains(free) for region in growth.regions], axis=0).mean()
    assert abs(growth.coverage - truly) < 5 * growth.coverage_error + 1e-3
    assert coverages == sorted(coverages)
    assert len(coverages) == len(growth.regions) == 3
    assert growth.stopped_by == "num_regions"


def test_growth_ends_when_enough_is_covered():
    growth, coverages = grown(Plane(off_wall), num_regions=40, coverage=0.85)
    assert growth.stopped_by == "coverage"
    assert coverages[-1] >= 0.85 > coverages[-2]


def test_without_time_no_region_grows():
    growth, _ = grown(Plane(off_wall), deadline=no_hurry(0.0))
    assert growth.stopped_by == "deadline"
    assert growth.regions == []
    assert growth.coverage == 0


def test_at_the_deadline_the_regions_so_far_are_returned():
    """By a clock that moves once two regions have been reported."""
    coverages = []
    deadline = Deadline.after(1.0, lambda: float(len(coverages) >= 2))
    growth, coverages = grown(
        Plane(off_wall), deadline=deadline, coverages=coverages, num_regions=10
    )
    assert growth.stopped_by == "deadline"
    assert len(growth.regions) == len(coverages) == 2
    whole, _ = grown(Plane(off_wall), num_regions=10)
    assert [*growth.regions] == [*whole.regions[:2]]


def test_without_free_space_no_region_grows():
    growth, _ = grown(Plane(lambda qs: np.zeros(len(qs), dtype=bool)))
    assert growth.regions == []
    assert (growth.coverage, growth.coverage_error) == (0, 0)


def test_regions_along_a_path_are_connected():
    plane = Plane(off_wall)
    corner = np.array([[-0.6, -0.5], [-0.6, 0.8], [0.6, 0.8], [0.6, -0.5]])
    path = np.concatenate([np.linspace(a, b, 15) for a, b in pairwise(corner)])
    growth, _ = grown(plane, paths=[path], coverage=0.01, num_regions=10)
    assert growth.stopped_by == "coverage"
    growth, _ = grown(plane, paths=[path], num_regions=10, coverage=1.0)
    assert np.any([region.contains(path) for region in growth.regions], axis=0).all()
    reached, edges = {0}, [portal.regions for portal in growth.portals]
    for _ in growth.regions:
        reached |= {row for edge in edges for row in edge if reached & set(edge)}
    last = next(i for i, region in enumerate(growth.regions) if region.contains(path[-1:])[0])
    assert last in reached


def test_cliques_see_one_another_and_are_disjoint():
    plane = Plane(off_wall)
    qs = np.random.default_rng(0).uniform(-1, 1, (60, 2))
    qs = qs[plane.are_free(qs)]
    found = list(cliques(plane, qs))
    assert sorted(map(tuple, np.concatenate(found))) == sorted(map(tuple, qs))
    # All pairs in one batch: the world samples each batch at a spacing of its own.
    first, second = np.triu_indices(len(qs), 1)
    free = plane.are_motions_free(qs[first], qs[second] - qs[first], 0.1)
    place = {tuple(q): row for row, q in enumerate(qs)}
    visible = {(i, j) for i, j in zip(first[free].tolist(), second[free].tolist(), strict=True)}
    for clique in found:
        rows = sorted(place[tuple(q)] for q in clique)
        assert set(combinations(rows, 2)) <= visible
    assert len(found[0]) >= len(found[-1])
