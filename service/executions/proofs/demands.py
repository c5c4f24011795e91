"""What a motion that is carried out keeps: what its plan was asked for, or its own request."""

from service.plans.models.request import PlanRequest
from service.trajectories.demands import MotionDemands, demands_of, options_of
from service.trajectories.models import CertifyMotionRequest


def kept_by(
    planned: PlanRequest | None, own: CertifyMotionRequest | None
) -> tuple[str, MotionDemands]:
    """Return the group that moves, and what its motion keeps.

    Args:
        planned: Request of the plan that it is of.
        own: The request, if it is a motion of one's own.
    """
    if own is not None:
        return own.group, demands_of(own, options_of(own, limit_jerk=own.limit_jerk))
    if planned is None:
        message = "a motion is a plan's or the client's own"
        raise AssertionError(message)
    problem = planned.to_domain()
    return problem.group, {
        "options": problem.retime,
        "constraints": problem.constraints,
        "margin": problem.margin,
    }
