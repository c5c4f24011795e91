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
_BUILD_VERSION = 1
# Libraries whose versions affect the result; part of the cache key.
_LIBRARIES = ("drake", "numpy")


@dataclass(frozen=True)
class _RoadmapConstraints:
    """Path constraints of a roadmap and the joints that they lock.

    Attributes:
        tightened: Path constraints tightened by their full preferred margins, since one roadmap
            serves every start and goal.
        lock: Split of the group's joints into locked and free ones.
    """

    tightened: PathConstraints
    lock: JointLock


@dataclass(frozen=True)
class RoadmapContext:
    """All inputs that determine a roadmap.

    Attributes:
        world: Loaded scene.
        group: Joint group, locked joints included.
        margins: Required distance of every body pair, search padding included.
        build_request: Build request for the joints that are not locked.
        constraints: Path constraints and locked joints; None without path constraints.
    """

    world: World
    group: JointGroup
    margins: PairMargins
    build_request: RoadmapBuildRequest
    constraints: _RoadmapConstraints | None

    @classmethod
    def from_problem(
        cls,
        problem: PlanningProblem,
        world: World,
        start: Array,
        constraints: PathConstraints | None,
    ) -> "RoadmapContext":
        """Build the context of the roadmap of a problem.

        Args:
            problem: Group, margin and options of the search.
            world: Loaded scene.
            start: Start, shape (nq,); only its fixed and locked coordinates matter.
            constraints: The problem's path constraints, compiled for that start; None for none.

        Raises:
            UnknownName: The options name a joint, block or coordinate that does not exist.
            ProblemInvalid: A number of the options is invalid, or a vehicle of the group cannot
                reverse, while roadmap edges lead in both directions.
            NoPathFound: All joints are locked.
        """
        _validate_options(problem)
        group = resolve_space(world.group(problem.group), problem.search.spaces)
        _validate_reversible(group)
        margins = world.margins(problem.margin, SEARCH_PADDING)
        limits, options = world.limits(group), problem.search
        if constraints is None:
            build_request = RoadmapBuildRequest.from_search(group, limits, start, options)
            return cls(world, group, margins, build_request, None)
        lock = JointLock(group, constraints.locked, start)
        if not lock.free.joints:
            message = "path constraints lock every joint of the group, so nothing can move"
            raise NoPathFound(message, {"reason": "goals", "locked": sorted(constraints.locked)})
        build_request = RoadmapBuildRequest.from_search(
            lock.free,
            lock.limits(constraints.limits(limits)),
            start[lock.free_q_indices],
            lock.options(options),
        )
        return cls(
            world,
            group,
            margins,
            build_request,
            _RoadmapConstraints(constraints.fully_tightened, lock),
        )

    @property
    def key(self) -> str:
        """Cache key of the roadmap: a digest of all inputs, so different contexts never share one.

        Raises:
            ProblemInvalid: A path constraint is a predicate.
        """
        scene_digest = collision_fingerprint(self.world, self.group)
        inputs = _BUILD_VERSION, _library_versions(), scene_digest, self.margins, self.build_request
        if self.constraints is None:
            return digest(inputs)
        return digest((*inputs, constraints_fingerprint(self.constraints.tightened)))

    @property
    def oracle(self) -> CollisionOracle:
        """Collision oracle over the unlocked joints; path constraints count as collisions."""
        checker = self.world.collision_oracle(self.group, self.margins)
        if self.constraints is None:
            return checker
        return LockedJointOracle(self.constraints.lock, self.constraints.tightened.oracle(checker))

    @property
    def residual(self) -> Residual | None:
        """Equality-constraint residual of the path constraints, zero on the constraint manifold.

        Rejection sampling cannot reach such a set of measure zero. None without such constraints.
        """
        residual = None if self.constraints is None else self.constraints.tightened.residual
        if self.constraints is None or residual is None:
            return None
        return LockedResidual(self.constraints.lock, residual)


def _validate_options(problem: PlanningProblem) -> None:
    options = problem.search.roadmap
    if options is not None and (options.states < 1 or options.neighbours < 1 or options.seed < 0):
        field = "search.roadmap"
        message = f"{field}: states and neighbours must be at least 1, the seed not negative"
        raise ProblemInvalid(message, {"field": field})


def _validate_reversible(group: JointGroup) -> None:
    cars = [name for name, how in steering_of(group).items() if not how.reverse]
    if cars:
        field = "search.roadmap"
        message = (
            f"{field}: roadmap edges lead in both directions, and {', '.join(cars)} cannot drive "
            "backwards"
        )
        raise ProblemInvalid(message, {"field": field, "joints": cars})


@cache
def _library_versions() -> tuple[str, ...]:
    return tuple(version(name) for name in _LIBRARIES)
