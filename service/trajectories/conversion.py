"""A trajectory that a client made, as the domain's."""

from collections.abc import Sequence

import numpy as np

from planning import TimedTrajectory, trajectory_through
from planning.domain.arrays import Array
from planning.domain.curves.interpolation import polyline_through
from planning.domain.robot.joints import JointGroup, JointType
from planning.errors import ProblemInvalid, UnknownName
from service.trajectories.models import OwnPolynomial, OwnTrajectory


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
        ProblemInvalid: A count does not fit, times do not increase from 0, rates are missing or
            named without the positions, or a joint floats and there are only samples of it.
    """
    if wire.polynomial is not None:
        _require_order(group, wire, field)
        return _polynomial(group, wire.polynomial, f"{field}.polynomial"), "polynomial"
    floating = [joint.name for joint in group.joints if joint.type is JointType.FLOATING]
    if floating:
        message = f"{field}: samples do not say how {floating} turn between them; give the "
        raise ProblemInvalid(message + "`polynomial`", {"field": f"{field}.polynomial"})
    times = np.array(wire.times)
    if times[0] != 0 or not (np.diff(times) > 0).all():
        message = f"{field}.times: they must increase, from 0"
        raise ProblemInvalid(message, {"field": f"{field}.times"})
    positions, velocities, accelerations = _rows(group, wire, field)
    if velocities is None and accelerations is not None:
        message = f"{field}.accelerations: they are of no use without `velocities`"
        raise ProblemInvalid(message, {"field": f"{field}.velocities"})
    given = (
        "cubic_spline" if velocities is None else "cubic" if accelerations is None else "quintic"
    )
    kind = wire.interpolation or given
    for name, rows, users in (
        ("velocities", velocities, ("cubic", "quintic")),
        ("accelerations", accelerations, ("quintic",)),
    ):
        if rows is None and kind in users:
            message = f"{field}.interpolation: {kind!r} needs `{name}`"
            raise ProblemInvalid(message, {"field": f"{field}.{name}"})
    if kind == "linear":
        return polyline_through(group.joints, times, positions), kind
    rates = {"quintic": (velocities, accelerations), "cubic": (velocities,)}.get(kind, ())
    return trajectory_through(group.joints, times, positions, *rates), kind


def _rows(
    group: JointGroup, wire: OwnTrajectory, field: str
) -> tuple[Array, Array | None, Array | None]:
    """Return positions, velocities and accelerations with their columns in the group's order.

    The names of the positions' columns are those of the rates too, which have no others.
    """
    names, rates = list(group.position_names), list(group.velocity_names)
    if wire.joint_names is None and wire.velocity_names not in (None, rates):
        message = f"{field}.velocity_names: another order needs `joint_names` too: {names}"
        raise ProblemInvalid(message, {"field": f"{field}.joint_names", "names": names})
    named = wire.joint_names if wire.velocity_names is None else wire.velocity_names
    count = len(wire.times)
    positions = _columns(wire.positions, count, (wire.joint_names, names), f"{field}.positions")
    velocities, accelerations = (
        None if given is None else _columns(given, count, (named, rates), f"{field}.{rows}")
        for rows, given in (("velocities", wire.velocities), ("accelerations", wire.accelerations))
    )
    return positions, velocities, accelerations


def _require_order(group: JointGroup, wire: OwnTrajectory, field: str) -> None:
    """Go on only if the columns of a polynomial, which are the group's, are not named otherwise.

    Raises:
        ProblemInvalid: They are.
    """
    for name, given, wanted in (
        ("joint_names", wire.joint_names, group.position_names),
        ("velocity_names", wire.velocity_names, group.velocity_names),
    ):
        if given is not None and tuple(given) != wanted:
            message = f"{field}.{name}: beside a `polynomial` they must be {list(wanted)}"
            raise ProblemInvalid(message, {"field": f"{field}.{name}", "names": list(wanted)})


def _columns(
    rows: Sequence[Sequence[float]],
    count: int,
    names: tuple[Sequence[str] | None, Sequence[str]],
    field: str,
) -> Array:
    """Return rows with their columns, named as given or not at all, in the order that is wanted."""
    given, wanted = names
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
