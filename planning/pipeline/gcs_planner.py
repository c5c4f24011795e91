"""GcsPlanner: the planner "GCS", shortest paths inside regions, with OMPL planners as fallback."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.planner.planner_card import PlannerCard, PlannerParameter
from planning.domain.planner.regions import Regions
from planning.domain.report.search_report import RegionsReport, SearchReport
from planning.domain.request.options import SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.region_request import validate_convex
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.domain.robot.steering import steering_of
from planning.errors import ProblemInvalid
from planning.pipeline.context import PlanContext
from planning.regions.gcs_path import shortest_inside
from planning.world.world import World

type Scalar = str | float | int | bool

GCS = "GCS"
GCS_CARD = PlannerCard(
    GCS,
    (
        PlannerParameter("max_regions", "5", "integer, at least 1, at most 200", "integer", 1, 200),
        PlannerParameter(
            "max_rounded_paths", "5", "integer, at least 1, at most 100", "integer", 1, 100
        ),
    ),
    needs_regions=True,
)
# Fallback planner if the problem names no other.
_FALLBACK_PLANNER = "RRTConnect"
# Largest joint motion between waypoints [rad]: less than half a turn, so that the geodesic of a
# joint that wraps around is the straight line between them.
_MAX_WAYPOINT_STEP = 1.0


def validate_regions(problem: PlanningProblem, world: World, group: JointGroup) -> None:
    """Check that a problem with the planner "GCS" has regions that fit it.

    Raises:
        ProblemInvalid: There are no regions, or they belong to another scene or group, or have a
            smaller margin than required; or the group cannot have regions, or a parameter is
            invalid.
    """
    if GCS not in problem.search.planners:
        return
    kinds = {joint.name: joint.type for joint in group.joints}
    validate_convex(kinds, steering_of(group), "search.planner")
    regions, margin = problem.regions, world.margins(problem.margin).default
    if regions is None:
        message = (
            f"search.planner {GCS!r} needs regions: grow them first and give them as `regions`"
        )
        raise ProblemInvalid(message, {"field": "regions"})
    mismatches = {
        "scene": regions.scene != world.digest,
        "group": regions.group != group.name,
        "margin": regions.margin < margin,
    }
    if any(mismatches.values()):
        wrong = ", ".join(name for name, is_wrong in mismatches.items() if is_wrong)
        message = (
            f"the regions do not fit the {wrong} of this problem: they were grown for group "
            f"{regions.group!r} and margin {regions.margin:g} m in scene {regions.scene[:12]}"
        )
        raise ProblemInvalid(message, {"field": "regions", "differs": wrong})
    split_parameters(problem.search.parameters)


def split_parameters(
    parameters: Mapping[str, Scalar],
) -> tuple[dict[str, int], dict[str, Scalar]]:
    """Return the parameters of GCS, with defaults filled in, and those of the other planners.

    Raises:
        ProblemInvalid: A value has the wrong type or lies outside its range.
    """
    gcs_parameters = {known.name: int(known.default) for known in GCS_CARD.parameters}
    for known in GCS_CARD.parameters:
        given = parameters.get(known.name, gcs_parameters[known.name])
        number = _as_integer(given)
        if number is None or not (known.minimum or 0) <= number <= (known.maximum or np.inf):
            message = f"parameter {known.name!r} of {GCS} is {given!r}; it must be: {known.range}"
            field = f"search.parameters.{known.name}"
            raise ProblemInvalid(message, {"field": field, "value": str(given)})
        gcs_parameters[known.name] = number
    return gcs_parameters, {
        name: value for name, value in parameters.items() if name not in gcs_parameters
    }


def _as_integer(given: Scalar) -> int | None:
    try:
        number = float(given)
    except ValueError:
        return None
    return int(number) if number.is_integer() and not isinstance(given, bool) else None


def make_gcs_planner(context: PlanContext, round_: int) -> "GcsPlanner | None":
    """Return the GCS planner of a round; None if the problem does not name the planner "GCS"."""
    regions = context.problem.regions
    if regions is None or GCS not in context.problem.search.planners:
        return None
    if context.constraints is not None:
        return GcsPlanner(context, regions, "regions do not respect path constraints")
    reason = "the motions of the first round were not certified" if round_ else ""
    return GcsPlanner(context, regions, reason)


class GcsPlanner:
    """Path guide of a search: the shortest path inside regions.

    Attributes:
        name: "GCS".
        options: Search options of the fallback planners.
    """

    def __init__(self, context: PlanContext, regions: Regions, reason: str) -> None:
        """Prepare for the context's start; with a reason against it, no path is proposed."""
        self.name = GCS
        self._start, self._regions = context.start, regions
        self._gcs_parameters, other_parameters = split_parameters(context.problem.search.parameters)
        self.options = _without_gcs(context.problem.search, other_parameters)
        self._reason = reason
        self._considered_regions: tuple[int, ...] = ()
        manifold = Manifold(context.group.joints)
        self._has_wrapping_joints = any(manifold.wraps)

    def propose_path(self, goals: Float64[np.ndarray, "n nq"]) -> tuple[Array, int] | None:
        """Return the shortest path inside the regions and the row of its goal; None if none."""
        if self._reason:
            return None
        gcs_path = shortest_inside(self._regions, self._start, goals, **self._gcs_parameters)
        self._considered_regions, self._reason = gcs_path.rows, gcs_path.reason
        if gcs_path.reason:
            return None
        waypoints = gcs_path.waypoints
        return _subdivide(waypoints) if self._has_wrapping_joints else waypoints, gcs_path.goal_row

    def with_regions_report(self, report: SearchReport) -> SearchReport:
        """Return the report of the search with a report on the use of the regions."""
        is_inside = report.planner == GCS and not report.direct
        reason = self._reason
        if not is_inside and not reason:
            reason = "the straight line is free"
            if not report.direct:
                reason = "the GCS path collides at the fine resolution"
        regions = self._regions
        regions_report = RegionsReport(
            regions.digest, len(regions.regions), self._considered_regions, is_inside, reason
        )
        return replace(
            report, planner=GCS if report.direct else report.planner, regions=regions_report
        )


def _without_gcs(options: SearchOptions, parameters: Mapping[str, Any]) -> SearchOptions:
    others = tuple(name for name in options.planners if name != GCS)
    planner = others if len(others) > 1 else (*others, _FALLBACK_PLANNER)[0]
    return replace(options, planner=planner, parameters=parameters)


def _subdivide(waypoints: Array) -> Array:
    """Return the path with waypoints inserted, none farther apart than `_MAX_WAYPOINT_STEP`."""
    rows = [waypoints[:1]]
    for before, after in pairwise(waypoints):
        count = int(np.ceil(np.abs(after - before).max() / _MAX_WAYPOINT_STEP))
        fractions = np.arange(1, max(count, 1) + 1)[:, None] / max(count, 1)
        rows.append(before + fractions * (after - before))
    return np.concatenate(rows)
