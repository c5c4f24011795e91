"""Roadmaps of worlds: what they are known by, and where they come from."""

from planning.domain.goals.goal import LineGoal
from planning.domain.planner.roadmap import Roadmap
from planning.domain.request.constraint import PathPredicate, constraint_label
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.errors import DeadlineExceeded, ProblemInvalid
from planning.roadmaps.roadmap_cache import RoadmapStore
from planning.roadmaps.roadmap_context import RoadmapContext
from planning.search.roadmap.build import grow_roadmap
from planning.search.space_options import resolve_space
from planning.world.constraints.constraints_fingerprint import predicates_refused
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.loading.positions import require_positions
from planning.world.world import World


def build_roadmap(problem: PlanningProblem, world: World, *, deadline: Deadline) -> Roadmap:
    """Return the roadmap that a plan of this problem asks for, as `problem.search.roadmap` says.

    Other problems of the same group under the same path constraints in the same world ask for the
    same one, whatever their goal and seed, and whatever their start but for what is held or locked
    there; it keeps a millimetre more distance than is demanded, so that what is found in it
    can be proven soon.

    Args:
        problem: Group, margin and options of the search; its goal does not matter.
        world: The scene, loaded.
        deadline: When to give up.

    Raises:
        InputError: The problem names what does not exist, or its numbers make no sense.
        DeadlineExceeded: The time has run out.
        Canceled: The end was asked for.
    """
    group = resolve_space(world.group(problem.group), problem.search.spaces)
    given = world.positions(group) if problem.start is None else problem.start
    start = require_positions(group, given, "start")
    constraints = problem.constraints
    rules = PathConstraints.compiled(world, group, constraints, start) if constraints else None
    watch = Stopwatch(deadline.clock)
    with watch.timing_failures(), watch.stage("roadmap"):
        return _grown(RoadmapContext.from_problem(problem, world, start, rules), deadline)


def validate_search(problem: PlanningProblem) -> None:
    """Go on only if a problem that asks for a roadmap can have one.

    Raises:
        ProblemInvalid: Its goal is lines, or a path constraint is a predicate.
    """
    if problem.search.roadmap is None:
        return
    if isinstance(problem.goal, LineGoal):
        field = "search.roadmap"
        message = f"{field}: lines are followed and not searched for; plan them without a roadmap"
        raise ProblemInvalid(message, {"field": field})
    for index, constraint in enumerate(problem.constraints):
        if isinstance(constraint, PathPredicate):
            raise predicates_refused(constraint_label(index, constraint))


def load_or_build(
    ground: RoadmapContext, store: RoadmapStore | None, deadline: Deadline, watch: Stopwatch
) -> Roadmap:
    """Return the roadmap of a ground: the store's, or else a new one, which the store gets.

    Raises:
        DeadlineExceeded: The time has run out.
        Canceled: The end was asked for.
    """
    found = None if store is None else store.get(ground.key)
    if found is not None:
        return found
    with watch.note("roadmap_build"):
        built = _grown(ground, deadline)
    if store is not None:
        store.put(built)
    return built


def _grown(ground: RoadmapContext, deadline: Deadline) -> Roadmap:
    try:
        return grow_roadmap(ground.recipe, ground.oracle, ground.key, deadline, ground.residual)
    except DeadlineExceeded as error:
        message = (
            f"the allowed {deadline.allowed:g} s ran out while the roadmap of "
            f"{ground.recipe.options.states} states was built; it is built once, so allow for it "
            "once, or ask for fewer states"
        )
        raise error.saying(message, {"during": "roadmap"}).in_stage("roadmap") from error
