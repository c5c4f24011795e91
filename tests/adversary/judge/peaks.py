"""How far and how fast joints go: largest values of polynomials, and what jumps between them do."""

import numpy as np

from planning.domain.arrays import Array
from tests.adversary.draws.motions import Document, sample_places, tangents
from tests.adversary.judge.kinematics import Robot

ORDERS = {"velocity": 1, "acceleration": 2, "jerk": 3}
# A step of differences, as a share of a piece.
_STEP = 1e-3


def extremes(part: Document, breaks: Array, column: int, order: int) -> tuple[float, float]:
    """Return the smallest and largest value of a coordinate, or of a derivative of it.

    By the roots of the next derivative, which are where it turns, and both ends of every piece.
    """
    powers = np.array(part["coefficients"], dtype=np.float64)[:, :, column].copy()
    if order == 0:
        powers[:, 0] += np.array(part["bases"])[:, column]
    lowest, highest = np.inf, -np.inf
    for row, width in zip(powers, np.diff(breaks), strict=True):
        curve = (
            np.polynomial.Polynomial(row).deriv(order) if order else np.polynomial.Polynomial(row)
        )
        turns = curve.deriv().roots() if curve.degree() > 1 else np.zeros(0)
        turns = turns[np.abs(turns.imag) <= 1e-9 * width].real
        places = np.concatenate([[0.0, width], turns[(turns > 0) & (turns < width)]])
        values = curve(places)
        lowest, highest = min(lowest, values.min()), max(highest, values.max())
    return float(lowest), float(highest)


def peak(part: Document, breaks: Array, columns: tuple[int, ...], order: int) -> float:
    """Return the largest length of some coordinates' derivative."""
    if len(columns) == 1:
        return max(map(abs, extremes(part, breaks, columns[0], order)))
    pieces, local, _ = sample_places({"breaks": breaks}, 2000)
    rates = tangents(part, pieces, local, order)[:, list(columns)]
    return float(np.linalg.norm(rates, axis=1).max())


def angular_peak(part: Document, breaks: Array, order: int) -> float:
    """Return the largest angular velocity, acceleration or jerk of a floating joint.

    The angular velocity is the right Jacobian of the rotation vector times its derivative; the
    others are differences of it over neighbouring instants.
    """
    pieces, local, _ = sample_places({"breaks": breaks}, 1000)
    step = (_STEP * np.diff(breaks)[pieces])[:, None]

    def omega(shift: float) -> Array:
        at = local + shift * step[:, 0]
        return angular_velocity(
            tangents(part, pieces, at)[:, :3], tangents(part, pieces, at, 1)[:, :3]
        )

    match order:
        case 1:
            rates = omega(0)
        case 2:
            rates = (8 * (omega(1) - omega(-1)) - (omega(2) - omega(-2))) / (12 * step)
        case _:
            outer = 16 * (omega(1) + omega(-1)) - (omega(2) + omega(-2)) - 30 * omega(0)
            rates = outer / (12 * step**2)
    return float(np.linalg.norm(rates, axis=1).max())


def angular_velocity(turn: Array, rate: Array) -> Array:
    """Return the angular velocity in the body of a rotation vector that changes, shape (n, 3)."""
    angle = np.linalg.norm(turn, axis=1, keepdims=True)
    small = angle < 1e-3
    safe = np.where(small, 1.0, angle)
    first = np.where(small, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    second = np.where(small, 1 / 6 - angle**2 / 120, (safe - np.sin(safe)) / safe**3)
    across = np.cross(turn, rate)
    return rate - first * across + second * np.cross(turn, across)


def blocks_of(kind: str) -> dict[str, tuple[int, ...]]:
    """Return the coordinates that are limited together, by the name that a card gives them."""
    match kind:
        case "planar":
            return {"linear": (0, 1), "angular": (2,)}
        case "floating":
            return {"angular": (0, 1, 2), "linear": (3, 4, 5)}
        case _:
            return {"": (0,)}


def all_peaks(robot: Robot, motion: Document, order: int) -> dict[tuple[str, str], float]:
    """Return the peak of a derivative of every block of every joint, followers included."""
    breaks, found = np.array(motion["breaks"]), {}
    for joint in robot.joints:
        if joint.kind == "fixed":
            continue
        leader, factor = robot.factor(joint.name)
        part = motion["joints"][leader]
        for block, columns in blocks_of(joint.kind).items():
            is_spin = joint.kind == "floating" and block == "angular"
            top = (
                angular_peak(part, breaks, order) if is_spin else peak(part, breaks, columns, order)
            )
            found[joint.name, block] = abs(factor) * top
    return found


def all_ranges(robot: Robot, motion: Document) -> dict[str, tuple[float, float]]:
    """Return the smallest and largest position of every joint of one coordinate."""
    breaks, found = np.array(motion["breaks"]), {}
    for joint in robot.joints:
        if joint.kind in {"fixed", "planar", "floating"}:
            continue
        leader, factor = robot.factor(joint.name)
        ends = extremes(motion["joints"][leader], breaks, 0, 0)
        offset = robot.value(joint.name, {leader: np.zeros(1)})[0] if joint.leader else 0.0
        low, high = sorted(factor * end + offset for end in ends)
        found[joint.name] = float(low), float(high)
    return found


def rise(times: Array, values: Array, rate: float) -> float:
    """Return by how much values go beyond a rate between any two instants, up or down."""
    worst = 0.0
    for sign in (1.0, -1.0):
        ahead = sign * values - rate * times
        worst = max(worst, float((ahead - np.minimum.accumulate(ahead)).max()))
    return worst
