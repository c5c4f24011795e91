"""Roadmaps (PRM) of worlds: loaded from the roadmap cache by key, or built when not cached."""

from planning.domain.goals.goal import LineGoal
from planning.domain.planner.roadmap import Roadmap
from planning.domain.request.constraint import PathPredicate, constraint_label
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.errors import DeadlineExceeded, ProblemInvalid
from planning.goals.start_validation import resolve_start
from planning.roadmaps.roadmap_cache import RoadmapStore
from planning.roadmaps.roadmap_context import RoadmapContext
from planning.search.roadmap.build import grow_roadmap
from planning.search.space_options import resolve_space
from planning.world.constraints.constraints_fingerprint import predicate_error
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World


def build_roadmap(problem: PlanningProblem, world: World, *, deadline: Deadline) -> Roadmap:
    """Return the roadmap that a plan of this problem uses, with options `problem.search.roadmap`.

    All problems of the same group under the same path constraints in the same world share one
    roadmap: it is independent of goal and seed, and of the start except for the values of fixed or
    locked joints. The roadmap keeps one millimetre more than the required margins, so that paths
    through it are quick to verify.

    Args:
        problem: Group, margin and options of the search; its goal does not matter.
        world: Loaded scene.
        deadline: Time limit of the construction.

    Raises:
        InputError: The problem has an unknown name or invalid numbers.
        DeadlineExceeded: The time has run out.
        Canceled: Cancellation was requested.
    """
    group = resolve_space(world.group(problem.group), problem.search.spaces)
    start = resolve_start(world, group, problem.start)
    constraints = problem.constraints
    path_constraints = (
        PathConstraints.compiled(world, group, constraints, start) if constraints else None
    )
    watch = Stopwatch(deadline.clock)
    with watch.timing_failures(), watch.stage("roadmap"):
        return _build(
            RoadmapContext.from_problem(problem, world, start, path_constraints), deadline
        )


def validate_roadmap_options(problem: PlanningProblem) -> None:
    """Check that a problem whose search options have a roadmap is compatible with roadmaps.

    Raises:
        ProblemInvalid: The goal is a line goal, or a path constraint is a predicate.
    """
    if problem.search.roadmap is None:
        return
    if isinstance(problem.goal, LineGoal):
        field = "search.roadmap"
        message = f"{field}: lines are followed and not searched for; plan them without a roadmap"
        raise ProblemInvalid(message, {"field": field})
    for index, constraint in enumerate(problem.constraints):
        if isinstance(constraint, PathPredicate):
            raise predicate_error(constraint_label(index, constraint))


def load_or_build(
    context: RoadmapContext, store: RoadmapStore | None, deadline: Deadline, watch: Stopwatch
) -> Roadmap:
    """Return the roadmap of a roadmap context: from the store, or else built and stored.

    Raises:
        DeadlineExceeded: The time has run out.
        Canceled: Cancellation was requested.
    """
    cached = None if store is None else store.get(context.key)
    if cached is not None:
        return cached
    with watch.measure("roadmap_build"):
        built = _build(context, deadline)
    if store is not None:
        store.put(built)
    return built


def _build(context: RoadmapContext, deadline: Deadline) -> Roadmap:
    try:
        return grow_roadmap(
            context.build_request, context.oracle, context.key, deadline, context.residual
        )
    except DeadlineExceeded as error:
        message = (
            f"the allowed {deadline.time_limit:g} s ran out while the roadmap of "
            f"{context.build_request.options.states} states was built; it is built once, "
            "so allow for it once, or ask for fewer states"
        )
        raise error.saying(message, {"during": "roadmap"}).in_stage("roadmap") from error
