"""PathLimit: a limit on a motion along a path other than joint limits; interface for retimers.

Along a path r(s) with x = sdot^2 and u = sddot, the rate of any function of q is linear in u and x.
A limit gives the retimer inequalities on cells of the path, and afterwards the factor by which the
timed motion must be slowed to keep the limit everywhere: cells are evaluated at a few parameters
only, the audit of the motion covers those between.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import Curve, JointSpline, TimedTrajectory
from planning.domain.request.deadline import Deadline

# Relative reserve of motions to a path limit, so that a proof needs few samples.
HEADROOM = 2e-3


@dataclass(frozen=True)
class PathUtilization:
    """Utilization of a limit by a motion.

    Attributes:
        where: The limited frame or joint.
        time_scaling: Smallest time scaling that keeps the limit with `HEADROOM` in reserve; below 1
            if the motion could be faster.
        fraction_at: Peak over limit as a function of the time scaling.
    """

    where: str
    time_scaling: float
    fraction_at: Callable[[float], float]

    @classmethod
    def of_rate(
        cls, where: str, fraction: float, order: int, headroom: float = HEADROOM
    ) -> "PathUtilization":
        """Build from peak over limit of a rate, which scales with a power of the duration."""
        time_scaling = (fraction * (1 + headroom)) ** (1 / order)
        return cls(where, time_scaling, lambda slowdown: fraction / slowdown**order)

    def slowed(self, time_scaling: float) -> "PathUtilization":
        """Return the utilization after scaling the motion's time by a factor."""
        return PathUtilization(
            self.where,
            self.time_scaling / time_scaling,
            lambda additional_scaling: self.fraction_at(time_scaling * additional_scaling),
        )


@runtime_checkable
class PathLimit(Protocol):
    """A limit on a motion along a path (interface).

    Attributes:
        name: Kind of limit, such as "tool_speed": key of `RetimeReport.utilisation`, and first word
            of the certificate's check.
        is_uniform: Whether the limit is constant along a straight line in joint space, so that a
            line may stay one cell; its rows have b = 0 there.
    """

    @property
    def name(self) -> str:
        """Kind of limit."""
        ...

    @property
    def is_uniform(self) -> bool:
        """Whether a straight line in joint space may stay one cell."""
        ...

    def discontinuities(self, smooth_piece: JointSpline) -> Float64[np.ndarray, " m"]:
        """Return parameters at which the limit jumps: cells need edges there. Often empty."""
        ...

    def rows(self, cells: JointSpline) -> tuple[Array, Array]:
        """Return a and b of a u + b x <= 1 on every cell, each shape (cells, rows).

        u is constant on a cell and x is the value at its beginning; `path_rows.CellSamples`
        converts rows at other parameters of the cells. A limit a u + b x <= c is divided by c,
        which must be positive: rest must be admissible.

        Raises:
            RetimingFailed: Rest is not admissible.
        """
        ...

    def path_velocity_bounds(self, cells: JointSpline) -> Float64[np.ndarray, "cells 2"]:
        """Return bounds on x at both ends of every cell; infinite without a bound."""
        ...

    def utilizations(self, trajectory: TimedTrajectory) -> tuple[PathUtilization, ...]:
        """Return the utilization by a motion, at all instants, with `HEADROOM` in reserve.

        Raises:
            RetimingFailed: No slowing down helps.
        """
        ...

    def sampled_utilization(
        self, curve: Curve, times: Float64[np.ndarray, " m"]
    ) -> Mapping[str, Float64[np.ndarray, " m"]]:
        """Return value over limit at instants of a motion, by limited object; for explanations."""
        ...

    def relaxed(self, where: str, factor: float) -> "PathLimit":
        """Return the limit multiplied by a factor for one object, if it limits that."""
        ...


@runtime_checkable
class PeakLimit(Protocol):
    """A path limit that bounds the norm of a rate, so that the ruckig retimer can use it, too."""

    def peaks(self, cells: JointSpline) -> Float64[np.ndarray, "6 cells rates"]:
        """Return derivative bounds of each rate on every cell, relative to limits, for `speed_dp`.

        The largest |r'| over the limits of velocity, acceleration and jerk, |r''| over those of
        acceleration and jerk, |r'''| over that of jerk; zero where there is no such limit.
        """
        ...


def path_limit_utilizations(
    path_limits: Sequence[PathLimit], trajectory: TimedTrajectory, deadline: Deadline
) -> list[tuple[str, PathUtilization]]:
    """Return the names of all limits with their utilization by a motion.

    Raises:
        RetimingFailed: No slowing down helps.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    utilizations: list[tuple[str, PathUtilization]] = []
    for limit in path_limits:
        deadline.check("retime")
        utilizations += [
            (limit.name, utilization) for utilization in limit.utilizations(trajectory)
        ]
    return utilizations


def path_limit_rows(
    path_limits: Sequence[PathLimit], cells: JointSpline, deadline: Deadline
) -> list[tuple[Array, Array]]:
    """Return the rows of all limits on the same cells.

    Raises:
        RetimingFailed: A limit does not allow rest.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    rows: list[tuple[Array, Array]] = []
    for limit in path_limits:
        deadline.check("retime")
        rows.append(limit.rows(cells))
    return rows
