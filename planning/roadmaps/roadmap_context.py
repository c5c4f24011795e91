"""RoadmapContext: all inputs that determine a roadmap (PRM), and its cache key."""

from dataclasses import dataclass
from functools import cache
from importlib.metadata import version

from planning.domain.arrays import Array
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

# Version of the roadmap construction: to be raised with every change of its result.
_GROWTH = 1
# Libraries whose versions affect the result; part of the cache key.
_LIBRARIES = ("drake", "numpy")


@dataclass(frozen=True)
class _Ruled:
    """Path constraints of a roadmap and the joints that they lock.

    Attributes:
        rules: Path constraints tightened by their full preferred margins, since one roadmap serves
            every start and goal.
        lock: Split of the group's joints into locked and free ones.
    """

    rules: PathConstraints
    lock: JointLock


@dataclass(frozen=True)
class RoadmapContext:
    """All inputs that determine a roadmap.

    Attributes:
        world: Loaded scene.
        group: Joint group, locked joints included.
        margins: Required distance of every body pair, search padding included.
        recipe: Build request for the joints that are not locked.
        ruled: Path constraints and locked joints; None without path constraints.
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
        """Build the context of the roadmap of a problem.

        Args:
            problem: Group, margin and options of the search.
            world: Loaded scene.
            start: Start, shape (nq,); only its fixed and locked coordinates matter.
            rules: The problem's path constraints, compiled for that start; None for none.

        Raises:
            UnknownName: The options name a joint, block or coordinate that does not exist.
            ProblemInvalid: A number of the options is invalid, or a vehicle of the group cannot
                reverse, while roadmap edges lead both ways.
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
        """Cache key of the roadmap: a digest of all inputs, so different contexts never share one.

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
        """Collision oracle over the unlocked joints; path constraints count as collisions."""
        judge = self.world.collision_oracle(self.group, self.margins)
        if self.ruled is None:
            return judge
        return LockedJointOracle(self.ruled.lock, self.ruled.rules.oracle(judge))

    @property
    def residual(self) -> Residual | None:
        """Equality-constraint residual of the path constraints, zero on the constraint manifold.

        Rejection sampling cannot reach such a set of measure zero. None without such constraints.
        """
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
