"""query_roadmap(): a verified path by a roadmap, before any planner is used."""

from planning.domain.planner.roadmap import Roadmap
from planning.domain.report.search_report import RoadmapReport
from planning.search.ompl.attempt import Attempt
from planning.search.ompl.graph import exported
from planning.search.query import Query
from planning.search.roadmap.shortest_roadmap_path import RoadmapPath, shortest_roadmap_path
from planning.search.statistics import SearchStatistics
from planning.search.verified_path import CheckResolution, VerifiedPath, coarse_checker, shortened

NAME = "roadmap"


def query_roadmap(
    roadmap: Roadmap, query: Query, closeness: CheckResolution, tally: SearchStatistics
) -> None:
    """Record the roadmap's path if it is better than the best so far, and the query's report.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    tally.roadmap = report_of(roadmap, "interrupted")
    way = shortest_roadmap_path(roadmap, query, closeness.fine)
    path = None if way.reason else _sound(way, query, closeness, tally)
    reason = way.reason or ("blocked" if path is None else "")
    if path is not None and tally.best is not None and tally.best.cost <= path.cost:
        reason = "straight_line"
    tally.roadmap = report_of(roadmap, reason)
    if path is not None and not reason:
        tally.best, tally.winner = path, NAME
        if query.options.keep_graph:
            tally.graph = exported(NAME, way.graph, query.space, way.waypoints)


def report_of(roadmap: Roadmap, reason: str) -> RoadmapReport:
    """Return a roadmap's report with the reason why it was not used; "" if it was."""
    return RoadmapReport(
        digest=roadmap.digest,
        num_states=len(roadmap.states),
        num_edges=len(roadmap.edges),
        num_states_checked=roadmap.num_states_checked,
        used=not reason,
        reason=reason,
    )


def _sound(
    way: RoadmapPath, query: Query, closeness: CheckResolution, tally: SearchStatistics
) -> VerifiedPath | None:
    coarse = coarse_checker(query, closeness.resolution)
    found = Attempt("", way.waypoints, way.goal_row, {}, None, is_spent=False)
    path = shortened(query, found, coarse, closeness)
    tally.num_motions += coarse.num_motions
    return path
