"""find_path(): the search of one round, at a finer resolution each time."""

from dataclasses import replace

import numpy as np

from planning.domain.report.motion_plan import Progress
from planning.domain.request.deadline import Deadline
from planning.errors import Canceled, DeadlineExceeded, NoPathFound
from planning.pipeline.constrained_search import search_constrained
from planning.pipeline.context import SEARCH_FRACTION, PlanContext
from planning.pipeline.gcs_planner import make_gcs_planner
from planning.search.roadmap.query_roadmap import make_roadmap_report
from planning.search.solver import SearchResult, SearchTask, search
from planning.world.collision.obstacle_distance import obstacle_distances
from planning.world.collision.search_padding import endpoint_padding

# Rounds that query the roadmap; if none of its paths is proven, a planner finds another one.
_MAX_ROADMAP_ROUNDS = 3
# Share of the time for the search with padding, which keeps more than the required margins.
_PADDED_TIME_FRACTION = 0.6
# Time for the search of a canceled plan whose best path so far was not proven [s].
_CANCELED_SEARCH_TIME = 0.4


def find_path(context: PlanContext, round_: int) -> SearchResult:
    """Return a collision-free path from the start to one of the goals.

    Args:
        context: Start, goals and margins.
        round_: Number of the round, from 0; every round halves the resolution and uses another
            seed.

    Raises:
        NoPathFound: No planner found one.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    context.report_progress(Progress("search", SEARCH_FRACTION, f"searching, round {round_ + 1}"))
    with context.watch.stage("search"):
        return _search(context, 0) if round_ == 0 else _search_again(context, round_)


def _search_again(context: PlanContext, round_: int) -> SearchResult:
    """Search at a finer resolution; one short attempt if a canceled plan returns its best."""
    wants_best = context.problem.search.on_cancel == "best"
    if not (wants_best and context.deadline.is_canceled()):
        try:
            return _search(context, round_)
        except Canceled:
            if not wants_best:
                raise
    one_attempt = replace(context.problem.search, attempts=1)
    short_deadline = context.deadline.uncancelable.within(_CANCELED_SEARCH_TIME)
    short_context = replace(
        context, problem=replace(context.problem, search=one_attempt), deadline=short_deadline
    )
    result = _search(short_context, round_)
    return replace(result, report=replace(result.report, was_canceled=True))


def _search(context: PlanContext, round_: int) -> SearchResult:
    """Search with padding beyond the margins; without it if no path is found with it."""
    padding = endpoint_padding(
        context.world, context.group, context.start, context.goals.entries, context.problem.margin
    )
    if padding > 0:
        try:
            return _search_padded(
                context, round_, padding, context.deadline.at_fraction(_PADDED_TIME_FRACTION)
            )
        except (NoPathFound, DeadlineExceeded):
            context.deadline.check("search")
    return _search_padded(context, round_, 0.0, context.deadline)


def _search_padded(
    context: PlanContext, round_: int, padding: float, deadline: Deadline
) -> SearchResult:
    margins = context.world.margins(context.problem.margin, padding)
    oracle = context.world.collision_oracle(context.group, margins)
    entries = context.goals.entries
    rows = np.flatnonzero(oracle.are_free(entries))
    gcs_planner = make_gcs_planner(context, round_)
    task = SearchTask(
        start=context.start,
        goals=entries[rows],
        options=context.problem.search if gcs_planner is None else gcs_planner.options,
        resolution=context.problem.search.resolution / 2**round_,
        padding=padding,
        seed=context.problem.seed + round_,
        clearances=obstacle_distances(context.world, context.group),
        on_best=context.report_best,
        guide=gcs_planner,
        pool=context.pool,
        roadmap=context.roadmap if round_ < _MAX_ROADMAP_ROUNDS else None,
    )
    if context.constraints is None:
        result = search(context.group, context.limits, oracle, task, deadline, watch=context.watch)
    else:
        result = search_constrained(
            context.constraints, context.limits, oracle, task, deadline, context.watch
        )
    if context.roadmap is not None and task.roadmap is None:
        roadmap_report = make_roadmap_report(context.roadmap, "not_proven")
        result = replace(result, report=replace(result.report, roadmap=roadmap_report))
    report = (
        result.report if gcs_planner is None else gcs_planner.with_regions_report(result.report)
    )
    return SearchResult(result.path.continuous, int(rows[result.goal_row]), report, result.graph)
