"""Predicate goals: goal configurations that a user-supplied function accepts."""

from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

from planning.domain.arrays import Array, Flags
from planning.domain.goals.funnel import funnel_evidence
from planning.domain.goals.goal import GoalPredicate
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.request.deadline import Deadline
from planning.errors import GoalUnreachable
from planning.goals.diagnosis.collision_tally import count_collisions
from planning.goals.diagnosis.goal_failure import collision_failure
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_search import PoseSearch
from planning.goals.joint_metric import JointMetric
from planning.goals.ranking import nearest_first
from planning.goals.targets.target_samples import TargetSamples
from planning.goals.timeout import check_time
from planning.world.loading.positions import validate_positions
from planning.world.world import World


class PredicateSolver:
    """Pose solver whose solutions are seeds, or draws of the goal, that the predicate accepts."""

    batch_size = 1

    def __init__(self, query: GoalQuery, goal: GoalPredicate, rng: np.random.Generator) -> None:
        """Prepare for a predicate goal; `rng` feeds its `draw` function."""
        self._query = query
        self._goal = goal
        self._rng = rng

    def solve(
        self,
        seeds: Float64[np.ndarray, "n nq"],
        targets: Int64[np.ndarray, " n"],
        num_required: int,
    ) -> tuple[Flags, Array]:
        """Return as `PoseSolver.solve` whether the predicate accepts each row, and the rows."""
        del targets, num_required
        draw = self._goal.draw
        rows = (
            seeds
            if draw is None
            else np.stack([self._validate_sample(draw(self._rng)) for _ in seeds])
        )
        accepted = [bool(self._goal.accepts(np.array(q))) for q in rows]
        return np.array(accepted, dtype=bool), rows

    def _validate_sample(self, sample: Any) -> Array:
        return np.array(validate_positions(self._query.group, sample, "goal.draw"))


def find_predicate_goals(
    world: World,
    query: GoalQuery,
    goal: GoalPredicate,
    rng: np.random.Generator,
    deadline: Deadline,
) -> GoalConfigurations:
    """Return free configurations that the predicate accepts, nearest to the start first.

    The funnel counts accepted configurations as converged. If no free one satisfies the query's
    path constraints, free ones without the constraints are returned, so that a diagnosis can name
    the violated constraints.

    Raises:
        GoalUnreachable: The predicate accepts none, or none within limits, of `max_trials`.
        GoalInCollision: All accepted configurations collide.
        GoalTooNear: All accepted configurations violate margins, and not all collide.
        ProblemInvalid: `draw` returns no configuration of the group.
        DeadlineExceeded: Time ran out before a configuration was found.
        Canceled: Cancellation was requested.
    """
    options = query.options
    metric = JointMetric.from_names(query.group, options.joint_weights)
    search = PoseSearch(world, query, rng, deadline)
    samples = TargetSamples([], np.zeros(1, dtype=np.int64), 1)
    search.run(samples, PredicateSolver(query, goal, rng), options.max_trials)
    funnel = search.funnel(
        count_collisions(world, query, search.colliding, query.num_measured, deadline).summary
    )
    rows = search.solutions.rows
    if len(rows):
        nearest = nearest_first(metric, query.start, rows, search.solutions.targets, len(rows))
        return GoalConfigurations(*nearest, funnel)
    check_time(world, query, search, deadline)
    if query.constraints is not None and funnel.collision_free > 0:
        return find_predicate_goals(world, replace(query, constraints=None), goal, rng, deadline)
    if search.colliding:
        raise collision_failure(world, query, search, deadline)
    message = (
        f"the predicate accepts none of {funnel.num_samples} configurations of {query.group.name} "
        "within its limits"
    )
    raise GoalUnreachable(message, {"funnel": funnel_evidence(funnel)})
