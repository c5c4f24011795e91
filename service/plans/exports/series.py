"""Series: the numbers of the plots: a motion, its rates, efforts, distances and limits."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Self

import numpy as np
from pydantic import BeforeValidator, ConfigDict, Field

from planning.domain.arrays import Array
from service.api.arrays import FiniteOrNull, Row, Rows
from service.api.models import ResponseModel

if TYPE_CHECKING:  # the server imports no engine
    from planning.api.motion_series import MotionSeries

type Bound = Annotated[list[FiniteOrNull], Field(description="Bound per coordinate; null for none")]


def _finite(values: object) -> object:
    is_array = isinstance(values, np.ndarray)
    return [float(v) if np.isfinite(v) else None for v in values] if is_array else values


type Measured = Annotated[list[float | None], BeforeValidator(_finite)]


class Bounds(ResponseModel):
    """Bounds on the coordinates of a quantity; a block is limited by its norm."""

    model_config = ConfigDict(title="SeriesBounds")

    lower: Bound
    upper: Bound

    @classmethod
    def from_rows(cls, lower: Iterable[float], upper: Iterable[float]) -> Self:
        """Return bounds; what is infinite is none."""
        return cls(lower=[float(x) for x in lower], upper=[float(x) for x in upper])


class Series(ResponseModel):
    """A motion at equal time steps, as the plots draw it."""

    model_config = ConfigDict(title="MotionSeries")

    times: Row = Field(description="Instants [s]")
    position_names: list[str] = Field(description="A name per position coordinate")
    velocity_names: list[str] = Field(description="A name per velocity coordinate")
    positions: Rows = Field(description="Positions, one row per instant [rad or m]")
    velocities: Rows = Field(description="Velocities, one row per instant [rad/s or m/s]")
    accelerations: Rows = Field(description="Accelerations, one row per instant [rad/s^2 or m/s^2]")
    jerks: Rows = Field(
        description="Jerks between the jumps of acceleration, one row per "
        "instant [rad/s^3 or m/s^3]"
    )
    torques: Rows = Field(
        description="Torques or forces by inverse dynamics, one row per instant [N m or N]"
    )
    acceleration_jumps: Row = Field(
        description="Instants at which acceleration jumps, so that jerk is infinite [s]"
    )
    limits: dict[str, Bounds] = Field(
        description="Scaled limits that the plan was to keep: of `position`, `velocity`, "
        "`acceleration`, `torque`, and of `jerk` if it is limited"
    )
    tool_speeds: dict[str, Row] = Field(
        description="Speed of the tool frame and of every frame that is limited, by frame [m/s]"
    )
    utilisation: dict[str, Row] = Field(
        description="Share of each limit that the coordinate uses which uses most, by the "
        "name of its check [1]; `torque` whether it is limited or not"
    )
    clearance: Measured | None = Field(
        default=None,
        description="Smallest distance of any two bodies, at most half a metre above the "
        "margin [m]; null unless `distances` asks for it",
    )
    closest_pairs: list[tuple[str, str]] | None = Field(
        default=None, description="The two bodies of each clearance, or two empty names"
    )

    @classmethod
    def from_series(cls, series: "MotionSeries", *, distances: bool) -> Self:
        """Return the model of a series.

        Args:
            series: Samples of a motion.
            distances: Whether its distances were measured.
        """
        velocities, accelerations, jerks = series.derivatives
        used = {name: values.max(axis=1) for name, values in series.utilisation.items()}
        return cls.model_validate({
            "times": series.times,
            "position_names": series.group.position_names,
            "velocity_names": series.group.velocity_names,
            "positions": series.positions,
            "velocities": velocities,
            "accelerations": accelerations,
            "jerks": jerks,
            "torques": series.efforts,
            "acceleration_jumps": series.acceleration_jumps,
            "limits": _limits(series),
            "tool_speeds": series.tool_speeds,
            "utilisation": {n: row for n, row in used.items() if np.isfinite(row).all()},
            "clearance": series.clearance if distances else None,
            "closest_pairs": series.closest_pairs if distances else None,
        })


def _limits(series: "MotionSeries") -> dict[str, Bounds]:
    limits = series.limits
    rates = {"velocity": limits.velocity, "torque": limits.effort}
    if series.is_jerk_limited:
        rates["jerk"] = limits.jerk
    found = {
        "position": Bounds.from_rows(limits.lower, limits.upper),
        "acceleration": Bounds.from_rows(*series.acceleration_range),
    }
    for name, bound in rates.items():
        row = _per_coordinate(series, bound)
        found[name] = Bounds.from_rows(-row, row)
    return found


def _per_coordinate(series: "MotionSeries", bound: Array) -> Array:
    row = np.zeros(series.derivatives.shape[2])
    for block, value in zip(series.limits.blocks, bound, strict=True):
        row[list(block)] = value
    return row
