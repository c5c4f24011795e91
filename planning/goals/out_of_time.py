"""What there is to say once the time for goals has run out and nothing is found."""

from planning.domain.deadline import Deadline
from planning.domain.funnel import funnel_evidence
from planning.errors import DeadlineExceeded
from planning.goals.goal_query import GoalQuery
from planning.goals.pose_search import PoseSearch
from planning.goals.tally import tallied
from planning.world.world import World


def require_time(world: World, query: GoalQuery, search: PoseSearch, deadline: Deadline) -> None:
    """Go on only if there is time to say why a search found nothing.

    Raises:
        DeadlineExceeded: There is none; evidence has the funnel so far.
        Canceled: The end was asked for.
    """
    try:
        deadline.check("goals")
    except DeadlineExceeded as error:
        tally = tallied(world, query, search.colliding[: query.num_measured], deadline)
        funnel = funnel_evidence(search.funnel(tally.summary))
        most = query.options.max_trials
        message = f"{error.detail}, after {funnel['tried']} of {most} trials: {funnel['summary']}"
        evidence = {"funnel": funnel, "max_trials": most, "cut_short": True}
        raise error.saying(message, evidence) from error
