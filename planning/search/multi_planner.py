"""Multi-planner search: rounds of attempts by one or several planners; best path kept.

A single planner may take all the time that there is. Of several planners none may, since another
one may be quick where the first makes no progress: each attempt ends when it has checked a number
of states without a solution. If all attempts of a round end that way, a new round begins with four
times as many states, unless the task itself sets the number. The budget is in states and not in
seconds, so that the same seed gives the same path on any machine.
"""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from planning.search.attempts import AttemptSchedule
from planning.search.query import Query
from planning.search.request import SearchTask
from planning.search.statistics import SearchStatistics
from planning.search.verified_path import CheckResolution

# States that an attempt of several planners may check in the first round; growth factor per round.
_INITIAL_MAX_CHECKED_STATES = 20_000
_GROWTH_FACTOR = 4


def solve_concurrently(
    query: Query, resolution: CheckResolution, task: SearchTask, statistics: SearchStatistics
) -> None:
    """Run rounds of attempts until one has a path; keep the best path in the search statistics.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    seeds = np.random.SeedSequence(task.seed)
    # Costs of other objectives than the length are no lengths to report.
    report = task.on_best if query.objective.is_length else None
    on_improvement = None if report is None else partial(statistics.report_improvement, report)
    is_alone = len(query.options.planners) == 1
    is_bounded = math.isfinite(task.max_checked_states)
    max_checked_states = (
        task.max_checked_states if is_alone or is_bounded else _INITIAL_MAX_CHECKED_STATES
    )
    while True:
        statistics.num_given_up = 0
        limited_query = replace(
            query, max_checked_states=max_checked_states, on_improvement=on_improvement
        )
        attempt_seeds = seeds.spawn(query.options.num_attempts)
        AttemptSchedule(limited_query, resolution, attempt_seeds, statistics).run_all(task.pool)
        if statistics.best is not None or not statistics.num_given_up or is_bounded:
            return
        max_checked_states *= _GROWTH_FACTOR
