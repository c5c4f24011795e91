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
up to a tolerance (`_dust`) are neglected. Over the whole motion the neglected distance is less than
a micrometre, however long the motion takes: sideways, backwards, and along the rim of the tightest
turn. The rounding error of speeds is subtracted from the tolerance; where the error is larger,
nothing is proven.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals import bernstein
from planning.certify.intervals.bernstein_products import raised, times
from planning.certify.intervals.rounding import closely
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check
from planning.domain.robot.steering import Steering, steering_of

# epsilon, the tangent of the angle of slip, and delta.
SLIP, TIGHT = 1e-5, 1e-4
_SERIES = 3e-7
_LARGEST_TURN = 0.125
_MOST_HALVINGS, _MOST_NODES = 16, 100_000
# Neglected speeds: at most this sideways and backwards, and this along a turn [m/s], and less if
# they add up to more than this distance over the whole motion [m].
_SLIP_DUST, _TURN_DUST, _DUST_WAY = 1e-9, 1e-6, 1e-6
# Fractions of each piece at which speeds are compared for the reported value.
_LOOKS = np.array([0.1, 0.35, 0.65, 0.9])


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


def _check(name: str, request: CertifyRequest, at: tuple[int, int], car: Steering) -> Check:
    bound = 1 + TIGHT
    widths = np.diff(request.trajectory.breaks)
    times_ = (request.trajectory.breaks[:-1, None] + _LOOKS * widths[:, None]).ravel()
    value, where, time = _worst(request, at, times_, car)
    nodes = _nodes(request, *at)
    most = _most(request, at[1], car)
    dusts = _dust(request.trajectory.duration) - _hidden(request, at[1], car)
    if nodes is None or not (dusts > 0).all():
        open_ = max(0.0, most - value)
        return Check(name, value, bound, "1", open_, passed=False, where="unproven", time=time)
    for kind, excess, dust in _excesses(nodes, car, dusts):
        top, row, fraction = bernstein.peak(np.ascontiguousarray(excess), dust / 2)
        if not top <= dust:
            when = float(nodes.begins[row] + fraction * nodes.widths[row])
            seen, _, _ = _worst(request, at, np.array([when]), car)
            value = max(value, seen)
            return Check(name, value, bound, "1", max(0.0, most - value), False, kind, when)  # noqa: FBT003
    return Check(name, value, bound, "1", max(0.0, bound - value), True, where, time)  # noqa: FBT003


def _most(request: CertifyRequest, iv: int, car: Steering) -> float:
    """Return an upper bound on the utilization of slip and curvature, whatever the motion does.

    Sideways and reverse speeds are at most the speed of the base; its polynomials bound the yaw
    rate.
    """
    turn = float(np.abs(request.forms[1][iv + 2]).max(initial=0.0))
    _, turn_dust = _dust(request.trajectory.duration)
    return max(1 / SLIP, turn * car.turning_radius / turn_dust)


def _dust(duration: float) -> Float64[np.ndarray, "2"]:
    """Return the neglected speeds: sideways or backwards, and along a turn [m/s]."""
    return np.minimum([_SLIP_DUST, _TURN_DUST], _DUST_WAY / duration)


def _hidden(request: CertifyRequest, iv: int, car: Steering) -> Float64[np.ndarray, "2"]:
    """Bound the rounding errors of speeds sideways or backwards, and along a turn [m/s].

    A yaw error e turns a forward speed v into a sideways speed v e.
    """
    own, curve = slice(iv, iv + 3), request.trajectory
    speed = float(np.linalg.norm(request.sizes[1][iv : iv + 2]))
    places, rates = (
        closely(request.sizes[k][own], curve.coefficients[:, :, own], np.diff(curve.breaks), k)
        for k in range(2)
    )
    along = float(np.linalg.norm(rates[:2])) + speed * float(places[2])
    return np.array([2 * along, car.turning_radius * float(rates[2]) + 2 * along])


