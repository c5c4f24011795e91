"""A trajectory of the client: samples or the exact polynomial, as JSON and as the domain's."""

from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation import polyline_through, trajectory_through
from planning.domain.robot.joints import JointGroup, JointType
from planning.errors import ProblemInvalid, UnknownName
from service.api.models import Coordinate, Name, NonNegative, Positions, RequestModel

type Rows = Annotated[list[Positions], Field(min_length=2, max_length=20_000)]
type Instants = Annotated[list[NonNegative], Field(min_length=2, max_length=20_001)]
type Pieces = Annotated[list[Positions], Field(min_length=1, max_length=20_000)]
type Powers = Annotated[list[Positions], Field(min_length=1, max_length=16)]

# What samples may be taken for; named, so that a generated client has one type of each.
type SampleInterpolation = Annotated[
    Literal["quintic", "cubic", "cubic_spline", "linear"],
    Field(description="Interpolation between two samples"),
]
type MotionInterpolation = Annotated[
    Literal["polynomial", "quintic", "cubic", "cubic_spline", "linear"],
    Field(description="Interpolation of a motion between its instants"),
]


class PolynomialInput(RequestModel):
    """The exact motion, as `Trajectory.polynomial` has it."""

    breaks: Instants = Field(description="Instants between pieces, from 0, n + 1 of them [s]")
    bases: Pieces = Field(
        description="Configuration at which each piece is anchored, n rows [rad or m]"
    )
    coefficients: Annotated[list[Powers], Field(min_length=1, max_length=20_000)] = Field(
        description="n pieces, powers from 0 up, a column per velocity coordinate"
    )
    joint_names: list[Name] | None = Field(default=None, description="The group's joints in order")
    joint_types: list[Name] | None = Field(default=None, description="Ignored: the scene has them")

    def to_domain(self, group: JointGroup, field: str) -> TimedTrajectory:
        """Return the motion of a group.

        Args:
            group: Whose motion it is.
            field: Name of this polynomial in the request.

        Raises:
            ProblemInvalid: The joints are others, or a count does not fit.
        """
        names = [joint.name for joint in group.joints]
        if self.joint_names is not None and self.joint_names != names:
            message = f"{field}.joint_names: they must be {names}, in this order"
            raise ProblemInvalid(message, {"field": f"{field}.joint_names"})
        if not self._fits(group):
            message = (
                f"{field}: n + 1 breaks, n bases of {group.num_positions} numbers and n times as "
                f"many powers of {group.num_velocities} numbers each are needed"
            )
            raise ProblemInvalid(message, {"field": field})
        return TimedTrajectory(
            group.joints,
            np.array(self.breaks, dtype=np.float64),
            np.array(self.bases, dtype=np.float64),
            np.array(self.coefficients, dtype=np.float64),
        )

    def _fits(self, group: JointGroup) -> bool:
        pieces, terms = len(self.bases), len(self.coefficients[0])
        return (
            len(self.breaks) == pieces + 1
            and len(self.coefficients) == pieces
            and all(len(row) == group.num_positions for row in self.bases)
            and all(len(powers) == terms for powers in self.coefficients)
            and all(
                len(row) == group.num_velocities for powers in self.coefficients for row in powers
            )
        )


