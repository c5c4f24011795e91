"""grow(): regions along given paths, then a cover of what is left.

Along a path every configuration that no region holds yet gets one of its own, so that regions
overlap from one end to the other. What is left is covered by cliques of configurations that see
one another, the largest first, until enough is covered.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.planner.regions import Portal, Region, RegionOptions
from planning.domain.request.deadline import Deadline
from planning.errors import DeadlineExceeded
from planning.regions.cliques import cliques
from planning.regions.free_space import FreeSpace
from planning.regions.iris_zo import IrisZo
from planning.regions.overlap import portals_of, without_redundant_faces

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Free configurations by which coverage is measured; no region is grown for them.
_AUDIENCE = 2000
# Uncovered configurations among which cliques are looked for, and how many are drawn in search of
# them.
_CROWD = 120
_MOST_DRAWN = 20_000
# Regions that are grown for one crowd: the largest cliques.
_CLIQUES = 3
# Rounds of cliques without a new region after which there are no more.
_FRUITLESS = 3


@dataclass(frozen=True)
class GrowRequest:
    """What to grow.

    Attributes:
        judge: Says what keeps its distances.
        lower: Lowest configuration of the domain, shape (nq,).
        upper: And highest.
        paths: Free polylines, each shape (n, nq), or single configurations.
        options: How many, and until when.
        seed: Of all randomness.
    """

    judge: FreeSpace
    lower: Array
    upper: Array
    paths: Sequence[Array]
    options: RegionOptions
    seed: int


@dataclass
class Growth:
    """What has grown so far.

    Attributes:
        regions: In order.
        portals: Where they overlap.
        is_covered: Which of the audience are covered.
        stopped_by: Why it ended.
    """

    is_covered: np.ndarray[Any, np.dtype[np.bool_]]
    regions: list[Region] = field(default_factory=list)
    portals: list[Portal] = field(default_factory=list)
    stopped_by: str = "exhausted"

    @property
    def coverage(self) -> float:
        """Share of the audience that is covered; 0 where nothing is free."""
        return float(self.is_covered.mean()) if len(self.is_covered) else 0.0

    @property
    def coverage_error(self) -> float:
        """Its standard error."""
        share = self.coverage
        return float(np.sqrt(share * (1 - share) / max(1, len(self.is_covered))))


def grow(request: GrowRequest, deadline: Deadline, on_region: Callable[[Growth], None]) -> Growth:
    """Grow regions until enough is covered, or there are enough, or time is up.

    The same request gives the same bytes, as long as the deadline cuts nothing.

    Raises:
        Canceled: The end was asked for.
    """
    return _RegionGrower(request, deadline, on_region).grow()


class _RegionGrower:
    def __init__(
        self, request: GrowRequest, deadline: Deadline, on_region: Callable[[Growth], None]
    ) -> None:
        self._request, self._deadline, self._tell = request, deadline, on_region
        streams = np.random.SeedSequence(request.seed).spawn(3)
        audience, self._crowd, inflating = map(np.random.default_rng, streams)
        options = request.options
        self._inflater = IrisZo(
            request.judge,
            request.lower,
            request.upper,
            options.num_free,
            options.iterations,
            inflating,
            deadline,
        )
        self._audience = self._free_ones(audience, _AUDIENCE)
        self._growth = Growth(np.zeros(len(self._audience), dtype=bool))

    def grow(self) -> Growth:
        try:
            for path in self._request.paths:
                self._cover_path(path)
            self._cover_rest()
        except DeadlineExceeded:
            self._growth.stopped_by = "deadline"
        return self._growth

    def _cover_path(self, path: Array) -> None:
        for q in path:
            if self._is_done:
                return
            if not self._covered(q[None])[0]:
                self._plant(q)

    def _cover_rest(self) -> None:
        fruitless = 0
        while not self._is_done and fruitless < _FRUITLESS:
            self._deadline.check("regions")
            before = len(self._growth.regions)
            crowd = self._free_ones(self._crowd, _CROWD, is_uncovered=True)
            if not len(crowd):
                return
            for clique in islice(cliques(self._request.judge, crowd), _CLIQUES):
                self._deadline.check("regions")
                if self._is_done:
                    return
                self._plant_clique(clique)
            fruitless = fruitless + 1 if len(self._growth.regions) == before else 0

    def _plant_clique(self, clique: Array) -> None:
        """Grow a region in the midst of a clique, or where one of it is that sees the most."""
        for q in (clique.mean(axis=0), clique[0]):
            if self._request.judge.are_free(q[None])[0] and not self._covered(q[None])[0]:
                self._plant(q)
                return

    def _plant(self, seed: Array) -> None:
        region = self._inflater.inflate(seed)
        if region is None:
            return
        growth = self._growth
        growth.regions.append(without_redundant_faces(region))
        growth.portals += portals_of(growth.regions, len(growth.regions) - 1)
        growth.is_covered |= growth.regions[-1].contains(self._audience)
        self._tell(growth)

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

    def _covered(self, qs: Float64[np.ndarray, "k n"]) -> Bool[np.ndarray, " k"]:
        covered = np.zeros(len(qs), dtype=bool)
        for region in self._growth.regions:
            covered |= region.contains(qs)
        return covered

    def _free_ones(
        self, generator: np.random.Generator, count: int, *, is_uncovered: bool = False
    ) -> Array:
        """Return random free configurations of the domain, fewer if they are rare."""
        request = self._request
        found: list[Array] = []
        for _ in range(_MOST_DRAWN // _AUDIENCE):
            drawn = generator.uniform(request.lower, request.upper, (_AUDIENCE, len(request.lower)))
            if is_uncovered:
                drawn = drawn[~self._covered(drawn)]
            found.append(drawn[request.judge.are_free(drawn)])
            if sum(map(len, found)) >= count:
                break
        return np.concatenate(found)[:count]
