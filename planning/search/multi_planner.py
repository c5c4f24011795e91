"""Race: all attempts, by one planner or by several in turn, and the best of what they find.

One planner may take all the time that there is. Of several none may, since another one may be
quick where it is stuck: each attempt ends when it has checked a number of states without a
solution, and if all have, everybody begins anew with four times as many, unless the task itself
says how many. Counts and not seconds decide, so that the same seed gives the same path on any
machine.
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

# What an attempt of several planners may check in the first round, and by how much more later.
_FIRST_STATES = 20_000
_MORE = 4


def solve_concurrently(
    query: Query, closeness: CheckResolution, task: SearchTask, tally: SearchStatistics
) -> None:
    """Make every attempt, or as many as there is time for, and keep the best path in the tally.

    Raises:
        Canceled: The end was asked for.
        DeadlineExceeded: The time has run out.
    """
    seeds = np.random.SeedSequence(task.seed)
    # What planners improve by other objectives is no length.
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
