"""Torques by Newton and Euler, from the masses in a robot's file.

Of every link the acceleration of its centre of mass and the change of its momentum of spin are
taken by differences of where the judge's kinematics has it; what a joint gives is, by d'Alembert's
principle, the power of all that per unit of the joint's speed.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from tests.adversary.draws.motions import Document, positions, sample_places
from tests.adversary.judge.kinematics import Inertia, Robot

_GRAVITY = np.array([0.0, 0.0, -9.81])


def torques(
    robot: Robot, base: Array, motion: Document, payloads: Sequence[tuple[str, Inertia]] = ()
) -> dict[str, Array]:
    """Return the torque or force of every joint that moves by itself and has one coordinate.

    Args:
        robot: Whose joints they are.
        base: X_WB of its root, shape (4, 4).
        motion: Of its joints.
        payloads: What links carry besides themselves.
    """
    pieces, local, _ = sample_places(motion, _INSTANTS)
    step = 1e-3 * np.diff(motion["breaks"])[pieces]

    def placed(shift: float, turn: str = "") -> dict[str, Array]:
        q = positions(motion, pieces, local + shift * step)
        if turn:
            q[turn] = q[turn] + _NUDGE
        return robot.place(q, base, len(local))

    frames = {shift: placed(shift) for shift in (-2, -1, 0, 1, 2)}
    wanted = [
        joint.name
        for joint in robot.leaders
        if joint.kind in {"revolute", "continuous", "prismatic"}
    ]
    total = {name: np.zeros(len(local)) for name in wanted}
    nudged = {
        name: (placed(0, name), _back(robot, base, motion, pieces, local, name)) for name in wanted
    }
    for link, weight in [*robot.inertias.items(), *payloads]:
        force, moment = _effort(weight, {s: f[link] for s, f in frames.items()}, step)
        for name, (ahead, behind) in nudged.items():
            shift, turn = _moved(weight, ahead[link], behind[link], frames[0][link])
            total[name] += (force * shift).sum(axis=1) + (moment * turn).sum(axis=1)
    return total


# How far a joint is displaced to see what moves [rad or m], and instants of a motion.
_NUDGE = 1e-5
_INSTANTS = 300


def _back(
    robot: Robot, base: Array, motion: Document, pieces: Array, local: Array, name: str
) -> dict[str, Array]:
    q = positions(motion, pieces, local)
    q[name] = q[name] - _NUDGE
    return robot.place(q, base, len(local))


def _effort(weight: Any, at: dict[int, Array], step: Array) -> tuple[Array, Array]:
    """Return the force at the centre of mass and the moment about it that a link's motion takes."""
    h = step[:, None]
    places = {s: pose[:, :3, :3] @ weight.center + pose[:, :3, 3] for s, pose in at.items()}
    outer = 16 * (places[1] + places[-1]) - (places[2] + places[-2]) - 30 * places[0]
    force = weight.mass * (outer / (12 * h**2) - _GRAVITY)
    spins = {s: _spin(at, s, weight, h) for s in (-1, 0, 1)}
    return force, (spins[1] - spins[-1]) / (2 * h)


def _spin(at: dict[int, Array], s: int, weight: Any, h: Array) -> Array:
    """Return the momentum of spin at an instant: R I R^T w."""
    before, here, after = (at[k][:, :3, :3] for k in _three(s))
    skew = (after - before) @ here.transpose(0, 2, 1) / (2 * h[:, :, None])
    if abs(s) == 1:
        skew = (after - before) @ here.transpose(0, 2, 1) / (2 * h[:, :, None])
    omega = (
        np.stack(
            [
                skew[:, 2, 1] - skew[:, 1, 2],
                skew[:, 0, 2] - skew[:, 2, 0],
                skew[:, 1, 0] - skew[:, 0, 1],
            ],
            axis=1,
        )
        / 2
    )
    inertia = here @ weight.matrix @ here.transpose(0, 2, 1)
    return np.einsum("nij,nj->ni", inertia, omega)


def _three(s: int) -> tuple[int, int, int]:
    return s - 1, s, s + 1


def _moved(weight: Any, ahead: Array, behind: Array, here: Array) -> tuple[Array, Array]:
    """Return how a link's centre of mass and turn change with a joint, per unit of it."""
    shift = ((ahead - behind)[:, :3, :3] @ weight.center + (ahead - behind)[:, :3, 3]) / (
        2 * _NUDGE
    )
    skew = (ahead - behind)[:, :3, :3] @ here[:, :3, :3].transpose(0, 2, 1) / (2 * _NUDGE)
    turn = (
        np.stack(
            [
                skew[:, 2, 1] - skew[:, 1, 2],
                skew[:, 0, 2] - skew[:, 2, 0],
                skew[:, 1, 0] - skew[:, 0, 1],
            ],
            axis=1,
        )
        / 2
    )
    return shift, turn