def _worst(
    request: CertifyRequest, at: tuple[int, int], instants: Array, car: Steering
) -> tuple[float, str, float]:
    """Return the largest sampled utilization, its kind (slip or curvature), and its instant [s]."""
    curve, (iq, iv) = request.trajectory, at
    yaw = curve.positions(instants)[:, iq + 2]
    x, y, turn = curve.tangents(instants, 1)[:, iv : iv + 3].T
    c, s = np.cos(yaw), np.sin(yaw)
    ahead, aside = c * x + s * y, c * y - s * x
    speed, (slip_dust, turn_dust) = np.hypot(x, y), _dust(curve.duration)
    back = np.zeros_like(ahead) if car.reverse else np.maximum(-ahead, 0.0)
    shares = {
        "sideways": np.abs(aside) / (SLIP * speed + slip_dust),
        "curvature": np.abs(turn) * car.turning_radius / (speed + turn_dust),
        "reverse": back / (SLIP * speed + slip_dust),
    }
    where = max(shares, key=lambda kind: float(shares[kind].max()))
    row = int(np.argmax(shares[where]))
    return float(shares[where][row]), where, float(instants[row])


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
    turning = curve.coefficients[:, :, iv + 2 : iv + 3]
    terms = 1 + int(np.max(np.flatnonzero(turning.any(axis=(0, 2))), initial=0))
    yaw = bernstein.from_power(turning[:, :terms], widths) + curve.bases[:, iq + 2, None, None]
    rates = np.moveaxis(request.forms[1][iv : iv + 3], 0, -1)
    for _ in range(_MOST_HALVINGS):
        low, high = yaw[:, :, 0].min(axis=1), yaw[:, :, 0].max(axis=1)
        wide = high - low > 2 * _LARGEST_TURN
        if not wide.any():
            middle = (low + high) / 2
            return _Nodes(begins, widths, middle, yaw[:, :, 0] - middle[:, None], rates)
        if len(yaw) + wide.sum() > _MOST_NODES:
            return None
        half = widths[wide] / 2
        begins = np.concatenate([begins[~wide], begins[wide], begins[wide] + half])
        widths = np.concatenate([widths[~wide], half, half])
        yaw, rates = (
            np.concatenate([form[~wide], *bernstein.halves(form[wide])]) for form in (yaw, rates)
        )
    return None


def _excesses(nodes: _Nodes, car: Steering, dusts: Array) -> list[tuple[str, Array, float]]:
    """Return the quantities that must not be positive: name, coefficients and tolerance."""
    slip_dust, turn_dust = dusts.tolist()
    c, s = np.cos(nodes.yaw)[:, None], np.sin(nodes.yaw)[:, None]
    x, y, turn = np.moveaxis(nodes.rates, -1, 0)
    # Along the middle yaw, and across.
    u, w = c * x + s * y, c * y - s * x
    eta = nodes.eta
    squared = times(eta, eta)
    degree = 4 * (eta.shape[1] - 1)
    sine = raised(eta, degree) - raised(times(squared, eta), degree) / 6
    cosine = 1 - raised(squared, degree) / 2 + times(squared, squared) / 24
    aside = times(cosine, w) - times(sine, u)
    ahead = times(cosine, u) + times(sine, w)
    speed = times(u, u) + times(w, w)
    slip = times(aside, aside) - (SLIP - _SERIES) ** 2 * raised(speed, 2 * (aside.shape[1] - 1))
    allowed = (1 + TIGHT) ** 2 * (1 - SLIP**2) / car.turning_radius**2
    excesses = [
        ("sideways", slip, slip_dust**2),
        (
            "curvature",
            car.turning_radius**2 * (times(turn, turn) - allowed * speed),
            turn_dust**2,
        ),
    ]
    return excesses if car.reverse else [*excesses, ("reverse", -ahead, slip_dust)]
