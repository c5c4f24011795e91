"""Why a pose goal has no configuration: none reaches it, or all that do collide."""

import numpy as np

from planning.domain.report import Funnel
from planning.errors import ApproachBlocked, GoalInCollision, GoalUnreachable
from planning.goals.goal_query import GoalQuery
from planning.goals.nearest import nearest_pose
from planning.goals.pose_search import PoseSearch
from planning.goals.tally import funnel_evidence, tallied
from planning.goals.tool_target import ToolTarget
from planning.world.world import World

# So many of the configurations that collide are measured for the evidence.
_LOOKED_AT = 256


def refusal(
    world: World,
    query: GoalQuery,
    targets: list[ToolTarget],
    search: PoseSearch,
    rng: np.random.Generator,
) -> ApproachBlocked | GoalInCollision | GoalUnreachable:
    """Return what the funnel says: unreachable, reachable only in collision, or by no line."""
    if search.funnel(()).collision_free > 0:
        return _blocked(search.funnel(()))
    tally = tallied(world, query, search.colliding[:_LOOKED_AT])
    funnel = search.funnel(tally.summary)
    if funnel.within_limits > 0:
        words = ", ".join(
            f"{tally.count} hit {'-'.join(tally.bodies)} by {1000 * tally.min_depth:.1f} to "
            f"{1000 * tally.max_depth:.1f} mm"
            for tally in funnel.rejected_by[:3]
        )
        message = f"all {funnel.within_limits} configurations that reach the goal collide: "
        return GoalInCollision(message + words, {"funnel": funnel_evidence(funnel)})
    near = min(
        (nearest_pose(world, query.group, target, query.start, rng) for target in targets),
        key=lambda found: found.translation_error + 0.1 * found.rotation_error,
    )
    message = (
        f"no configuration of {query.group.name} brings {targets[0].frame} to the goal; "
        f"the nearest pose is {1000 * near.translation_error:.1f} mm and "
        f"{np.degrees(near.rotation_error):.2f} deg away"
    )
    nearest = {
        "position": near.pose.position.tolist(),
        "quaternion": near.pose.quaternion.tolist(),
        "positions": near.positions.tolist(),
        "translation_error": near.translation_error,
        "rotation_error": near.rotation_error,
    }
    return GoalUnreachable(message, {"funnel": funnel_evidence(funnel), "nearest": nearest})


def _blocked(funnel: Funnel) -> ApproachBlocked:
    words = ", ".join(
        f"{tally.count} times {tally.reason}{' of ' if tally.where else ''}{tally.where} stops the "
        f"{tally.leg} ({100 * tally.max_fraction:.0f} % of it is free at best)"
        for tally in funnel.blocked_by[:3]
    )
    message = f"no goal configuration has a free approach and retreat: {words}"
    return ApproachBlocked(message, {"funnel": funnel_evidence(funnel)})
