"""Random motions, and their values by Horner's rule.

A motion is a document: `breaks`, and of every joint that moves by itself `bases` (a row a piece)
and `coefficients` (of each piece a list by power, of each a list by coordinate). On piece i the
joint's value is base + sum_k c_k (t - breaks[i])^k; a floating joint turns by the exponential of
the first three coordinates, in its own frame.
"""

from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from tests.adversary.judge.kinematics import FileJoint

type Document = dict[str, Any]

WIDTHS = {"planar": 3, "floating": 6}


def random_motion(rng: np.random.Generator, joints: Iterable[FileJoint], **wanted: Any) -> Document:
    """Return a motion from rest to rest that keeps near the middle of the joints' ranges.

    Args:
        rng: Random numbers.
        joints: Those that move by themselves.
        wanted: `size` [m] of free positions, `pieces`, `duration` [s], `degree` 3 or 5, `reach`
            (share of the range).
    """
    count = wanted.get("pieces") or int(rng.choice([1, 1, 2, 3, 5]))
    duration = wanted.get("duration") or float(10 ** rng.uniform(-1, 1.5))
    shares = rng.dirichlet(np.full(count, 4.0))
    breaks = np.concatenate([[0.0], np.cumsum(shares) * duration])
    degree = wanted.get("degree") or int(rng.choice([3, 5]))
    how = (np.diff(breaks), degree, wanted.get("reach", 1.0), wanted.get("size", 1.0))
    moved = {joint.name: _joint_motion(rng, joint, how) for joint in joints}
    return {"breaks": breaks.tolist(), "joints": moved}


def _joint_motion(rng: np.random.Generator, joint: FileJoint, how: Any) -> Document:
    widths, degree, reach, size = how
    count = len(widths)
    if joint.kind == "floating":
        return _floating_motion(rng, (widths, degree), reach, size)
    places = _places(rng, joint, count + 1, reach, size)
    rates = np.zeros_like(places)
    if count > 1:
        slopes = np.diff(places, axis=0) / widths[:, None]
        rates[1:-1] = rng.uniform(-0.3, 1.0) * (slopes[1:] + slopes[:-1]) / 2
    bends = np.zeros_like(places)
    bends[1:-1] = rng.normal(size=bends[1:-1].shape) * np.abs(rates[1:-1]) / widths.mean()
    pieces = [
        hermite(widths[i], places[i + 1] - places[i], rates[i : i + 2], bends[i : i + 2], degree)
        for i in range(count)
    ]
    return {"bases": places[:-1].tolist(), "coefficients": [p.tolist() for p in pieces]}


def _places(
    rng: np.random.Generator, joint: FileJoint, count: int, reach: float, size: float
) -> Array:
    if joint.kind == "planar":
        return rng.normal(size=(count, 3)) * [size * reach, size * reach, 2.0 * reach]
    low, high = (joint.lower, joint.upper) if np.isfinite(joint.lower) else (-4.0, 4.0)
    middle, half = (low + high) / 2, (high - low) / 2 * 0.75 * reach
    return middle + half * rng.uniform(-1, 1, size=(count, 1))


def _floating_motion(rng: np.random.Generator, how: Any, reach: float, size: float) -> Document:
    """Return a motion of a floating joint; between two pieces it turns on in the same sense."""
    widths, degree = how
    bases, pieces, rate = [], [], np.zeros(6)
    quaternion = rng.normal(size=4)
    quaternion /= np.linalg.norm(quaternion)
    place = size * reach * rng.normal(size=3)
    for i, width in enumerate(widths):
        step = np.concatenate([rng.normal(size=3) * reach, size * reach * rng.normal(size=3)])
        share = 0.0 if i == len(widths) - 1 else rng.uniform(0, 1) / width
        rates = np.stack([rate, share * step])
        pieces.append(hermite(width, step, rates, np.zeros((2, 6)), degree))
        bases.append([*quaternion, *place])
        # The turn's own rate is seen the same from both sides: it lies along the turn.
        quaternion = times(quaternion, exponential(step[None, :3])[0])
        quaternion, place, rate = (
            quaternion / np.linalg.norm(quaternion),
            place + step[3:],
            rates[1],
        )
    return {
        "bases": [[float(x) for x in row] for row in bases],
        "coefficients": [piece.tolist() for piece in pieces],
    }


