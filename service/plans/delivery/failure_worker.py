"""Failures in 3-D: the configuration at which a plan failed, and what meets there."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from planning import World, check_configurations
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.geometry.pose import Pose
from planning.errors import InputError
from planning.world.replay.still_writer import Still, still_html
from service.jobs.context import TaskContext
from service.plans.models.goals import JointGoal
from service.plans.models.request import PlanRequest
from service.plans.tasks import SHOW_FAILURE, FailureWork, Page
from service.scenes.world_cache import borrow_world

# So many pairs are shown, the deepest first: more would hide the robot.
_MOST_PAIRS = 8
_AT_START = ("start_", "scene_")


@SHOW_FAILURE.runs
def show_failure(work: FailureWork, _: TaskContext) -> Page:
    """Make the page that shows where a plan failed.

    Raises:
        InputError: The scene does not load any more.
    """
    failure, evidence = work.failure, work.failure.get("evidence") or {}
    with borrow_world(work) as world:
        group = world.group(work.request.group)
        place, positions = shown_configuration(work.request, failure, group.num_positions)
        nearest = _row((evidence.get("nearest") or {}).get("positions"), group.num_positions)
        pairs, target = _pairs(world, work.request, positions), _target(evidence)
        marked = {name for bodies in _named_pairs(evidence) for name in bodies}
        still = Still(
            title=f"{work.plan}: {failure.get('code', 'failed')}",
            notes=[
                str(failure.get("detail", "")),
                f"Shown: {place}.",
                *(_pair_text(pair) for pair in pairs),
                *(["Green: the nearest feasible configuration."] if nearest is not None else []),
                *(["Large axes: the goal."] if target is not None else []),
            ],
            state=None if positions is None else world.embed(group, positions),
            pairs=pairs,
            marked=sorted(marked),
            ghost=None if nearest is None else world.embed(group, nearest),
            target=target,
        )
        return Page(html=still_html(world, still))


def shown_configuration(
    request: PlanRequest, failure: Mapping[str, Any], num_positions: int
) -> tuple[str, np.ndarray[Any, Any] | None]:
    """Return which configuration shows a failure best, in words and as the group's positions.

    Args:
        request: Of the plan.
        failure: Of the plan.
        num_positions: Of the group; a configuration of another length is of another version.

    Returns:
        Words, and positions of shape (num_positions,) [rad or m]; None for the scene's state.
    """
    evidence = failure.get("evidence") or {}
    goal = request.goal.positions if isinstance(request.goal, JointGoal) else None
    choices: list[tuple[str, Any]] = []
    if not str(failure.get("code", "")).startswith(_AT_START):
        choices = [
            ("the goal, where it is least infeasible", _inner(evidence, "relaxation", "positions")),
            ("where the line stops", _inner(evidence, "stopped_by", "positions")),
            _failed_check(evidence),
            ("the goal", goal),
            (
                "where the search came nearest to a goal",
                _inner(evidence, "approximate", "positions"),
            ),
        ]
    for place, given in [*choices, ("the start", request.start)]:
        row = _row(given, num_positions)
        if row is not None:
            return place, row
    return "the start", None


def _target(evidence: Mapping[str, Any]) -> Pose | None:
    """Return the goal's pose of the tool that is nearest to a feasible one, in world."""
    goal = _inner(evidence, "nearest", "goal")
    return None if goal is None else Pose.from_parts(goal["position"], goal["quaternion"])


def _failed_check(evidence: Mapping[str, Any]) -> tuple[str, Any]:
    """Return where the last motion fails the certificate: at its clearance, if that fails too."""
    checks = [check for check in evidence.get("checks") or () if check.get("positions")]
    if not checks:
        return "", None
    worst = min(checks, key=lambda check: check["name"] != "clearance")
    return f"the motion at {worst['time']:.3f} s, where {worst['name']} fails", worst["positions"]


def _inner(evidence: Mapping[str, Any], *names: str) -> Any:
    found: Any = evidence
    for name in names:
        found = found.get(name) if isinstance(found, Mapping) else None
    return found


def _row(given: Any, num_positions: int) -> np.ndarray[Any, Any] | None:
    """Return the first configuration of some positions, None if they are of no configuration."""
    if given is None or isinstance(given, Mapping):
        return None
    rows = np.atleast_2d(np.array(given, dtype=float))
    return rows[0] if len(rows) and rows.shape[1] == num_positions else None


def _pairs(
    world: World, request: PlanRequest, positions: np.ndarray[Any, Any] | None
) -> tuple[BodyPair, ...]:
    """Return the pairs that overlap or violate their margin, nearest first, as they are here."""
    group = world.group(request.group)
    q = world.positions(group) if positions is None else positions
    try:
        (verdict,) = check_configurations(world, request.group, q[None], request.margin)
    except InputError:  # a margin that the scene does not take, or positions out of range
        return ()
    return verdict.violations[:_MOST_PAIRS]


def _named_pairs(evidence: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the pairs of bodies that evidence names."""
    stopped = _inner(evidence, "stopped_by", "pair") or {}
    listed = [*(evidence.get("pairs") or ()), *(_inner(evidence, "relaxation", "obstacles") or ())]
    for pair in [stopped, *listed]:
        bodies = pair.get("bodies") if isinstance(pair, Mapping) else None
        if bodies:
            yield tuple(bodies)
    if evidence.get("pair") and all(evidence["pair"]):
        yield tuple(evidence["pair"])


def _pair_text(pair: BodyPair) -> str:
    millimetres = 1000 * pair.distance
    told = f"overlap by {-millimetres:.1f} mm" if millimetres < 0 else f"{millimetres:.1f} mm apart"
    return f"{pair.bodies[0]} and {pair.bodies[1]}: {told}"
