"""Plans and certificates of the domain as JSON."""

from collections.abc import Sequence
from typing import Any

from planning.domain.report.certificate import Certificate
from planning.domain.report.motion_plan import MotionPlan
from service.plans.models import result
from service.plans.models.trajectory import Trajectory


def plan_wire(plan: MotionPlan, trajectory: Trajectory, cuts: Sequence[str] = ()) -> dict[str, Any]:
    """Return the `result` of a job."""
    return result.PlanResult.from_domain(plan, trajectory, cuts).model_dump()


def certificate_wire(certificate: Certificate) -> dict[str, Any]:
    """Return a certificate as JSON."""
    return result.Certificate.from_domain(certificate).model_dump()
