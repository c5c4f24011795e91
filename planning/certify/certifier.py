"""Certifier: `certify` runs every check on one trajectory and returns the certificate."""

from collections.abc import Callable
from dataclasses import replace

from planning.certify.clearance.clearance_check import check_clearance
from planning.certify.clearance.clearance_reserve import robustness
from planning.certify.clearance.clearance_result import ClearanceResult
from planning.certify.clearance.nearest_points import nearest_points
from planning.certify.constraint_checks import constraint_checks
from planning.certify.end_checks import continuity_checks, goal_check, rest_check, start_check
from planning.certify.form_check import form_check
from planning.certify.frames.line_check import line_checks
from planning.certify.frames.tool_checks import tool_checks
from planning.certify.joints.limit_checks import position_check, rate_check
from planning.certify.request import CertifyRequest
from planning.certify.sampled.drake_term_checks import drake_term_checks
from planning.certify.steering_check import steering_checks
from planning.certify.stopping.stop_check import stop_check
from planning.certify.torque.torque_check import torque_check
from planning.domain.report.certificate import Certificate, Check
from planning.domain.report.stage_reports import CertifyReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import CertifyOptions
from planning.errors import DeadlineExceeded
from planning.world.collision.unchecked_pairs import unchecked_pairs
from planning.world.drake_model import DrakeModel

__all__ = ["CertifyRequest", "certify", "certify_polyline"]


