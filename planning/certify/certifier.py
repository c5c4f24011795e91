"""certify(): every check on one trajectory, and the verdict."""

from planning.certify.clearance import Clearance, check_clearance
from planning.certify.end_checks import (
    continuity_checks,
    form_check,
    goal_check,
    rest_check,
    start_check,
)
from planning.certify.limit_checks import position_check, rate_check
from planning.certify.request import CertifyRequest
from planning.domain.certificate import Certificate, Check
from planning.domain.deadline import Deadline
from planning.domain.report import CertifyReport
from planning.world.drake_model import DrakeModel

__all__ = ["CertifyRequest", "certify"]


def certify(
    model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> tuple[Certificate, CertifyReport]:
    """Hold a trajectory against limits, ends and margins, on its whole interval.

    A trajectory that is no trajectory (NaN, times that do not increase) fails its `form` check;
    it raises nothing. Clearance is looked at only if all else holds: it costs most.

    Args:
        model: The scene; a fresh context of it is made here.
        request: The trajectory and its bounds.
        deadline: When to stop.

    Returns:
        The certificate, `proven` or with failed checks, and what it took.

    Raises:
        DeadlineExceeded: Time ran out before the verdict.
        Canceled: Somebody asked for the end.
    """
    form = form_check(request)
    if not form.passed:
        return _verdict([form], None)
    checks = [form, start_check(request), goal_check(request), rest_check(request)]
    checks += continuity_checks(request)
    checks.append(position_check(request))
    rates = [("velocity", 1), ("acceleration", 2)] + ([("jerk", 3)] if request.jerk else [])
    checks += [rate_check(request, name, order) for name, order in rates]
    if not all(check.passed for check in checks):
        return _verdict(checks, None)
    return _verdict(checks, check_clearance(model, request, deadline))


def _verdict(checks: list[Check], clearance: Clearance | None) -> tuple[Certificate, CertifyReport]:
    if clearance is None:
        certificate = Certificate(False, float("nan"), ("", ""), 0.0, tuple(checks))  # noqa: FBT003
        return certificate, CertifyReport(0, 0)
    every = (*checks, clearance.check)
    certificate = Certificate(
        proven=all(check.passed for check in every),
        min_clearance=clearance.min_clearance,
        pair=clearance.pair,
        time=clearance.time,
        checks=every,
    )
    return certificate, CertifyReport(clearance.intervals, clearance.queries)
