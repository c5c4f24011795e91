"""Steering check: whether a base moves as a car can drive, from the trajectory's polynomials.

With p = (x, y) and psi the yaw, v_x and v_y in the base's frame are p' rotated by -psi. The proven
inequalities, on every piece as a whole:

    sideways    v_y^2 <= epsilon^2 |p'|^2
    curvature   (r psi')^2 <= (1 + delta)^2 v_x^2
    reverse     v_x >= 0, unless the car drives backwards

All but the sine and the cosine are polynomials. Pieces are halved until psi = psi_m + eta with
|eta| at most 1/8; then Taylor's series 1 - eta^2 / 2 + eta^4 / 24 and eta - eta^3 / 6 have a total
error below 3e-7, for which the first bound has a reserve. Both sides are homogeneous in speed, so
that slow and fast motion meet the same condition. Close to rest speeds are rounding errors: speeds
up to a tolerance (`_neglected_speeds`) are neglected. Over the whole motion the neglected distance
is less than a micrometre, however long the motion takes: sideways, backwards, and along the rim of
the tightest turn. The rounding error of speeds is subtracted from the tolerance; where the error is
larger, nothing is proven.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals import bernstein
from planning.certify.intervals.bernstein_products import elevate_degree, multiply
from planning.certify.intervals.rounding import tight_rounding_bounds
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check
from planning.domain.robot.steering import Steering, steering_of

# epsilon, the tangent of the angle of slip, and delta.
SLIP_TOLERANCE, CURVATURE_TOLERANCE = 1e-5, 1e-4
# Error of the Taylor polynomials of sine and cosine, subtracted from the tolerance of slip.
_TAYLOR_ERROR = 3e-7
_MAX_YAW_CHANGE = 0.125
_MAX_HALVINGS, _MAX_NODES = 16, 100_000
# Neglected speeds: at most this sideways and backwards, and this along a turn [m/s], and less if
# they add up to more than this distance over the whole motion [m].
_NEGLECTED_SLIP_SPEED, _NEGLECTED_TURN_SPEED, _NEGLECTED_DISTANCE = 1e-9, 1e-6, 1e-6
# Fractions of each piece at which speeds are compared for the reported value.
_SAMPLE_FRACTIONS = np.array([0.1, 0.35, 0.65, 0.9])


def steering_checks(request: CertifyRequest) -> list[Check]:
    """Return a check for every base of the group with car-like steering.

    The value is the largest sampled utilization of the allowed slip, or of the allowed curvature 1
    / turning radius. The true one is at most the resolution larger.
    """
    checks: list[Check] = []
    cars = steering_of(request.group)
    iq = iv = 0
    for joint in request.group.joints:
        steering = cars.get(joint.name)
        if steering is not None:
            checks.append(_check(f"steering {joint.name}", request, (iq, iv), steering))
        iq += joint.num_positions
        iv += joint.num_velocities
    return checks


def _check(name: str, request: CertifyRequest, offsets: tuple[int, int], car: Steering) -> Check:
    bound = 1 + CURVATURE_TOLERANCE
    widths = np.diff(request.trajectory.breaks)
    instants = (request.trajectory.breaks[:-1, None] + _SAMPLE_FRACTIONS * widths[:, None]).ravel()
    value, where, time = _worst_sample(request, offsets, instants, car)
    nodes = _nodes(request, *offsets)
    max_utilization = _max_utilization(request, offsets[1], car)
    neglected_speeds = _neglected_speeds(request.trajectory.duration) - _rounding_errors(
        request, offsets[1], car
    )
    if nodes is None or not (neglected_speeds > 0).all():
        resolution = max(0.0, max_utilization - value)
        return Check(name, value, bound, "1", resolution, passed=False, where="unproven", time=time)
    for kind, excess, tolerance in _excesses(nodes, car, neglected_speeds):
        upper_bound, row, fraction = bernstein.peak(np.ascontiguousarray(excess), tolerance / 2)
        if not upper_bound <= tolerance:
            peak_time = float(nodes.begins[row] + fraction * nodes.widths[row])
            utilization, _, _ = _worst_sample(request, offsets, np.array([peak_time]), car)
            value = max(value, utilization)
            resolution = max(0.0, max_utilization - value)
            return Check(
                name, value, bound, "1", resolution, passed=False, where=kind, time=peak_time
            )
    resolution = max(0.0, bound - value)
    return Check(name, value, bound, "1", resolution, passed=True, where=where, time=time)


def _max_utilization(request: CertifyRequest, iv: int, car: Steering) -> float:
    """Return an upper bound on the utilization of slip and curvature, whatever the motion does.

    Sideways and reverse speeds are at most the speed of the base; its polynomials bound the yaw
    rate.
    """
    yaw_rate = float(np.abs(request.bernstein_forms[1][iv + 2]).max(initial=0.0))
    _, turn_speed = _neglected_speeds(request.trajectory.duration)
    return max(1 / SLIP_TOLERANCE, yaw_rate * car.turning_radius / turn_speed)


def _neglected_speeds(duration: float) -> Float64[np.ndarray, "2"]:
    """Return the neglected speeds: sideways or backwards, and along a turn [m/s]."""
    return np.minimum(
        [_NEGLECTED_SLIP_SPEED, _NEGLECTED_TURN_SPEED], _NEGLECTED_DISTANCE / duration
    )


def _rounding_errors(request: CertifyRequest, iv: int, car: Steering) -> Float64[np.ndarray, "2"]:
    """Bound the rounding errors of speeds sideways or backwards, and along a turn [m/s].

    A yaw error e turns a forward speed v into a sideways speed v e.
    """
    columns, curve = slice(iv, iv + 3), request.trajectory
    speed = float(np.linalg.norm(request.max_magnitudes[1][iv : iv + 2]))
    position_errors, velocity_errors = (
        tight_rounding_bounds(
            request.max_magnitudes[k][columns],
            curve.coefficients[:, :, columns],
            np.diff(curve.breaks),
            k,
        )
        for k in range(2)
    )
    linear_error = float(np.linalg.norm(velocity_errors[:2])) + speed * float(position_errors[2])
    return np.array([
        2 * linear_error,
        car.turning_radius * float(velocity_errors[2]) + 2 * linear_error,
    ])


def _worst_sample(
    request: CertifyRequest, offsets: tuple[int, int], instants: Array, car: Steering
) -> tuple[float, str, float]:
    """Return the largest sampled utilization, its kind (slip or curvature), and its instant [s]."""
    curve, (iq, iv) = request.trajectory, offsets
    yaw = curve.positions(instants)[:, iq + 2]
    x, y, yaw_rate = curve.tangents(instants, 1)[:, iv : iv + 3].T
    c, s = np.cos(yaw), np.sin(yaw)
    forward, sideways = c * x + s * y, c * y - s * x
    speed, (slip_speed, turn_speed) = np.hypot(x, y), _neglected_speeds(curve.duration)
    backward = np.zeros_like(forward) if car.reverse else np.maximum(-forward, 0.0)
    utilizations = {
        "sideways": np.abs(sideways) / (SLIP_TOLERANCE * speed + slip_speed),
        "curvature": np.abs(yaw_rate) * car.turning_radius / (speed + turn_speed),
        "reverse": backward / (SLIP_TOLERANCE * speed + slip_speed),
    }
    where = max(utilizations, key=lambda kind: float(utilizations[kind].max()))
    row = int(np.argmax(utilizations[where]))
    return float(utilizations[where][row]), where, float(instants[row])


@dataclass(frozen=True)
class _Nodes:
    """Parts of pieces on which the yaw changes little, a row for each.

    Attributes:
        begins: First instants [s].
        widths: Durations [s].
        yaw: Middle of the range of the yaw on the part [rad].
        eta: Bernstein coefficients of the yaw minus that middle [rad].
        rates: Bernstein coefficients of x', y' and psi', shape (n, k, 3).
    """

    begins: Array
    widths: Array
    yaw: Array
    eta: Array
    rates: Array


def _nodes(request: CertifyRequest, iq: int, iv: int) -> _Nodes | None:
    """Return parts of all pieces with little change of yaw, or None if it changes too quickly."""
    curve = request.trajectory
    begins, widths = curve.breaks[:-1], np.diff(curve.breaks)
    yaw_coefficients = curve.coefficients[:, :, iv + 2 : iv + 3]
    terms = 1 + int(np.max(np.flatnonzero(yaw_coefficients.any(axis=(0, 2))), initial=0))
    yaw = (
        bernstein.from_power(yaw_coefficients[:, :terms], widths)
        + curve.bases[:, iq + 2, None, None]
    )
    rates = np.moveaxis(request.bernstein_forms[1][iv : iv + 3], 0, -1)
    for _ in range(_MAX_HALVINGS):
        low, high = yaw[:, :, 0].min(axis=1), yaw[:, :, 0].max(axis=1)
        wide = high - low > 2 * _MAX_YAW_CHANGE
        if not wide.any():
            middle = (low + high) / 2
            return _Nodes(begins, widths, middle, yaw[:, :, 0] - middle[:, None], rates)
        if len(yaw) + wide.sum() > _MAX_NODES:
            return None
        half = widths[wide] / 2
        begins = np.concatenate([begins[~wide], begins[wide], begins[wide] + half])
        widths = np.concatenate([widths[~wide], half, half])
        yaw, rates = (
            np.concatenate([form[~wide], *bernstein.halves(form[wide])]) for form in (yaw, rates)
        )
    return None


def _excesses(
    nodes: _Nodes, car: Steering, neglected_speeds: Array
) -> list[tuple[str, Array, float]]:
    """Return the quantities that must not be positive: name, coefficients and tolerance."""
    slip_speed, turn_speed = neglected_speeds.tolist()
    c, s = np.cos(nodes.yaw)[:, None], np.sin(nodes.yaw)[:, None]
    x, y, yaw_rate = np.moveaxis(nodes.rates, -1, 0)
    # Along the middle yaw, and across.
    u, w = c * x + s * y, c * y - s * x
    eta = nodes.eta
    squared = multiply(eta, eta)
    degree = 4 * (eta.shape[1] - 1)
    sine = elevate_degree(eta, degree) - elevate_degree(multiply(squared, eta), degree) / 6
    cosine = 1 - elevate_degree(squared, degree) / 2 + multiply(squared, squared) / 24
    sideways = multiply(cosine, w) - multiply(sine, u)
    forward = multiply(cosine, u) + multiply(sine, w)
    speed = multiply(u, u) + multiply(w, w)
    slip = multiply(sideways, sideways) - (SLIP_TOLERANCE - _TAYLOR_ERROR) ** 2 * elevate_degree(
        speed, 2 * (sideways.shape[1] - 1)
    )
    allowed = (1 + CURVATURE_TOLERANCE) ** 2 * (1 - SLIP_TOLERANCE**2) / car.turning_radius**2
    excesses = [
        ("sideways", slip, slip_speed**2),
        (
            "curvature",
            car.turning_radius**2 * (multiply(yaw_rate, yaw_rate) - allowed * speed),
            turn_speed**2,
        ),
    ]
    return excesses if car.reverse else [*excesses, ("reverse", -forward, slip_speed)]
