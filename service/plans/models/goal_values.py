"""Poses, goals and problems: from JSON to the domain."""

from planning.domain.geometry import pose as geometry
from planning.domain.goals import goal as domain
from planning.domain.goals.linear_moves import Displacement
from planning.domain.request.options import CertifyOptions, IkOptions, RetimeOptions
from planning.domain.request.problem import PlanningProblem
from service.api.models import Pose
from service.plans.models.goals import Goal, PoseGoal, RegionGoal, RelativeGoal
from service.plans.models.ik import Ik
from service.plans.models.line_goals import LineTarget
from service.plans.models.request import Certify, PlanRequest, Retime


def pose_of(pose: geometry.Pose) -> Pose:
    """Return the model of a pose in world, which is not validated again."""
    position, quaternion = pose.position.tolist(), pose.quaternion.tolist()
    return Pose.model_construct(position=position, quaternion=quaternion)


def pose_wire(pose: geometry.Pose) -> dict[str, object]:
    """Return a pose in world as JSON."""
    return Pose.from_domain(pose).model_dump(exclude={"rpy"})


def line_end_value(end: LineTarget) -> domain.PoseTarget | Displacement:
    """Return where a line leads."""
    return end.to_target()


def reach_goal_value(goal: PoseGoal | RegionGoal | RelativeGoal) -> domain.ReachGoal:
    """Return the domain's goal of a tool frame."""
    return goal.to_domain()


def goal_value(goal: Goal) -> domain.Goal:
    """Return the domain's goal."""
    return goal.to_domain()


def ik_value(ik: Ik) -> IkOptions:
    """Return the domain's IK options."""
    return ik.to_domain()


def retime_value(retime: Retime) -> RetimeOptions:
    """Return the domain's options of the timing."""
    return retime.to_domain()


def certify_value(certify: Certify) -> CertifyOptions:
    """Return the domain's options of the proof."""
    return certify.to_domain()


def problem_value(request: PlanRequest) -> PlanningProblem:
    """Return the domain's problem."""
    return request.to_domain()
