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
_FIRST_STATES = 20_000
_MORE = 4


def solve_concurrently(
    query: Query, closeness: CheckResolution, task: SearchTask, tally: SearchStatistics
) -> None:
    """Run rounds of attempts until one has a path; keep the best path in the search statistics.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    seeds = np.random.SeedSequence(task.seed)
    # Costs of other objectives than the length are no lengths to report.
    tell = task.on_best if query.objective.is_length else None
    on_better = None if tell is None else partial(tally.hear, tell)
    is_alone = len(query.options.planners) == 1
    is_bounded = math.isfinite(task.most_states)
    states = task.most_states if is_alone or is_bounded else _FIRST_STATES
    while True:
        tally.num_spent = 0
        limited = replace(query, most_states=states, on_better=on_better)
        round_ = seeds.spawn(query.options.num_attempts)
        AttemptSchedule(limited, closeness, round_, tally).play(task.pool)
        if tally.best is not None or not tally.num_spent or is_bounded:
            return
        states *= _MORE
