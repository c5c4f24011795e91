"""A trajectory that a client made, as the domain's."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from planning import TimedTrajectory, trajectory_through
from planning.domain.joints import JointGroup, JointType
from planning.errors import ProblemInvalid, UnknownName
from service.schemas.own_motion import OwnPolynomial, OwnTrajectory

type Array = np.ndarray[Any, np.dtype[np.float64]]


def own_trajectory(
    group: JointGroup, wire: OwnTrajectory, field: str = "trajectory"
) -> tuple[TimedTrajectory, str]:
    """Return the motion, and what its samples were taken for.

    Args:
        group: Whose it is.
        wire: As it was sent.
        field: What the request calls it.

    Raises:
        UnknownName: A column's name is not one of the group's.
        ProblemInvalid: A count does not fit, times do not increase from 0, or a joint floats and
            there are only samples of it.
    """
    if wire.polynomial is not None:
        return _polynomial(group, wire.polynomial, f"{field}.polynomial"), "polynomial"
    floating = [joint.name for joint in group.joints if joint.type is JointType.FLOATING]
    if floating:
        message = f"{field}: samples do not say how {floating} turn between them; give the "
        raise ProblemInvalid(message + "`polynomial`", {"field": f"{field}.polynomial"})
    times = np.array(wire.times)
    if times[0] != 0 or not (np.diff(times) > 0).all():
        message = f"{field}.times: they must increase, from 0"
        raise ProblemInvalid(message, {"field": f"{field}.times"})
    names, rates = group.position_names, group.velocity_names
    columns = [
        None if given is None else _columns(given, len(times), named, wanted, f"{field}.{rows}")
        for rows, given, named, wanted in (
            ("positions", wire.positions, wire.joint_names, names),
            ("velocities", wire.velocities, wire.velocity_names, rates),
            ("accelerations", wire.accelerations, wire.velocity_names, rates),
        )
    ]
    positions, velocities, accelerations = columns
    if positions is None or (velocities is None and accelerations is not None):
        message = f"{field}.accelerations: they are of no use without `velocities`"
        raise ProblemInvalid(message, {"field": f"{field}.velocities"})
    kind = "cubic_spline" if velocities is None else "cubic" if accelerations is None else "quintic"
    made = trajectory_through(group.joints, times, positions, velocities, accelerations)
    return made, kind


def _columns(
    rows: Sequence[Sequence[float]],
    count: int,
    given: Sequence[str] | None,
    wanted: Sequence[str],
    field: str,
) -> Array:
    """Return rows with their columns in the group's order."""
    if len(rows) != count or any(len(row) != len(wanted) for row in rows):
        message = f"{field}: {count} rows of {len(wanted)} numbers are needed"
        raise ProblemInvalid(message, {"field": field, "names": list(wanted)})
    order = list(range(len(wanted)))
    if given is not None:
        for name in given:
            if name not in wanted:
                raise UnknownName.among("joint", name, wanted)
        if sorted(given) != sorted(wanted):
            message = f"{field}: each of {list(wanted)} must be named once"
            raise ProblemInvalid(message, {"field": f"{field.rpartition('.')[0]}.joint_names"})
        order = [given.index(name) for name in wanted]
    return np.array(rows, dtype=np.float64)[:, order]


def _polynomial(group: JointGroup, wire: OwnPolynomial, field: str) -> TimedTrajectory:
    names = [joint.name for joint in group.joints]
    if wire.joint_names is not None and wire.joint_names != names:
        message = f"{field}.joint_names: they must be {names}, in this order"
        raise ProblemInvalid(message, {"field": f"{field}.joint_names"})
    pieces, terms = len(wire.bases), len(wire.coefficients[0])
    nq, nv = group.num_positions, group.num_velocities
    fits = (
        len(wire.breaks) == pieces + 1
        and len(wire.coefficients) == pieces
        and all(len(row) == nq for row in wire.bases)
        and all(len(powers) == terms for powers in wire.coefficients)
        and all(len(row) == nv for powers in wire.coefficients for row in powers)
    )
    if not fits:
        message = (
            f"{field}: n + 1 breaks, n bases of "
            f"{nq} numbers and n times as many powers of {nv} numbers each are needed"
        )
        raise ProblemInvalid(message, {"field": field})
    return TimedTrajectory(
        group.joints,
        np.array(wire.breaks, dtype=np.float64),
        np.array(wire.bases, dtype=np.float64),
        np.array(wire.coefficients, dtype=np.float64),
    )
