"""A search that is led through regions: the planner "GCS", and what stands in for it elsewhere."""

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
# Who searches outside of the regions where nobody else is named.
_FALLBACK_PLANNER = "RRTConnect"
# Joints on circles go the shorter way between waypoints, so these are no farther apart [rad].
_MAX_WAYPOINT_STEP = 1.0


def validate_regions(problem: PlanningProblem, world: World, group: JointGroup) -> None:
    """Go on only if the planner "GCS", where it is asked for, has regions that fit.

    Raises:
        ProblemInvalid: There are none, or they belong to another scene or group, or keep less
            distance than is demanded; or the group can have none, or a parameter makes no sense.
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
    faults = {
        "scene": regions.scene != world.digest,
        "group": regions.group != group.name,
        "margin": regions.margin < margin,
    }
    if any(faults.values()):
        wrong = ", ".join(name for name, is_fault in faults.items() if is_fault)
        message = (
            f"the regions were grown for group {regions.group!r} and margin {regions.margin:g} m "
            f"in scene {regions.scene[:12]}; this problem differs in: {wrong}"
        )
        raise ProblemInvalid(message, {"field": "regions", "differs": wrong})
    split_parameters(problem.search.parameters)


def split_parameters(
    parameters: Mapping[str, Scalar],
) -> tuple[dict[str, int], dict[str, Scalar]]:
    """Return the parameters of GCS, defaults filled in, and those of others.

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
    """Return who leads the search, None if the planner "GCS" is not asked for."""
    regions = context.problem.regions
    if regions is None or GCS not in context.problem.search.planners:
        return None
    if context.constraints is not None:
        return GcsPlanner(context, regions, "regions know no path constraints")
    return GcsPlanner(context, regions, "its motions could not be proven" if round_ else "")


class GcsPlanner:
    """Leads a search through regions.

    Attributes:
        name: "GCS".
        options: Of those who search where it knows no way.
    """

    def __init__(self, context: PlanContext, regions: Regions, reason: str) -> None:
        """Lead from the context's start, unless there is a reason not to."""
        self.name = GCS
        self._start, self._regions = context.start, regions
        self._gcs_parameters, other_parameters = split_parameters(context.problem.search.parameters)
        self.options = _without_gcs(context.problem.search, other_parameters)
        self._reason = reason
        self._considered_regions: tuple[int, ...] = ()
        manifold = Manifold(context.group.joints)
        self._has_wrapping_joints = any(manifold.wraps)

    def propose_path(self, goals: Float64[np.ndarray, "n nq"]) -> tuple[Array, int] | None:
        """Return the shortest path inside the regions, and the row of its goal."""
        if self._reason:
            return None
        gcs_path = shortest_inside(self._regions, self._start, goals, **self._gcs_parameters)
        self._considered_regions, self._reason = gcs_path.rows, gcs_path.reason
        if gcs_path.reason:
            return None
        return (
            _subdivide(gcs_path.waypoints) if self._has_wrapping_joints else gcs_path.waypoints
        ), gcs_path.goal_row

    def with_regions_report(self, report: SearchReport) -> SearchReport:
        """Return the report of the search with what the regions were good for."""
        is_inside = report.planner == GCS and not report.direct
        reason = self._reason
        if not is_inside and not reason:
            reason = "the straight line is free"
            if not report.direct:
                reason = "the path inside is blocked on a closer look"
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
    """Return the path with more waypoints, so that whole turns are never the shorter way."""
    rows = [waypoints[:1]]
    for before, after in pairwise(waypoints):
        count = int(np.ceil(np.abs(after - before).max() / _MAX_WAYPOINT_STEP))
        fractions = np.arange(1, max(count, 1) + 1)[:, None] / max(count, 1)
        rows.append(before + fractions * (after - before))
    return np.concatenate(rows)
