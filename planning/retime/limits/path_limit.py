"""PathLimit: what limits a motion along a path besides the limits of its joints.

Along a path r(s) with x = sdot^2 and u = sddot, the rate of anything that depends on q is linear in
u and x. A limit tells the retimer that as inequalities on cells of the path, and says afterwards of
the timed motion by what factor it must be slowed to keep the limit everywhere: cells are looked at
in a few places only, the motion between them too.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.curves.curve import Curve, JointSpline, TimedTrajectory
from planning.domain.request.deadline import Deadline

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Motions stay this share below a path limit, so that a proof needs few samples.
HEADROOM = 2e-3


@dataclass(frozen=True)
class PathUtilization:
    """How much of a limit a motion uses.

    Attributes:
        where: The frame or joint that is limited.
        factor: The motion that takes this many times as long keeps the limit with `HEADROOM` to
            spare, and no more; below 1 if it could be quicker.
        share: Peak over limit of the motion that takes so many times as long.
    """

    where: str
    factor: float
    share: Callable[[float], float]

    @classmethod
    def of_rate(
        cls, where: str, fraction: float, order: int, headroom: float = HEADROOM
    ) -> "PathUtilization":
        """Build from peak over limit of something that falls with a power of the duration."""
        factor = (fraction * (1 + headroom)) ** (1 / order)
        return cls(where, factor, lambda slower: fraction / slower**order)

    def slowed(self, factor: float) -> "PathUtilization":
        """Return the use of the motion that takes so many times as long."""
        return PathUtilization(
            self.where, self.factor / factor, lambda more: self.share(factor * more)
        )


@runtime_checkable
class PathLimit(Protocol):
    """A limit on a motion along a path.

    Attributes:
        name: Of its kind, such as "tool_speed": key of `RetimeReport.utilisation`, and what the
            certificate's check begins with.
        is_uniform: Whether it demands the same all along a straight line in joint space, so that a
            line may stay one cell; its rows have b = 0 there.
    """

    @property
    def name(self) -> str:
        """Of its kind."""
        ...

    @property
    def is_uniform(self) -> bool:
        """Whether a straight line in joint space may stay one cell."""
        ...

    def cuts(self, stretch: JointSpline) -> Float64[np.ndarray, " m"]:
        """Return parameters where what is demanded jumps: cells shall meet there. Often none."""
        ...

    def rows(self, cells: JointSpline) -> tuple[Array, Array]:
        """Return a and b of a u + b x <= 1 on every cell, each shape (cells, rows).

        u is constant on a cell and x is that at its beginning; `path_rows.CellPlaces` makes such
        rows from those at places in the cells. A limit a u + b x <= c is divided by c, which must
        be positive: standing still must be allowed.

        Raises:
            RetimingFailed: It is not.
        """
        ...

    def caps(self, cells: JointSpline) -> Float64[np.ndarray, "cells 2"]:
        """Return bounds on x at both ends of every cell; infinite where there is none."""
        ...

    def uses(self, trajectory: TimedTrajectory) -> tuple[PathUtilization, ...]:
        """Return how much of it a motion uses, at all instants, with `HEADROOM` to spare.

        Raises:
            RetimingFailed: No slowing down helps.
        """
        ...

    def shares(
        self, curve: Curve, times: Float64[np.ndarray, " m"]
    ) -> Mapping[str, Float64[np.ndarray, " m"]]:
        """Return value over limit at instants of a motion, by what is limited; to explain it."""
        ...

    def relaxed(self, where: str, factor: float) -> "PathLimit":
        """Return the limit with so many times as much allowed there, if it limits that."""
        ...


@runtime_checkable
class PeakLimit(Protocol):
    """A path limit that bounds the norm of some rate, so that ruckig can be told of it as well."""

    def peaks(self, cells: JointSpline) -> Float64[np.ndarray, "6 cells rates"]:
        """Return on every cell what `speed_plan` wants of each rate.

        The largest |r'| over the limits of velocity, acceleration and jerk, |r''| over those of
        acceleration and jerk, |r'''| over that of jerk; zero where there is no such limit.
        """
        ...


def uses_of(
    path_limits: Sequence[PathLimit], trajectory: TimedTrajectory, deadline: Deadline
) -> list[tuple[str, PathUtilization]]:
    """Return how much of all limits a motion uses, by their names.

    Raises:
        RetimingFailed: No slowing down helps.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    found: list[tuple[str, PathUtilization]] = []
    for limit in path_limits:
        deadline.check("retime")
        found += [(limit.name, use) for use in limit.uses(trajectory)]
    return found


def rows_of(
    path_limits: Sequence[PathLimit], cells: JointSpline, deadline: Deadline
) -> list[tuple[Array, Array]]:
    """Return the rows of all limits on the same cells.

    Raises:
        RetimingFailed: One does not allow to stand still.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    found: list[tuple[Array, Array]] = []
    for limit in path_limits:
        deadline.check("retime")
        found.append(limit.rows(cells))
    return found
