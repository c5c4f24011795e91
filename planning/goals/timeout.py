"""Timeout of the goals stage without a result: the error and its evidence, the search funnel."""

from planning.domain.goals.funnel import funnel_evidence
from planning.domain.request.deadline import Deadline
from planning.errors import DeadlineExceeded
from planning.goals.diagnosis.collision_tally import count_collisions
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_search import PoseSearch
from planning.world.world import World


def check_time(world: World, query: GoalQuery, search: PoseSearch, deadline: Deadline) -> None:
    """Check that time is left to diagnose why a search found nothing.

    Raises:
        DeadlineExceeded: The time ran out; the evidence has the funnel so far.
        Canceled: Cancellation was requested.
    """
    try:
        deadline.check("goals")
    except DeadlineExceeded as error:
        tally = count_collisions(world, query, search.colliding, query.num_measured, deadline)
        funnel = funnel_evidence(search.funnel(tally.summary))
        max_trials = query.options.max_trials
        message = (
            f"{error.detail}, after {funnel['tried']} of {max_trials} trials: {funnel['summary']}"
        )
        evidence = {"funnel": funnel, "max_trials": max_trials, "cut_short": True}
        raise error.saying(message, evidence) from error