def hermite(h: float, step: Array, rates: Array, bends: Array, degree: int = 5) -> Array:
    """Return the powers of what goes by `step` in h [s], with rates and, of degree 5, bends."""
    (v0, v1), (a0, a1) = rates, bends
    if degree == 3:
        c2, c3 = (3 * step / h - 2 * v0 - v1) / h, (v0 + v1 - 2 * step / h) / h**2
        return np.stack([np.zeros_like(step), v0, c2, c3])
    p = step - v0 * h - a0 * h**2 / 2
    v, a = (v1 - v0 - a0 * h) * h, (a1 - a0) * h**2
    tail = [10 * p - 4 * v + a / 2, -15 * p + 7 * v - a, 6 * p - 3 * v + a / 2]
    rest = [part / h**k for k, part in enumerate(tail, start=3)]
    return np.stack([np.zeros_like(step), v0, a0 / 2, *rest])


def slowed(motion: Document, factor: float) -> Document:
    """Return the same motion taking `factor` times as long."""
    parts: Document = {}
    for name, part in motion["joints"].items():
        powers = np.array(part["coefficients"], dtype=np.float64)
        powers /= (factor ** np.arange(powers.shape[1]))[None, :, None]
        parts[name] = {**part, "coefficients": powers.tolist()}
    return {"breaks": [factor * time for time in motion["breaks"]], "joints": parts}


def sample_places(motion: Document, count: int) -> tuple[Array, Array, Array]:
    """Return pieces, times from their breaks and times, both ends of every piece included."""
    breaks = np.array(motion["breaks"])
    widths = np.diff(breaks)
    per = np.maximum(3, np.ceil(count * widths / widths.sum())).astype(int)
    pieces = np.repeat(np.arange(len(widths)), per)
    fractions = np.concatenate([np.linspace(0, 1, k) for k in per])
    local = fractions * widths[pieces]
    return pieces, local, breaks[pieces] + local


def around(motion: Document, time: float, width: float, count: int) -> tuple[Array, Array, Array]:
    """Return the same about an instant."""
    breaks = np.array(motion["breaks"])
    times = np.clip(np.linspace(time - width, time + width, count), 0.0, breaks[-1])
    pieces = np.clip(np.searchsorted(breaks, times, side="right") - 1, 0, len(breaks) - 2)
    return pieces, times - breaks[pieces], times


def tangents(part: Document, pieces: Array, local: Array, order: int = 0) -> Array:
    """Return a derivative of a joint's tangent, shape (n, width)."""
    powers = np.array(part["coefficients"], dtype=np.float64)
    for _ in range(order):
        powers = powers[:, 1:] * np.arange(1, powers.shape[1])[None, :, None]
        if powers.shape[1] == 0:
            return np.zeros((len(local), powers.shape[2]))
    total = np.zeros((len(local), powers.shape[2]))
    for k in range(powers.shape[1] - 1, -1, -1):
        total = total * local[:, None] + powers[pieces, k]
    return total


def exact_tangent(part: Document, piece: int, local: float, column: int = 0) -> Fraction:
    """Return a joint's tangent without rounding."""
    total = Fraction(0)
    for row in reversed(part["coefficients"][piece]):
        total = total * Fraction(local) + Fraction(float(row[column]))
    return total


def positions(motion: Document, pieces: Array, local: Array) -> dict[str, Array]:
    """Return every joint's value, shape (n, width of its value)."""
    values: dict[str, Array] = {}
    for name, part in motion["joints"].items():
        base, moved = np.array(part["bases"])[pieces], tangents(part, pieces, local)
        if base.shape[1] == 7:
            turned = times(base[:, :4], exponential(moved[:, :3]))
            values[name] = np.concatenate([turned, base[:, 4:] + moved[:, 3:]], axis=1)
        else:
            values[name] = base + moved
    return values


def times(a: Array, b: Array) -> Array:
    """Return products of quaternions w, x, y, z."""
    (w, v), (s, u) = ((q[..., :1], q[..., 1:]) for q in (a, b))
    real = w * s - (v * u).sum(axis=-1, keepdims=True)
    return np.concatenate([real, w * u + s * v + np.cross(v, u)], axis=-1)


def exponential(turns: Array) -> Array:
    """Return quaternions of rotation vectors, shape (n, 3) to (n, 4)."""
    angles = np.linalg.norm(turns, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angles / 2), np.sinc(angles / 2 / np.pi) / 2 * turns], axis=-1)
