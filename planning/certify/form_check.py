"""Form check: whether the numbers of a certify request are a well-formed trajectory."""

from collections.abc import Iterable

import numpy as np

from planning.certify.intervals.rounding import LOW_DEGREE
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check

# Largest error of the length of a unit quaternion.
_UNIT_TOLERANCE = 1e-9
# Largest magnitude of any number: larger ones lose the digits that the proof needs.
_MAX_MAGNITUDE = 1e9
# Largest rounding error: of positions [rad or m, relative above 1], and of rates relative to their
# limits, or to the rates themselves where those are larger.
_MAX_ROUNDING_ERROR = 1e-7


def form_check(request: CertifyRequest) -> Check:
    """Return the check of the number of faults in the request; all other checks require zero.

    Without faults, array shapes fit the group, every number is finite and within `_MAX_MAGNITUDE`,
    times increase from 0, quaternions are of unit length, limits are positive, there is a goal, and
    the polynomials can be evaluated in double precision.
    """
    faults: list[str] = []
    for find in (_shape_faults, _number_faults, _size_faults, _rounding_faults):
        faults = faults or find(request)
    return Check("form", float(len(faults)), 0.0, "faults", 0.0, not faults, "; ".join(faults))


def _shape_faults(request: CertifyRequest) -> list[str]:
    curve, limits, group = request.trajectory, request.limits, request.group
    faults: list[str] = []
    if curve.joints != group.joints:
        faults.append("the trajectory's joints are not the group's")
    n, terms = len(curve.bases), max(1, *curve.coefficients.shape[1:2])
    nq, nv, blocks = group.num_positions, group.num_velocities, len(group.blocks)
    expected_shapes = [
        ("breaks", curve.breaks, (n + 1,)),
        ("bases", curve.bases, (n, nq)),
        ("coefficients", curve.coefficients, (n, terms, nv)),
        *((name, q, (nq,)) for name, q in _start_configurations(request)),
        ("goals", request.goals, (max(1, len(request.goals)), nq)),
        ("state", request.state, (max(nq, request.state.size),)),
        *((name, getattr(limits, name), (nq,)) for name in ("lower", "upper")),
        *((name, getattr(limits, name), (blocks,)) for name in _limited_rates(request)),
    ]
    faults += [
        f"{name} has shape {array.shape}, not {shape}"
        for name, array, shape in expected_shapes
        if array.shape != shape
    ]
    return faults if n else [*faults, "the trajectory has no pieces"]


def _start_configurations(request: CertifyRequest) -> list[tuple[str, Array]]:
    """Return the names and values of the start, and of the origin if there is one."""
    origin = [] if request.origin is None else [("origin", request.origin)]
    return [("start", request.start), *origin]


def _number_faults(request: CertifyRequest) -> list[str]:
    curve, limits = request.trajectory, request.limits
    arrays = [
        ("breaks", curve.breaks),
        ("bases", curve.bases),
        ("coefficients", curve.coefficients),
        *_start_configurations(request),
        ("goals", request.goals),
        ("state", request.state),
    ]
    faults: list[str] = []
    if not _are_finite(_concatenated(array for _, array in arrays)):
        faults += [
            f"{name}: some numbers are not finite"
            for name, array in arrays
            if not _are_finite(array)
        ]
    if np.isnan(limits.lower).any() or np.isnan(limits.upper).any():
        faults.append("a position limit is NaN")
    faults += [
        f"{name} limits: some are not positive"
        for name in _limited_rates(request)
        if not (getattr(limits, name) > 0).all()
    ]
    return faults


def _size_faults(request: CertifyRequest) -> list[str]:
    curve = request.trajectory
    faults: list[str] = []
    if not (curve.breaks[0] == 0 and (curve.widths > 0).all()):
        return ["times do not increase from 0"]
    origin = [] if request.origin is None else [request.origin]
    configurations = [curve.bases, request.start, *origin, request.goals]
    numbers = _concatenated([*configurations, *request.max_magnitudes])
    if not np.abs(numbers).max() <= _MAX_MAGNITUDE:
        faults.append(
            f"a position, velocity, acceleration or jerk is larger than {_MAX_MAGNITUDE:g}"
        )
    if any(_unit_fault(request, q) for q in configurations):
        faults.append("a quaternion is not of unit length")
    return faults


def _rounding_faults(request: CertifyRequest) -> list[str]:
    """Return faults for polynomials whose terms cancel, so that rounding errors are too large."""
    faults: list[str] = []
    if request.trajectory.coefficients.shape[1] <= LOW_DEGREE + 1:
        return faults
    names = ("position", *_limited_rates(request))
    for order, (error, size) in enumerate(
        zip(request.rounding_errors, request.max_magnitudes, strict=True)
    ):
        if (error <= _MAX_ROUNDING_ERROR * size).all():
            continue
        allowed = _MAX_ROUNDING_ERROR * np.maximum(size, _scales(request, order))
        worst = int(np.argmax(error / allowed))
        if error[worst] > allowed[worst]:
            faults.append(
                f"the rounding error of the {names[order]} of "
                f"{request.group.velocity_names[worst]} may reach {error[worst]:.2g}: terms up to "
                f"degree {request.trajectory.coefficients.shape[1] - 1} cancel each other; give "
                "shorter pieces, or polynomials of lower degree"
            )
    return faults


def _scales(request: CertifyRequest, order: int) -> Array:
    """Return the reference sizes for rounding errors: 1 for positions, the limits for rates."""
    scales = np.ones(request.group.num_velocities)
    if order > 0:
        limits = getattr(request.limits_with_followers, _limited_rates(request)[order - 1])
        for (_, indices), limit in zip(request.group.blocks, limits, strict=True):
            scales[list(indices)] = limit if np.isfinite(limit) else 1.0
    return scales


def _limited_rates(request: CertifyRequest) -> tuple[str, ...]:
    """Return the names of the rate limits that the request has."""
    return ("velocity", "acceleration", "jerk") if request.jerk else ("velocity", "acceleration")


def _concatenated(arrays: Iterable[Array]) -> Array:
    """Return all numbers of some arrays in one array."""
    return np.concatenate([array.ravel() for array in arrays])


def _are_finite(array: Array) -> bool:
    return bool(np.isfinite(array).all())


def _unit_fault(request: CertifyRequest, q: Array) -> bool:
    """Return whether some quaternion is not of unit length."""
    if request.trajectory.manifold.is_flat:
        return False
    q = np.atleast_2d(q)
    begin = 0
    for joint in request.group.joints:
        if joint.num_positions == 7:
            lengths = np.linalg.norm(q[:, begin : begin + 4], axis=1)
            if not (np.abs(lengths - 1) <= _UNIT_TOLERANCE).all():
                return True
        begin += joint.num_positions
    return False