def certify(
    model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> tuple[Certificate, CertifyReport]:
    """Check a trajectory against limits, end conditions and margins on its whole interval.

    A malformed trajectory (NaN, times that do not increase) fails its `form` check, and no other
    check is run; no error is raised.

    Args:
        model: The scene; the checks use contexts of their own.
        request: The trajectory and its bounds.
        deadline: Time limit.

    Returns:
        The certificate, `proven` or with failed checks, and the report of the work done. If the
        `form` check fails, both clearances are NaN.

    Raises:
        DeadlineExceeded: Time ran out before the verdict.
        Canceled: The caller canceled.
        ModelInvalid: The scene has a shape or joint of a kind that cannot be certified.
    """
    return _certify(model, request, deadline, motion_checks)


def certify_polyline(
    model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> tuple[Certificate, CertifyReport]:
    """Check a polyline motion (straight segments with corners) as far as corners allow.

    All checks are run but those that `skipped_checks` names. Arguments and results are those of
    `certify`.

    Raises:
        DeadlineExceeded: Time ran out before the verdict.
        Canceled: The caller canceled.
        ModelInvalid: The scene has a shape or joint of a kind that cannot be certified.
    """
    return _certify(model, without_smoothness_limits(request), deadline, polyline_checks)


def without_smoothness_limits(request: CertifyRequest) -> CertifyRequest:
    """Return the request without the limits that a motion with corners cannot keep."""
    limits = tuple(replace(limit, acceleration=None) for limit in request.tool_limits)
    return replace(
        request,
        jerk=False,
        effort=False,
        acceleration_bounds={},
        tool_limits=tuple(limit for limit in limits if limit.speed is not None),
        options=CertifyOptions(),
    )


def skipped_checks(request: CertifyRequest) -> tuple[str, ...]:
    """Return the names of the checks that `certify_polyline` leaves out."""
    requested = [
        ("jerk", request.jerk),
        ("acceleration continuity", request.jerk),
        ("torque", request.effort),
        ("stop", request.options.bounds_stops),
        *(
            (f"tool_acceleration {limit.frame}", limit.acceleration is not None)
            for limit in request.tool_limits
        ),
    ]
    always = ("rest", "velocity continuity", "acceleration")
    return (*always, *(name for name, is_requested in requested if is_requested))


def _certify(
    model: DrakeModel,
    request: CertifyRequest,
    deadline: Deadline,
    trajectory_checks: Callable[[CertifyRequest], list[Check]],
) -> tuple[Certificate, CertifyReport]:
    deadline.check("certify")
    form = form_check(request)
    if not form.passed:
        return _malformed_certificate(form), CertifyReport(0, 0)
    additional = additional_checks(model, request, deadline)
    clearance = check_clearance(model, request, deadline)
    checks = (form, *trajectory_checks(request), *additional, clearance.check)
    report = CertifyReport(clearance.num_segments, clearance.num_queries)
    if all(check.passed for check in checks):
        stop, report = _optional_results(model, request, report, deadline)
        checks += stop
    return _certificate(model, request, checks, clearance), report


def _malformed_certificate(form: Check) -> Certificate:
    return Certificate(
        proven=False,
        min_clearance=float("nan"),
        observed_clearance=float("nan"),
        pair=("", ""),
        time=0.0,
        checks=(form,),
    )


def _optional_results(
    model: DrakeModel, request: CertifyRequest, report: CertifyReport, deadline: Deadline
) -> tuple[tuple[Check, ...], CertifyReport]:
    """Return the check of stops, if requested, and the report with all requested findings.

    Findings that are not requirements are left out once the time has run out: the motion is proven
    without them.

    Raises:
        DeadlineExceeded: Time ran out before a verdict on stops whose duration is limited.
        Canceled: The caller canceled.
    """
    options = request.options
    checks: tuple[Check, ...] = ()
    try:
        if options.bounds_stops:
            check, stop = stop_check(model, request, deadline)
            checks, report = (check,), replace(report, stop=stop)
        if options.robustness:
            report = replace(report, robustness=robustness(model, request, deadline))
    except DeadlineExceeded:
        if options.max_stopping_time is not None and not checks:
            raise
    return checks, report


def motion_checks(request: CertifyRequest) -> list[Check]:
    """Return the checks that need the trajectory alone: ends, continuity, joint limits."""
    rates = [("velocity", 1), ("acceleration", 2)] + ([("jerk", 3)] if request.jerk else [])
    return [
        start_check(request),
        goal_check(request),
        rest_check(request),
        *continuity_checks(request),
        position_check(request),
        *(rate_check(request, name, order) for name, order in rates),
    ]


def polyline_checks(request: CertifyRequest) -> list[Check]:
    """Return those of the `motion_checks` that a motion with corners can pass."""
    return [
        start_check(request),
        goal_check(request),
        continuity_checks(request)[0],
        position_check(request),
        rate_check(request, "velocity", 1),
    ]


def additional_checks(
    model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> tuple[Check, ...]:
    """Return the checks of requested constraints other than joint limits and clearance.

    These are steering, torques, tool limits, path constraints, straight tool lines and the terms of
    library users.

    Raises:
        DeadlineExceeded: Time ran out before the verdict.
        Canceled: The caller canceled.
        ModelInvalid: The scene has a joint of a kind that cannot be certified.
    """
    constraints = constraint_checks(model, request, deadline)
    lines = line_checks(model, request, deadline)
    torque = [torque_check(model, request, deadline)] if request.effort else []
    steering = steering_checks(request)
    tools = tool_checks(model, request, deadline)
    terms = drake_term_checks(model, request)
    return (*steering, *torque, *tools, *constraints, *lines, *terms)


def _certificate(
    model: DrakeModel,
    request: CertifyRequest,
    checks: tuple[Check, ...],
    clearance: ClearanceResult,
) -> Certificate:
    nearest, check = clearance.nearest, clearance.check
    points, observed = nearest_points(model, request, nearest)
    lower_bound = nearest.distance - check.resolution if check.passed else observed
    return Certificate(
        proven=all(check.passed for check in checks),
        min_clearance=lower_bound,
        observed_clearance=max(observed, lower_bound),
        pair=nearest.bodies,
        time=nearest.time,
        checks=checks,
        points=points,
        proven_until=request.trajectory.duration if clearance.check.passed else 0.0,
        unchecked=unchecked_pairs(model),
    )