class TrajectoryInput(RequestModel):
    """A timed motion as `Trajectory` has it: samples, or the exact `polynomial`."""

    times: Instants = Field(description="Instants of the samples, from 0 [s]")
    positions: Rows = Field(description="One row per instant [rad or m]")
    velocities: Rows | None = Field(
        default=None,
        description="Velocities, one row per instant [rad/s or m/s]; null if not known",
    )
    accelerations: Rows | None = Field(
        default=None,
        description="Accelerations, one row per instant [rad/s^2 or m/s^2]; null if not known",
    )
    joint_names: list[Name] | None = Field(
        default=None,
        description="Names of the columns, those of the rates too; null for the group's order",
    )
    velocity_names: list[Name] | None = Field(
        default=None,
        description="Names of the columns of the rates; null for the names of the positions' "
        "columns. An order that is not the group's needs `joint_names` too",
    )
    interpolation: SampleInterpolation | None = Field(
        default=None,
        description="Motion between the samples: the polynomials of degree 5 (`quintic`) or 3 "
        "(`cubic`) that meet what is given, the cubic spline with continuous acceleration that "
        "rests at both ends (`cubic_spline`), or straight lines (`linear`); null for the first of "
        "these that there are rates for",
    )
    interpolations: list[dict[str, Any]] | None = Field(
        default=None, description="Ignored: proofs of the samples, as answers have them"
    )
    duration: Coordinate | None = Field(
        default=None, description="Ignored: it follows from the times [s]"
    )
    polynomial: PolynomialInput | None = Field(
        default=None, description="The exact motion; with it the samples are ignored"
    )

    def to_domain(
        self, group: JointGroup, field: str = "trajectory"
    ) -> tuple[TimedTrajectory, MotionInterpolation]:
        """Return the motion of a group, and the interpolation that its samples stand for.

        Args:
            group: Whose motion it is.
            field: Name of this trajectory in the request.

        Raises:
            UnknownName: A column's name is not one of the group's.
            ProblemInvalid: A count does not fit, times do not increase from 0, rates are missing or
                named without the positions, or a joint floats and there are only samples of it.
        """
        if self.polynomial is not None:
            self._check_column_order(group, field)
            return self.polynomial.to_domain(group, f"{field}.polynomial"), "polynomial"
        _check_not_floating(group, field)
        times = np.array(self.times)
        if times[0] != 0 or not (np.diff(times) > 0).all():
            message = f"{field}.times: they must increase, from 0"
            raise ProblemInvalid(message, {"field": f"{field}.times"})
        positions, velocities, accelerations = self._rows(group, field)
        kind = self._kind(field)
        if kind == "linear":
            return polyline_through(group.joints, times, positions), kind
        rates = {"quintic": (velocities, accelerations), "cubic": (velocities,)}.get(kind, ())
        return trajectory_through(group.joints, times, positions, *rates), kind

    def _kind(self, field: str) -> SampleInterpolation:
        """Return the interpolation that is asked for, or the first that there are rates for."""
        if self.velocities is None and self.accelerations is not None:
            message = f"{field}.accelerations: they are of no use without `velocities`"
            raise ProblemInvalid(message, {"field": f"{field}.velocities"})
        kind = self.interpolation
        if kind is None:
            if self.velocities is None:
                return "cubic_spline"
            return "cubic" if self.accelerations is None else "quintic"
        for name, rows, users in (
            ("velocities", self.velocities, ("cubic", "quintic")),
            ("accelerations", self.accelerations, ("quintic",)),
        ):
            if rows is None and kind in users:
                message = f"{field}.interpolation: {kind!r} needs `{name}`"
                raise ProblemInvalid(message, {"field": f"{field}.{name}"})
        return kind

    def _rows(self, group: JointGroup, field: str) -> tuple[Array, Array | None, Array | None]:
        """Return positions, velocities and accelerations with their columns in the group's order.

        The names of the positions' columns are those of the rates too, which have no others.
        """
        names, rates = list(group.position_names), list(group.velocity_names)
        if self.joint_names is None and self.velocity_names not in (None, rates):
            message = f"{field}.velocity_names: another order needs `joint_names` too: {names}"
            raise ProblemInvalid(message, {"field": f"{field}.joint_names", "names": names})
        given = self.joint_names if self.velocity_names is None else self.velocity_names
        count = len(self.times)
        positions = _columns(self.positions, count, (self.joint_names, names), f"{field}.positions")
        velocities, accelerations = (
            None if rows is None else _columns(rows, count, (given, rates), f"{field}.{name}")
            for name, rows in (
                ("velocities", self.velocities),
                ("accelerations", self.accelerations),
            )
        )
        return positions, velocities, accelerations

    def _check_column_order(self, group: JointGroup, field: str) -> None:
        """Check that columns beside a polynomial, which has the group's, are not named otherwise.

        Raises:
            ProblemInvalid: They are.
        """
        for name, given, expected in (
            ("joint_names", self.joint_names, group.position_names),
            ("velocity_names", self.velocity_names, group.velocity_names),
        ):
            if given is not None and tuple(given) != expected:
                message = f"{field}.{name}: beside a `polynomial` they must be {list(expected)}"
                evidence = {"field": f"{field}.{name}", "names": list(expected)}
                raise ProblemInvalid(message, evidence)


def _check_not_floating(group: JointGroup, field: str) -> None:
    """Check that samples say how every joint moves between them.

    Raises:
        ProblemInvalid: A joint floats.
    """
    floating = [joint.name for joint in group.joints if joint.type is JointType.FLOATING]
    if floating:
        message = f"{field}: samples do not say how {floating} turn between them; give the "
        raise ProblemInvalid(message + "`polynomial`", {"field": f"{field}.polynomial"})


def _columns(
    rows: Sequence[Sequence[float]],
    count: int,
    names: tuple[Sequence[str] | None, Sequence[str]],
    field: str,
) -> Array:
    """Return rows with their columns in another order.

    Args:
        rows: One for each instant.
        count: How many instants there are.
        names: Of the columns as given, None for those that are expected; and as expected.
        field: Name of the rows in the request.
    """
    given, expected = names
    if len(rows) != count or any(len(row) != len(expected) for row in rows):
        message = f"{field}: {count} rows of {len(expected)} numbers are needed"
        raise ProblemInvalid(message, {"field": field, "names": list(expected)})
    order = list(range(len(expected)))
    if given is not None:
        for name in given:
            if name not in expected:
                raise UnknownName.among("joint", name, expected)
        if sorted(given) != sorted(expected):
            message = f"{field}: each of {list(expected)} must be named once"
            raise ProblemInvalid(message, {"field": f"{field.rpartition('.')[0]}.joint_names"})
        order = [given.index(name) for name in expected]
    return np.array(rows, dtype=np.float64)[:, order]
