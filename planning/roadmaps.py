"""Roadmaps of worlds: what they are known by, and where they come from."""

from functools import cache
from importlib.metadata import version
from typing import Any

import numpy as np

from planning.domain.deadline import Deadline
from planning.domain.goal import LineGoal
from planning.domain.joints import JointGroup
from planning.domain.problem import PlanningProblem
from planning.domain.roadmap import Roadmap
from planning.domain.steering import steering_of
from planning.domain.value import digest
from planning.errors import DeadlineExceeded, ProblemInvalid
from planning.paddings import WISH
from planning.roadmap_shelf import RoadmapStore
from planning.search.demands import driven
from planning.search.roadmap_growth import RoadmapRecipe, grow_roadmap
from planning.stopwatch import Stopwatch
from planning.world.fingerprint import collision_fingerprint
from planning.world.margins import PairMargins
from planning.world.positions import require_positions
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# To be raised with every change of what a recipe grows into.
_GROWTH = 1
# What decides it beside our own code.
_LIBRARIES = ("drake", "numpy")


def build_roadmap(problem: PlanningProblem, world: World, *, deadline: Deadline) -> Roadmap:
    """Return the roadmap that a plan of this problem asks for, as `problem.search.roadmap` says.

    Other problems of the same group in the same world ask for the same one, whatever their start,
    goal and seed; it keeps a millimetre more distance than is demanded, so that what is found in it
    can be proven soon.

    Args:
        problem: Group, margin and options of the search; its goal does not matter.
        world: The scene, loaded.
        deadline: When to give up.

    Raises:
        InputError: The problem names what does not exist, or its numbers make no sense.
        DeadlineExceeded: The time has run out.
        Canceled: Somebody asked for the end.
    """
    group = world.group(problem.group)
    given = world.positions(group) if problem.start is None else problem.start
    start = require_positions(group, given, "start")
    recipe, margins = _recipe(problem, world, group, start)
    return _grown(recipe, margins, world, deadline)


def require_search(problem: PlanningProblem) -> None:
    """Go on only if a problem that asks for a roadmap has something to search for.

    Raises:
        ProblemInvalid: Its goal is lines.
    """
    if problem.search.roadmap is not None and isinstance(problem.goal, LineGoal):
        field = "search.roadmap"
        message = f"{field}: lines are followed and not searched for; plan them without a roadmap"
        raise ProblemInvalid(message, {"field": field})


def roadmap_of(
    problem: PlanningProblem,
    world: World,
    start: Array,
    store: RoadmapStore | None,
    deadline: Deadline,
    watch: Stopwatch,
) -> Roadmap:
    """Return a problem's roadmap: the store's, or else a new one, which the store gets.

    Raises:
        ProblemInvalid: Its options make no sense.
        DeadlineExceeded: The time has run out.
        Canceled: Somebody asked for the end.
    """
    recipe, margins = _recipe(problem, world, world.group(problem.group), start)
    found = None if store is None else store.get(_key(recipe, margins, world))
    if found is not None:
        return found
    with watch.note("roadmap_build"):
        built = _grown(recipe, margins, world, deadline)
    if store is not None:
        store.put(built)
    return built


def _recipe(
    problem: PlanningProblem, world: World, group: JointGroup, start: Array
) -> tuple[RoadmapRecipe, PairMargins]:
    options = problem.search.roadmap
    if problem.constraints:
        field = "search.roadmap"
        message = f"{field}: roadmaps know no path constraints; plan without the one or the others"
        raise ProblemInvalid(message, {"field": field})
    cars = list(steering_of(driven(group, problem.search.spaces)))
    if cars:
        field = "search.roadmap"
        message = f"{field}: edges of roadmaps are straight; {', '.join(cars)} cannot drive them"
        raise ProblemInvalid(message, {"field": field, "joints": cars})
    if options is not None and (options.states < 1 or options.neighbours < 1 or options.seed < 0):
        field = "search.roadmap"
        message = f"{field}: states and neighbours are at least 1, the seed is not negative"
        raise ProblemInvalid(message, {"field": field})
    recipe = RoadmapRecipe.from_search(group, world.limits(group), start, problem.search)
    return recipe, world.margins(problem.margin, WISH)


def _grown(
    recipe: RoadmapRecipe, margins: PairMargins, world: World, deadline: Deadline
) -> Roadmap:
    oracle = world.collision_oracle(recipe.group, margins)
    try:
        return grow_roadmap(recipe, oracle, _key(recipe, margins, world), deadline)
    except DeadlineExceeded as error:
        message = (
            f"the allowed {deadline.allowed:g} s ran out while the roadmap of "
            f"{recipe.options.states} states was built; it is built once, so allow for it once, "
            "or ask for fewer states"
        )
        evidence = error.evidence | {"during": "roadmap"}
        raise DeadlineExceeded(message, evidence) from error


def _key(recipe: RoadmapRecipe, margins: PairMargins, world: World) -> str:
    seen = collision_fingerprint(world, recipe.group)
    return digest((_GROWTH, _versions(), seen, margins, recipe))


@cache
def _versions() -> tuple[str, ...]:
    return tuple(version(name) for name in _LIBRARIES)
