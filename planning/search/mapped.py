"""A path by a roadmap, before any planner is asked."""

from planning.domain.roadmap import Roadmap
from planning.domain.search_report import RoadmapReport
from planning.search.attempt import Attempt
from planning.search.graph import exported
from planning.search.query import Query
from planning.search.roadmap_way import Way, way_through
from planning.search.sound import Closeness, SoundPath, coarse_checker, shortened
from planning.search.tally import Tally

NAME = "roadmap"


def ask_roadmap(roadmap: Roadmap, query: Query, closeness: Closeness, tally: Tally) -> None:
    """Put the roadmap's path into the tally, if it has a better one than there is, and what it did.

    Raises:
        Canceled: The end was asked for.
        DeadlineExceeded: The time has run out.
    """
    tally.roadmap = report_of(roadmap, "interrupted")
    way = way_through(roadmap, query, closeness.fine)
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
    """Return what a roadmap is, and why it was of no use; "" if it was."""
    return RoadmapReport(
        digest=roadmap.digest,
        num_states=len(roadmap.states),
        num_edges=len(roadmap.edges),
        num_states_checked=roadmap.num_states_checked,
        used=not reason,
        reason=reason,
    )


def _sound(way: Way, query: Query, closeness: Closeness, tally: Tally) -> SoundPath | None:
    coarse = coarse_checker(query, closeness.resolution)
    found = Attempt("", way.waypoints, way.goal_row, {}, None, is_spent=False)
    path = shortened(query, found, coarse, closeness)
    tally.num_motions += coarse.num_motions
    return path
