"""Region growth: IRIS-ZO regions along given paths, then a clique cover of the rest of free space.

Along a path every vertex that no region contains yet seeds a region, which links regions along the
path. The rest is covered by regions seeded at cliques of mutually visible configurations, the
largest first (Werner et al. 2024, see `cliques`), until the coverage suffices.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.planner.regions import Portal, Region, RegionOptions
from planning.domain.request.deadline import Deadline
from planning.errors import DeadlineExceeded
from planning.regions.cliques import cliques
from planning.regions.free_space import FreeSpace
from planning.regions.iris_zo import IrisZo
from planning.regions.portals import portals_of, without_redundant_faces

# Free samples by which coverage is estimated; they seed no region.
_NUM_COVERAGE_SAMPLES = 2000
# Uncovered free samples of one visibility graph, and the most samples drawn to find them.
_NUM_CLIQUE_SAMPLES = 120
_MAX_DRAWN_SAMPLES = 20_000
# Regions grown from one visibility graph: its largest cliques.
_CLIQUES_PER_GRAPH = 3
# Rounds without a new region after which growth ends.
_MAX_FRUITLESS_ROUNDS = 3


@dataclass(frozen=True)
class GrowRequest:
    """Inputs of region growth.

    Attributes:
        checker: Collision checker.
        lower: Lower bounds of the sampling domain, shape (nq,).
        upper: Upper bounds of the sampling domain, shape (nq,).
        paths: Free polylines, each shape (n, nq), or single configurations.
        options: Number of regions, desired coverage and effort per region.
        seed: Random seed.
    """

    checker: FreeSpace
    lower: Array
    upper: Array
    paths: Sequence[Array]
    options: RegionOptions
    seed: int


@dataclass
class Growth:
    """Regions grown so far.

    Attributes:
        is_covered: Whether each coverage sample is in a region.
        regions: Regions, in order of growth.
        portals: Overlaps of pairs of regions.
        stopped_by: Reason of the end: "coverage", "num_regions", "deadline" or "exhausted".
    """

    is_covered: np.ndarray[Any, np.dtype[np.bool_]]
    regions: list[Region] = field(default_factory=list)
    portals: list[Portal] = field(default_factory=list)
    stopped_by: str = "exhausted"

    @property
    def coverage(self) -> float:
        """Estimated share of the free space that is covered; 0 where nothing is free."""
        return float(self.is_covered.mean()) if len(self.is_covered) else 0.0

    @property
    def coverage_error(self) -> float:
        """Standard error of `coverage`."""
        coverage = self.coverage
        return float(np.sqrt(coverage * (1 - coverage) / max(1, len(self.is_covered))))


def grow(request: GrowRequest, deadline: Deadline, on_region: Callable[[Growth], None]) -> Growth:
    """Grow regions until the coverage or the number of regions suffices, or the time runs out.

    The same request gives the same bytes, unless the deadline ends growth.

    Args:
        request: Inputs of the growth.
        deadline: Time limit; after it the regions so far are returned.
        on_region: Called with the growth so far after every new region.

    Raises:
        Canceled: Cancellation was requested.
    """
    return _RegionGrower(request, deadline, on_region).grow()


class _RegionGrower:
    """One run of region growth: its random streams, the coverage samples and the result so far."""

    def __init__(
        self, request: GrowRequest, deadline: Deadline, on_region: Callable[[Growth], None]
    ) -> None:
        self._request, self._deadline, self._on_region = request, deadline, on_region
        streams = np.random.SeedSequence(request.seed).spawn(3)
        coverage_generator, self._clique_generator, iris_generator = map(
            np.random.default_rng, streams
        )
        options = request.options
        self._iris_zo = IrisZo(
            request.checker,
            request.lower,
            request.upper,
            options.num_free,
            options.iterations,
            iris_generator,
            deadline,
        )
        self._coverage_samples = self._free_samples(coverage_generator, _NUM_COVERAGE_SAMPLES)
        self._growth = Growth(np.zeros(len(self._coverage_samples), dtype=bool))

    def grow(self) -> Growth:
        try:
            for path in self._request.paths:
                self._cover_path(path)
            self._cover_rest()
        except DeadlineExceeded:
            self._growth.stopped_by = "deadline"
        return self._growth

    def _cover_path(self, path: Array) -> None:
        """Grow a region at every vertex of a path that no region contains yet."""
        for q in path:
            if self._is_done:
                return
            if not self._are_covered(q[None])[0]:
                self._add_region(q)

    def _cover_rest(self) -> None:
        """Grow regions at cliques of uncovered free samples until done, or none are left."""
        num_fruitless = 0
        while not self._is_done and num_fruitless < _MAX_FRUITLESS_ROUNDS:
            self._deadline.check("regions")
            num_before = len(self._growth.regions)
            samples = self._free_samples(
                self._clique_generator, _NUM_CLIQUE_SAMPLES, is_uncovered=True
            )
            if not len(samples):
                return
            for clique in islice(cliques(self._request.checker, samples), _CLIQUES_PER_GRAPH):
                self._deadline.check("regions")
                if self._is_done:
                    return
                self._add_clique_region(clique)
            num_fruitless = num_fruitless + 1 if len(self._growth.regions) == num_before else 0

    def _add_clique_region(self, clique: Array) -> None:
        """Grow a region at the mean of a clique, or else at its first configuration.

        None is grown where that seed is in collision or already covered.
        """
        for q in (clique.mean(axis=0), clique[0]):
            if self._request.checker.are_free(q[None])[0] and not self._are_covered(q[None])[0]:
                self._add_region(q)
                return

    def _add_region(self, seed: Array) -> None:
        """Grow a region around a free configuration, and add it with its portals if growth ends."""
        region = self._iris_zo.inflate(seed)
        if region is None:
            return
        growth = self._growth
        growth.regions.append(without_redundant_faces(region))
        growth.portals += portals_of(growth.regions, len(growth.regions) - 1)
        growth.is_covered |= growth.regions[-1].contains(self._coverage_samples)
        self._on_region(growth)

    @property
    def _is_done(self) -> bool:
        options, growth = self._request.options, self._growth
        if growth.coverage >= options.coverage:
            growth.stopped_by = "coverage"
        elif len(growth.regions) >= options.num_regions:
            growth.stopped_by = "num_regions"
        else:
            return False
        return True

    def _are_covered(self, qs: Float64[np.ndarray, "k n"]) -> Bool[np.ndarray, " k"]:
        covered = np.zeros(len(qs), dtype=bool)
        for region in self._growth.regions:
            covered |= region.contains(qs)
        return covered

    def _free_samples(
        self, generator: np.random.Generator, count: int, *, is_uncovered: bool = False
    ) -> Array:
        """Return up to `count` uniform free samples of the domain; fewer if they are rare."""
        request = self._request
        samples: list[Array] = []
        for _ in range(_MAX_DRAWN_SAMPLES // _NUM_COVERAGE_SAMPLES):
            candidates = generator.uniform(
                request.lower, request.upper, (_NUM_COVERAGE_SAMPLES, len(request.lower))
            )
            if is_uncovered:
                candidates = candidates[~self._are_covered(candidates)]
            samples.append(candidates[request.checker.are_free(candidates)])
            if sum(map(len, samples)) >= count:
                break
        return np.concatenate(samples)[:count]
