"""query_roadmap(): a verified path by a roadmap, before any planner is used."""

from planning.domain.planner.roadmap import Roadmap
from planning.domain.report.search_report import RoadmapReport
from planning.search.ompl.graph import export_graph
from planning.search.ompl.run_planner import Attempt
from planning.search.query import Query
from planning.search.roadmap.shortest_roadmap_path import RoadmapPath, shortest_roadmap_path
from planning.search.statistics import SearchStatistics
from planning.search.verified_path import (
    CheckResolution,
    VerifiedPath,
    coarse_checker,
    shorten_and_verify,
)

NAME = "roadmap"


def query_roadmap(
    roadmap: Roadmap, query: Query, resolution: CheckResolution, statistics: SearchStatistics
) -> None:
    """Record the roadmap's path if it is better than the best so far, and the query's report.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    statistics.roadmap = make_roadmap_report(roadmap, "interrupted")
    roadmap_path = shortest_roadmap_path(roadmap, query, resolution.fine)
    path = None if roadmap_path.reason else _verify(roadmap_path, query, resolution, statistics)
    reason = roadmap_path.reason or ("blocked" if path is None else "")
    if path is not None and statistics.best is not None and statistics.best.cost <= path.cost:
        reason = "straight_line"
    statistics.roadmap = make_roadmap_report(roadmap, reason)
    if path is not None and not reason:
        statistics.best, statistics.best_planner = path, NAME
        if query.options.keep_graph:
            statistics.graph = export_graph(
                NAME, roadmap_path.graph, query.space, roadmap_path.waypoints
            )


def make_roadmap_report(roadmap: Roadmap, reason: str) -> RoadmapReport:
    """Return a roadmap's report with the reason why it was not used; "" if it was."""
    return RoadmapReport(
        digest=roadmap.digest,
        num_states=len(roadmap.states),
        num_edges=len(roadmap.edges),
        num_states_checked=roadmap.num_states_checked,
        used=not reason,
        reason=reason,
    )


def _verify(
    roadmap_path: RoadmapPath,
    query: Query,
    resolution: CheckResolution,
    statistics: SearchStatistics,
) -> VerifiedPath | None:
    coarse = coarse_checker(query, resolution.search_resolution)
    attempt_result = Attempt(
        "", roadmap_path.waypoints, roadmap_path.goal_row, {}, None, has_given_up=False
    )
    path = shorten_and_verify(query, attempt_result, coarse, resolution)
    statistics.num_motions += coarse.num_motions
    return path
