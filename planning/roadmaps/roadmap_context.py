"""RoadmapContext: where a roadmap grows, what it keeps to, and what it is therefore known by."""

from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from typing import Any

import numpy as np

from planning.domain.request.problem import PlanningProblem
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.steering import steering_of
from planning.domain.value import digest
from planning.errors import NoPathFound, ProblemInvalid
from planning.search.collision_oracle import CollisionOracle
from planning.search.locked_joints import JointLock, LockedJointOracle, LockedResidual
from planning.search.ompl.projected_space import Residual
from planning.search.roadmap.build import RoadmapBuildRequest
from planning.search.space_options import resolve_space
from planning.world.collision.margins import PairMargins
from planning.world.collision.search_padding import SEARCH_PADDING
from planning.world.constraints.constraints_fingerprint import constraints_fingerprint
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.fingerprint import collision_fingerprint
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# To be raised with every change of what a recipe grows into.
_GROWTH = 1
# What decides it beside our own code.
_LIBRARIES = ("drake", "numpy")


@dataclass(frozen=True)
class _Ruled:
    """What path constraints make of a group.

    Attributes:
        rules: With all the room that they wish for: one roadmap is for every start and goal.
        lock: Which joints of the group are left to move.
    """

    rules: PathConstraints
    lock: JointLock


@dataclass(frozen=True)
class RoadmapContext:
    """All that decides a roadmap.

    Attributes:
        world: What is around.
        group: Whose joints move, those that are locked among them.
        margins: Distances to keep.
        recipe: Of the joints that are left to move.
        ruled: What path constraints add, or None.
    """

    world: World
    group: JointGroup
    margins: PairMargins
    recipe: RoadmapBuildRequest
    ruled: _Ruled | None

    @classmethod
    def from_problem(
        cls, problem: PlanningProblem, world: World, start: Array, rules: PathConstraints | None
    ) -> "RoadmapContext":
        """Build the ground of the roadmap that a problem asks for.

        Args:
            problem: Group, margin and options of the search.
            world: The scene, loaded.
            start: Of which only what is held or locked counts, shape (nq,).
            rules: The problem's path constraints, from that start.

        Raises:
            UnknownName: The options name a joint, block or coordinate that does not exist.
            ProblemInvalid: A number of the options makes no sense, or there can be no such roadmap.
            NoPathFound: All joints are locked.
        """
        _require_sense(problem)
        group = resolve_space(world.group(problem.group), problem.search.spaces)
        _require_way_back(group)
        margins = world.margins(problem.margin, SEARCH_PADDING)
        limits, options = world.limits(group), problem.search
        if rules is None:
            recipe = RoadmapBuildRequest.from_search(group, limits, start, options)
            return cls(world, group, margins, recipe, None)
        lock = JointLock(group, rules.locked, start)
        if not lock.free.joints:
            message = "every joint is locked where the start has it"
            raise NoPathFound(message, {"reason": "goals", "locked": sorted(rules.locked)})
        recipe = RoadmapBuildRequest.from_search(
            lock.free, lock.limits(rules.limits(limits)), start[lock.move_q], lock.options(options)
        )
        return cls(world, group, margins, recipe, _Ruled(rules.roomy, lock))

    @property
    def key(self) -> str:
        """What the roadmap is known by: grounds that differ never share one.

        Raises:
            ProblemInvalid: A path constraint is a predicate.
        """
        seen = collision_fingerprint(self.world, self.group)
        decided = _GROWTH, _versions(), seen, self.margins, self.recipe
        if self.ruled is None:
            return digest(decided)
        return digest((*decided, constraints_fingerprint(self.ruled.rules)))

    @property
    def oracle(self) -> CollisionOracle:
        """What is free, and keeps the rules; of the joints that are left to move."""
        judge = self.world.collision_oracle(self.group, self.margins)
        if self.ruled is None:
            return judge
        return LockedJointOracle(self.ruled.lock, self.ruled.rules.oracle(judge))

    @property
    def residual(self) -> Residual | None:
        """What vanishes on a set that is too thin to be sampled, or None."""
        residual = None if self.ruled is None else self.ruled.rules.residual
        if self.ruled is None or residual is None:
            return None
        return LockedResidual(self.ruled.lock, residual)


def _require_sense(problem: PlanningProblem) -> None:
    options = problem.search.roadmap
    if options is not None and (options.states < 1 or options.neighbours < 1 or options.seed < 0):
        field = "search.roadmap"
        message = f"{field}: states and neighbours are at least 1, the seed is not negative"
        raise ProblemInvalid(message, {"field": field})


def _require_way_back(group: JointGroup) -> None:
    cars = [name for name, how in steering_of(group).items() if not how.reverse]
    if cars:
        field = "search.roadmap"
        message = (
            f"{field}: edges of roadmaps lead both ways; {', '.join(cars)} cannot drive backwards"
        )
        raise ProblemInvalid(message, {"field": field, "joints": cars})


@cache
def _versions() -> tuple[str, ...]:
    return tuple(version(name) for name in _LIBRARIES)
