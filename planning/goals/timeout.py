"""What there is to say once the time for goals has run out and nothing is found."""

from planning.domain.goals.funnel import funnel_evidence
from planning.domain.request.deadline import Deadline
from planning.errors import DeadlineExceeded
from planning.goals.diagnosis.collision_tally import count_collisions
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_search import PoseSearch
from planning.world.world import World


def check_time(world: World, query: GoalQuery, search: PoseSearch, deadline: Deadline) -> None:
    """Go on only if there is time to say why a search found nothing.

    Raises:
        DeadlineExceeded: There is none; evidence has the funnel so far.
        Canceled: The end was asked for.
    """
    try:
        deadline.check("goals")
    except DeadlineExceeded as error:
        tally = count_collisions(world, query, search.colliding[: query.num_measured], deadline)
        funnel = funnel_evidence(search.funnel(tally.summary))
        most = query.options.max_trials
        message = f"{error.detail}, after {funnel['tried']} of {most} trials: {funnel['summary']}"
        evidence = {"funnel": funnel, "max_trials": most, "cut_short": True}
        raise error.saying(message, evidence) from error
